"""The main job: world -> simulate -> map -> score, file by file."""

import json

import numpy as np
import pytest
from PIL import Image

import sim
import sonarmap as sm
import worlds
from sonarbed.cli import main
from sonarbed.commands import demo
from sonarbed.console import score_rows
from sonarmap.account import account_by

pytestmark = pytest.mark.engine

BEST = demo._BEST
# The demo's maps: the folder, the name in the scores.
DEMO_MAPS = {
    "parameterized": "parameterized",
    "parameterized-hsr": "parameterized + HSR",
    BEST: BEST,
}


def is_a_picture(path):
    """Return whether a file is a picture of a sensible size with something on it."""
    with Image.open(path) as image:
        assert image.format == "PNG"
        pixels = np.asarray(image.convert("L"))
    return min(pixels.shape) >= 400 and pixels.std() > 5


def rows_of(table):
    """Return the cells of a printed table, without its header."""
    lines = [line for line in table.splitlines() if line.startswith("│")]
    return [[cell.strip() for cell in line.strip("│").split("│")] for line in lines]


def test_from_a_room_to_a_score(run, tmp_path):
    told = json.loads(
        run("simulate thesis-exp1 --scans 30 --seed 3 --out logs/drive.parquet --json")
    )
    log = sm.read_log("logs/drive.parquet")
    assert told["file"] == "logs/drive.parquet"
    assert told["seed"] == log.provenance["seed"] == 3
    assert told["readings"] == len(log) == sum(told["causes"].values()) == 240

    told = json.loads(run("map logs/drive.parquet --out map --png map.png --json"))
    built = sm.OccupancyMap.load("map")
    assert (told["rows"], told["cols"]) == built.grid.shape
    expected = sm.build_map(log, sm.ParameterizedModel.thesis(), built.grid)
    np.testing.assert_array_equal(built.log_odds, expected.log_odds)
    assert is_a_picture("map.png")

    told = json.loads(run("score map --world thesis-exp1 --log logs/drive.parquet --json"))
    truth = worlds.truth(worlds.load("thesis-exp1"), built.grid)
    score = sm.score_map(built, truth, observable=truth.observable(log))
    assert told.items() >= json.loads(json.dumps(score.to_dict())).items()

    files = {str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*") if p.is_file()}
    assert files == {
        "logs/drive.parquet",
        "map/map.npz",
        "map/map.pgm",
        "map/map.yaml",
        "map.png",
    }


def test_a_table_shows_the_numbers_of_the_json(run):
    run("simulate thesis-exp1 --scans 10 --out drive.parquet")
    run("map drive.parquet --out map")
    scores = json.loads(run("score map --world thesis-exp1 --json"))
    table = run("score map --world thesis-exp1")
    assert f"{scores['counts']['cells']} cells (not hidden)" in table
    assert rows_of(table) == score_rows({"map": scores})

    told = json.loads(run("simulate thesis-exp1 --scans 10 --out drive.parquet --json"))
    table = run("simulate thesis-exp1 --scans 10 --out drive.parquet")
    for cause, count in told["causes"].items():
        assert [cause.lower().replace("_", " "), str(count), f"{count / 80:.1%}"] in rows_of(table)


def test_options_of_a_map_reach_the_model(run):
    run("simulate thesis-exp1 --scans 10 --out drive.parquet")
    log = sm.read_log("drive.parquet")
    run(
        "map drive.parquet --model standard --resolution 0.04 --beta-deg 10 --tolerance 0.2 "
        "--max-occupied 0.9 --max-range 2 --no-echo clear --poses true --out map"
    )
    built = sm.OccupancyMap.load("map")
    assert built.grid.resolution_m == 0.04
    model = sm.StandardModel(np.deg2rad(10), 2.0, 0.9, 0.2)
    expected = sm.build_map(log, model, built.grid, max_range_m=2.0, no_echo="clear", poses="true")
    np.testing.assert_array_equal(built.log_odds, expected.log_odds)


def test_the_models_are_the_thesis_own_by_default(run):
    run("simulate thesis-exp1 --scans 2 --sonar thesis --out drive.parquet")
    for name, model in (
        ("standard", sm.StandardModel.thesis()),
        ("parameterized", sm.ParameterizedModel.thesis()),
    ):
        told = json.loads(run(f"map drive.parquet --model {name} --out map --json"))
        assert told["model"] == repr(model)


def test_the_same_seed_gives_the_same_bytes(run, tmp_path):
    for name in ("one", "two"):
        run(f"simulate office --driver wander --scans 8 --seed 5 --out {name}.parquet")
    assert (tmp_path / "one.parquet").read_bytes() == (tmp_path / "two.parquet").read_bytes()


def test_many_seeds_equal_single_drives(run, tmp_path):
    told = json.loads(
        run(
            "simulate opening-rig --set gap_m=0.6 --driver route --sonar aria --scans 6 "
            "--seed 0:3 --jobs 2 --out logs --json"
        )
    )
    folder = tmp_path / "logs"
    assert json.loads((folder / "manifest.json").read_text()) == told
    assert told["world"] == "opening-rig"
    assert told["world_parameters"]["gap_m"] == 0.6
    assert told["arguments"]["driver"] == "route"
    assert told["arguments"]["sonar"] == "aria"
    assert [entry["seed"] for entry in told["logs"]] == [0, 1, 2]
    assert {path.name for path in folder.iterdir()} == {
        "manifest.json",
        *(entry["file"] for entry in told["logs"]),
    }
    for entry in told["logs"]:
        single = json.loads(
            run(
                "simulate opening-rig --set gap_m=0.6 --driver route --sonar aria --scans 6 "
                f"--seed {entry['seed']} --out single.parquet --json"
            )
        )
        assert (folder / entry["file"]).read_bytes() == (tmp_path / "single.parquet").read_bytes()
        assert single["causes"] == entry["causes"]


def test_demo_writes_the_files_it_promises(run, tmp_path):
    table = run("demo --scans 12 --seed 2 --out demo")
    folder = tmp_path / "demo"
    files = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    maps = {f"map-{name}/map.{kind}" for name in DEMO_MAPS for kind in ("npz", "pgm", "yaml")}
    logs = {"log.parquet", "log-hsr.parquet"}
    assert files == {*logs, "truth.npz", "scores.json", "demo.png", *maps}
    assert is_a_picture(folder / "demo.png")

    world = worlds.load("office")
    log = sm.read_log(folder / "log.parquet")
    sim.simulate(world, scans=12, seed=2).write("again.parquet")
    assert (folder / "log.parquet").read_bytes() == (tmp_path / "again.parquet").read_bytes()
    scores = json.loads((folder / "scores.json").read_text())
    assert list(scores) == sorted([*DEMO_MAPS.values(), "blank sheet"])
    assert scores["blank sheet"]["skill"] == pytest.approx(0, abs=1e-9)
    mended = sm.filter("hsr").apply(log).log
    np.testing.assert_array_equal(sm.read_log(folder / "log-hsr.parquet").range_m, mended.range_m)
    truth = worlds.truth(world)
    with np.load(folder / "truth.npz") as saved:
        np.testing.assert_array_equal(saved["state"], truth.state)
    for place, name in DEMO_MAPS.items():
        score, built = scores[name], sm.OccupancyMap.load(folder / f"map-{place}")
        again = sm.score_map(built, truth, observable=truth.observable(log))
        assert score == json.loads(json.dumps(again.to_dict()))
        assert f"{score['brier']:.3f}" in table


def test_a_drive_that_ends_at_a_wall_says_so(run):
    line = "simulate thesis-exp1 --driver straight --out drive.parquet --scans"
    assert json.loads(run(f"{line} 5 --json"))["collision_scans"] == 0
    assert "touched" not in run(f"{line} 5")
    told = json.loads(run(f"{line} 80 --json"))
    log = sm.read_log("drive.parquet")
    assert told["collision_scans"] == np.unique(log.scan[log.truth.collision]).size > 0
    assert f"In {told['collision_scans']} scans the robot touched something" in run(f"{line} 80")


def test_packets_repeat_old_values_and_say_so(run):
    line = "simulate office --driver thesis --scans 60 --packets --engine segments --out p.parquet"
    told = json.loads(run(f"{line} --json"))
    log = sm.read_log("p.parquet")
    assert log.provenance["packets"]["period_s"] == 0.1
    # Packets are not scans, and what repeats an old value is no reading more.
    packets, new = np.unique(log.scan).size, int((~log.stale).sum())
    assert 0 < new < len(log)
    assert (told["scans"], told["packets"], told["readings"]) == (60, packets, len(log))
    assert told["account"] == {"in_log": len(log), "used": new, "unused": {"stale": len(log) - new}}
    assert sum(told["causes"].values()) == new
    assert told["no_echo"] == np.isposinf(log.range_m[~log.stale]).sum()
    assert told["too_close"] == np.isneginf(log.range_m[~log.stale]).sum() > 0
    touched = np.unique(log.scan[log.truth.collision & ~log.stale]).size
    assert told["collision_packets"] == touched > 0
    assert told["collision_share"] == touched / packets
    shown = run(line)
    assert f"1 x 60 scans in {packets} packets" in shown
    assert f"{new} of {len(log)} readings used; not used: {len(log) - new} stale." in shown
    assert f"In {touched} packets the robot touched something" in shown
    for name, count in (("all", new), *((n, told[n]) for n in ("no_echo", "too_close"))):
        assert [name.replace("_", " "), str(count), f"{count / new:.1%}"] in rows_of(shown)


def test_the_table_of_many_logs_is_the_sum_of_their_manifest(run):
    line = "simulate office --driver thesis --scans 40 --seed 0:2 --engine segments --out logs"
    logs = json.loads(run(f"{line} --json"))["logs"]
    shown = run(line)
    used = sum(entry["account"]["used"] for entry in logs)
    for name in ("no_echo", "too_close"):
        count = sum(entry[name] for entry in logs)
        assert [name.replace("_", " "), str(count), f"{count / used:.1%}"] in rows_of(shown)
    touched = sum(entry["collision_scans"] for entry in logs)
    assert f"In {touched} scans the robot touched something ({touched / 80:.1%} of" in shown


def test_who_maps_or_scores_a_drive_that_touched_something_is_told(run, capsys):
    run("simulate office --driver thesis --scans 60 --engine segments --sonar thesis --out d")
    log = sm.read_log("d")
    touched = np.unique(log.scan[log.truth.collision]).size
    sentence = f"In {touched} scans the robot touched something ({touched / 60:.1%} of the drive)"
    assert sentence in run("map d --out map")
    assert json.loads(run("map d --out map --json"))["collision_scans"] == touched > 0
    assert main(["score", "map", "--world", "office", "--log", "d", "--json"]) == 0
    out, err = capsys.readouterr()
    assert err.startswith(sentence)
    told = json.loads(out)
    assert told["collision_scans"] == touched
    assert told["notes"] == [err.strip()]
    shown = run("demo --world office --driver thesis --scans 60 --out demo")
    assert "the robot touched something" in shown
    # The default driver touches nothing.
    assert "touched" not in run("demo --world office --scans 20 --out demo")


def test_a_demo_says_what_became_of_the_readings(run):
    shown = run("demo --world office --scans 12 --out demo")
    method = sm.method("bayes-parameterized")
    for file in ("log", "log-hsr"):
        log = sm.read_log(f"demo/{file}.parquet")
        assert f"{account_by(log, method)}" in shown


def test_a_score_says_which_cells_it_judges(run):
    run("simulate office --scans 30 --engine segments --sonar thesis --out d")
    run("map d --out map")
    for line in ("score map --world office", "score map --world office --log d"):
        told = json.loads(run(f"{line} --json"))
        cells = told["cells"]
        assert cells["in_map"] == cells["used"] + sum(cells["unused"].values())
        assert cells["used"] == told["counts"]["cells"]
        assert f"{cells['used']} of {cells['in_map']} cells scored; not scored: " in run(line)
    assert set(cells["unused"]) == {"hidden", "never_observable"}
