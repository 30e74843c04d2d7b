"""`sonarbed hsr`: the same as the function, with a table and a picture of what changed."""

import json

import numpy as np
import pytest
from PIL import Image
from support import make_log, random_log

import sonarmap as sm


@pytest.fixture(autouse=True)
def logs(in_tmp_path, rng):
    """A log with truth, the same of a real robot, and one whose readings are all alike."""
    log = random_log(rng, 300, ring=sm.AMIGOBOT, truth=True)
    log.write("drive.parquet")
    log.replace(truth=None).write("real.parquet")
    make_log([np.inf, -np.inf], ring=sm.AMIGOBOT).write("silent.parquet")


def rows_of(table):
    """Return the cells of printed tables, without their headers."""
    lines = [line for line in table.splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in line.strip("│").split("│")] for line in lines]


def assert_is_a_picture(path):
    with Image.open(path) as image:
        assert image.format == "PNG"
        pixels = np.asarray(image.convert("L"))
    assert min(pixels.shape) >= 250
    assert pixels.std() > 5


def test_it_is_the_function_with_the_thesis_parameters_for_openings(run, tmp_path):
    old = (tmp_path / "drive.parquet").read_bytes()
    told = json.loads(run("hsr drive.parquet --out new/hsr.parquet --json"))
    before, after = sm.read_log("drive.parquet"), sm.read_log("new/hsr.parquet")
    result = sm.hsr(before, sm.HsrParams(0.01, 0.08, 0.8, 0.06, 0.01, 20))
    assert sm.HsrParams.thesis_openings() == sm.HsrParams(0.01, 0.08, 0.8, 0.06, 0.01, 20)
    assert sm.HsrParams.thesis() == sm.HsrParams(0.02, 0.15, 3.0, 0.06, 0.01, 20)

    np.testing.assert_array_equal(after.range_m, result.log.range_m)
    assert after.provenance == result.log.provenance
    assert (tmp_path / "drive.parquet").read_bytes() == old
    assert told["file"] == "new/hsr.parquet"
    assert told["updated"] == result.updated.sum() > 0
    assert told["updates_per_pass"] == list(result.updates_per_pass)
    assert told["rejected_updates"] == result.rejected_updates
    assert told["stopped"] == str(result.stopped)
    score = sm.score_readings(before, result.log)
    assert told["score"] == json.loads(json.dumps(score.to_dict()))

    echo = result.updated & np.isfinite(before.range_m)
    assert told["updated_without_echo"] == (result.updated & np.isposinf(before.range_m)).sum() > 0
    shortening_m = np.median(before.range_m[echo] - after.range_m[echo])
    assert told["median_shortening_m"] == pytest.approx(shortening_m)


def test_every_option_reaches_the_parameters(run):
    told = json.loads(
        run(
            "hsr drive.parquet --out hsr.parquet --min-wall 0.03 --max-wall 0.11 --threshold 1.5 "
            "--target-distance 0.2 --cell 0.02 --max-passes 1 --json"
        )
    )
    params = sm.HsrParams(0.03, 0.11, 1.5, 0.2, 0.02, 1)
    result = sm.hsr(sm.read_log("drive.parquet"), params)
    np.testing.assert_array_equal(sm.read_log("hsr.parquet").range_m, result.log.range_m)
    assert told["stopped"] == "max passes"
    for name in ("min_wall_m", "max_wall_m", "threshold_m", "target_distance_m", "cell_m"):
        assert told["parameters"][name] == getattr(params, name)


def test_the_table_shows_the_numbers_of_the_json(run):
    told = json.loads(run("hsr drive.parquet --out hsr.parquet --json"))
    table = run("hsr drive.parquet --out hsr.parquet")
    rows = rows_of(table)
    for number, count in enumerate(told["updates_per_pass"], 1):
        assert [f"updated in pass {number}", str(count)] in rows
    assert ["stopped", told["stopped"]] in rows
    counts = told["score"]["counts"]
    assert ["number", str(counts["wrong"]), str(counts["right"])] in rows
    assert [
        "updated",
        f"{counts['wrong_updated']} ({counts['wrong_updated'] / counts['wrong']:.1%})",
        f"{counts['right_updated']} ({counts['right_updated'] / counts['right']:.1%})",
    ] in rows
    assert ["precision of the updates", f"{told['score']['precision']:.1%}", ""] in rows
    assert ["recall of the updates", f"{told['score']['recall']:.1%}", ""] in rows


def test_a_real_log_is_not_judged(run):
    told = json.loads(run("hsr real.parquet --out hsr.parquet --json"))
    assert told["score"] is None
    assert "by truth" not in run("hsr real.parquet --out hsr.parquet")


def test_no_update_at_all_is_told(run):
    make_log(0.7, ring=sm.AMIGOBOT).write("one.parquet")
    told = json.loads(run("hsr one.parquet --out hsr.parquet --json"))
    assert (told["updated"], told["median_shortening_m"]) == (0, None)
    assert told["stopped"] == "nothing changed"
    assert ["median shortening, of echoes", "-"] in rows_of(run("hsr one.parquet --out b.parquet"))


@pytest.mark.parametrize("log", ["drive", "real"])
def test_the_picture_is_one(run, log):
    assert "Drawn: hsr.png" in run(f"hsr {log}.parquet --out hsr.parquet --png hsr.png")
    assert_is_a_picture("hsr.png")


def test_a_long_corridor_has_a_picture_as_well(run, rng):
    n = 200
    make_log(
        rng.uniform(0.3, 1.0, n),
        ring=sm.AMIGOBOT,
        sonar=rng.integers(8, size=n),
        x_m=np.linspace(0, 40, n),
    ).write("corridor.parquet")
    run("hsr corridor.parquet --out hsr.parquet --png hsr.png")
    assert_is_a_picture("hsr.png")


# Command line, what its complaint must say.
REFUSED = [
    ("--min-wall 0.2 --max-wall 0.1", "min_wall_m must be <= max_wall_m, got 0.2 and 0.1"),
    ("--min-wall=-0.1", "min_wall_m must be >= 0, got -0.1"),
    ("--max-wall nan", "max_wall_m must be >= 0, got nan"),
    ("--threshold 3.5", "threshold_m must be <= the ring's range_max_m 3, got 3.5"),
    ("--threshold 0", "threshold_m must be > 0, got 0.0"),
    ("--threshold 0.001", "the log must have a reading up to threshold_m 0.001, got none in 300"),
    ("--target-distance=-1", "target_distance_m must be >= 0, got -1.0"),
    ("--cell 0", "cell_m must be > 0, got 0.0"),
    ("--cell 1e-7", "cell_m is too small for a log this wide"),
    ("--max-passes 0", "max_passes must be > 0, got 0"),
    ("--max-passes 1.5", "Invalid value for '--max-passes'"),
    ("--png a.jpg", "a.jpg: the file's name must end with .png"),
]


def state(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(("options", "complaint"), REFUSED)
def test_bad_parameters_are_refused_in_one_line(refused, tmp_path, options, complaint):
    before = state(tmp_path)
    assert complaint in refused(f"hsr drive.parquet --out hsr.parquet {options}")
    assert state(tmp_path) == before


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("hsr gone.parquet --out a.parquet", "gone.parquet: no such file"),
        ("hsr silent.parquet --out a.parquet", "got none in 2 readings"),
        ("hsr drive.parquet --out drive.parquet", "--out must be another file than the log"),
        ("hsr drive.parquet --out ./drive.parquet", "--out must be another file than the log"),
        ("hsr drive.parquet --out .", "is a folder, a file name is needed"),
        ("hsr drive.parquet --out real.parquet/a.parquet", "a file is in the way"),
        ("hsr drive.parquet", "Missing option '--out'"),
    ],
)
def test_bad_files_are_refused_in_one_line(refused, tmp_path, line, complaint):
    before = state(tmp_path)
    assert complaint in refused(line)
    assert state(tmp_path) == before


def test_what_is_not_used_is_counted_apart_and_the_numbers_agree(run, rng):
    log = random_log(rng, 300, ring=sm.AMIGOBOT, truth=True)
    told = json.loads(run("hsr drive.parquet --out hsr.parquet --json"))
    log = sm.read_log("drive.parquet")
    after = sm.read_log("hsr.parquet")
    account = told["account"]
    assert account["in_log"] == len(log) == account["used"] + sum(account["unused"].values())
    assert account["unused"]["stale"] == log.stale.sum() > 0
    assert account["unused"]["rejected"] == (log.rejected & ~log.stale).sum() > 0
    assert told["readings"] == log.usable.sum() == told["score"]["counts"]["readings"]
    # No stale or rejected reading is among the updated.
    changed = after.range_m != log.range_m
    assert told["updated"] == changed.sum() == (changed & log.usable).sum()
    rows = rows_of(run("hsr drive.parquet --out hsr.parquet"))
    assert ["readings of the log", str(len(log))] in rows
    assert ["not used: stale", str(account["unused"]["stale"])] in rows
    assert ["readings", str(told["readings"])] in rows


def test_what_it_spoiled_is_said_in_a_sentence(run):
    told = json.loads(run("hsr drive.parquet --out hsr.parquet --json"))["score"]
    text = run("hsr drive.parquet --out hsr.parquet")
    assert (
        f"Of the wrong readings {told['mended_share']:.1%} were mended; of the right ones "
        f"{told['spoiled_share']:.1%} were spoiled." in text
    )
    assert "spoiled" not in run("hsr real.parquet --out hsr.parquet")
