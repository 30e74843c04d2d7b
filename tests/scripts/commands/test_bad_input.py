"""Bad input: one line that says what and why, exit code 2, and nothing written or lost."""

import errno
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarbed import cli
from sonarbed.cli import main


@pytest.fixture(autouse=True)
def files(tmp_path, rng):
    """A good log, bad ones made from it, and things in the way."""
    # Of a robot that goes round in the middle of a room.
    random_log(rng, 80, ring=sm.AMIGOBOT, truth=True).write("good.parquet")
    make_log(1.0).write("real.parquet")
    whole = Path("good.parquet").read_bytes()
    Path("truncated.parquet").write_bytes(whole[: len(whole) // 2])
    Path("text.parquet").write_text("hello")
    Path("nothing.parquet").touch()

    table = pq.read_table("good.parquet")

    def change(name, column, values):
        index = table.column_names.index(column)
        pq.write_table(table.set_column(index, column, pa.array(values)), f"{name}.parquet")

    range_m = table["range_m"].to_numpy().copy()
    for name, bad in (("nan", np.nan), ("negative", -1.0), ("absurd", 1e6)):
        range_m[5] = bad
        change(name, "range_m", range_m)
    change("backwards", "time_s", table["time_s"].to_numpy()[::-1])
    pq.write_table(table.drop_columns(["x_m"]), "column.parquet")
    pq.write_table(table.slice(0, 0), "empty.parquet")
    pq.write_table(table.replace_schema_metadata({}), "foreign.parquet")

    grid = sm.GridSpec(0.5, (-1.0, -1.0), (8, 8))
    sm.OccupancyMap(grid, np.zeros(grid.shape)).save("map")
    sm.OccupancyMap(sm.GridSpec(0.5, (90.0, 90.0), (2, 2)), np.zeros((2, 2))).save("far")
    Path("file").touch()
    Path("bad.toml").write_text("title = 'x'\nwalls = 3\n")
    Path("no.toml").write_text("]][")


def state(folder):
    """Return the bytes of every file below a folder, and None for each folder."""
    return {path: path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


# Command line, what its complaint must say.
REFUSED = [
    # Logs.
    ("map gone.parquet --out new", "gone.parquet: no such file"),
    ("map truncated.parquet --out new", "truncated.parquet: is not a readable Parquet file"),
    ("map text.parquet --out new", "text.parquet: is not a readable Parquet file"),
    ("map nothing.parquet --out new", "nothing.parquet: is not a readable Parquet file"),
    ("map map --out new", "map: is not a readable Parquet file"),
    ("map foreign.parquet --out new", "foreign.parquet: is a Parquet file but not a sonar log"),
    ("map empty.parquet --out new", "empty.parquet: the log is empty"),
    ("map column.parquet --out new", "column.parquet: column 'x_m' is missing"),
    ("map nan.parquet --out new", "nan.parquet: range_m[5] must be within [0, 20] m"),
    ("map negative.parquet --out new", "range_m[5] must be within [0, 20] m, +inf or -inf, got -1"),
    ("map absurd.parquet --out new", "range_m[5] must be within [0, 20] m"),
    ("map backwards.parquet --out new", "backwards.parquet: time_s[1] must be not less"),
    # Numbers and names of a map.
    ("map good.parquet --out new --model x", "Invalid value for '--model'"),
    ("map good.parquet --out new --resolution 0", "resolution_m must be > 0, got 0.0"),
    ("map good.parquet --out new --resolution nan", "resolution_m must be > 0, got nan"),
    ("map good.parquet --out new --resolution 1e-9", "shape must have at most"),
    ("map good.parquet --out new --beta-deg 0", "--beta-deg must be > 0 and <= 60, got 0"),
    ("map good.parquet --out new --beta-deg 90", "--beta-deg must be > 0 and <= 60, got 90"),
    ("map good.parquet --out new --beta-deg nan", "--beta-deg must be > 0 and <= 60, got nan"),
    ("map good.parquet --out new --tolerance 0", "--tolerance must be > 0, got 0.0"),
    ("map good.parquet --out new --max-occupied 1.2", "--max-occupied must be > 0.5 and <= 1"),
    ("map good.parquet --out new --max-range -1", "max_range_m must be > 0, got -1.0"),
    ("map good.parquet --out new --p1 0.7", "p1 must be in [0, 0.5), got 0.7"),
    ("map good.parquet --out new --model standard --p2 0.1", "belong to --model parameterized"),
    ("map good.parquet --out new --no-echo x", "no_echo 'x' is unknown; known: clear, ignore"),
    ("map good.parquet --out new --poses x", "poses 'x' is unknown; known: odometry, true"),
    ("map real.parquet --out new --poses true", "the log has no truth"),
    # Places that cannot be written.
    ("map good.parquet --out file", "file: cannot be made a folder: a file is in the way"),
    ("map good.parquet --out file/new", "cannot be made a folder: a file is in the way"),
    ("map good.parquet --out new --png map", "map: the file's name must end with .png"),
    ("map good.parquet --out new --png a.jpg", "a.jpg: the file's name must end with .png"),
    ("map good.parquet --out new --png file/a.png", "a file is in the way"),
    # Names that say another format than a log has.
    ("simulate office --out a.csv --scans 2", "a.csv: a log is a Parquet file: its name must end"),
    ("simulate office --out log-0.5 --scans 2", "log-0.5: a log is a Parquet file"),
    ("hsr good.parquet --out a.csv", "a.csv: a log is a Parquet file"),
    ("filter good.parquet --method stale --out a.json", "`sonarbed export` writes other formats"),
    ("import a b --format udacity --out a.txt", "a.txt: a log is a Parquet file"),
    ("simulate office --out map --scans 2", "map: is a folder, a file name is needed"),
    ("simulate office --out file/a.parquet --scans 2", "a file is in the way"),
    ("simulate office --out file --seed 0:2 --scans 2", "a file is in the way"),
    ("worlds office --png file/a.png", "a file is in the way"),
    ("demo --out file --scans 2", "file: cannot be made a folder: a file is in the way"),
    ("import a b --format udacity --out map", "map: is a folder, a file name is needed"),
    # Rooms.
    ("worlds offise", "unknown world 'offise'; did you mean 'office'?"),
    ("worlds bad.toml", "bad.toml: walls: unknown key"),
    ("worlds no.toml", "no.toml: is not TOML"),
    ("worlds gone.toml", "gone.toml: no such file"),
    ("worlds --png a.png", "--png needs the name of a room"),
    ("worlds office --set gap=1", "unknown parameter 'gap'"),
    ("worlds opening-rig --set gap_m", "--set must be NAME=NUMBER, got 'gap_m'"),
    ("worlds opening-rig --set gap_m=x", "--set must be NAME=NUMBER, got 'gap_m=x'"),
    ("worlds opening-rig --set gap_m=", "--set must be NAME=NUMBER, got 'gap_m='"),
    ("worlds opening-rig --set =0.6", "--set must be NAME=NUMBER, got '=0.6'"),
    ("worlds opening-rig --set=", "--set must be NAME=NUMBER, got ''"),
    ("worlds opening-rig --set reader=1", "--set must be NAME=NUMBER, got 'reader=1'"),
    ("worlds opening-rig --set gap_m=0.6 --set gap_m=0.7", "--set gap_m is given twice"),
    ("simulate opening-rig --set gap_m=1 --set gap_m=1 --out a", "--set gap_m is given twice"),
    ("worlds opening-rig --set gap_m=1e9", "parameter gap_m must be within"),
    ("worlds opening-rig --set gap_m=-inf", "parameter gap_m must be a finite number, got -inf"),
    ("worlds opening-rig --set gap_m=nan", "parameter gap_m must be a finite number, got nan"),
    ("worlds opening-rig --set gap_m=50", "parameter gap_m must be within"),
    ("demo --world nowhere", "unknown world 'nowhere'"),
    # Drives.
    ("simulate nowhere --out a.parquet", "unknown world 'nowhere'"),
    ("simulate office --out a.parquet --driver rout", "driver 'rout' is unknown; did you mean"),
    (
        "simulate office --out a.parquet --sonar x",
        "sonar 'x' is unknown; known: aria, physical, thesis, webots",
    ),
    ("simulate office --out a.parquet --engine x", "engine 'x' is unknown"),
    ("simulate office --out a.parquet --scans 0", "scans must be >= 1, got 0"),
    ("simulate office --out a.parquet --scans -3", "scans must be >= 1, got -3"),
    ("simulate office --out a.parquet --scans x", "Invalid value for '--scans'"),
    ("simulate thesis-exp1 --out a.parquet --driver route", "route"),
    (
        "simulate office --out a --seed 5:2",
        "--seed must be a whole number >= 0 or a range such as 0:20",
    ),
    ("simulate office --out a --seed x", "got 'x'"),
    ("simulate office --out a --seed 1e3", "--seed must be a whole number >= 0"),
    ("simulate office --out a --seed 1.5", "got '1.5'"),
    ("simulate office --out a --seed nan", "got 'nan'"),
    ("simulate office --out a --seed 1_0", "got '1_0'"),
    ("simulate office --out a --seed=", "got ''"),
    ("simulate office --out a --seed 0:2:3", "got '0:2:3'"),
    ("simulate office --out a --seed 0:2 --jobs 1000000", "jobs must be <= "),
    ("simulate office --out a --scans 1000000000", "scans must be <= 10000000"),
    ("simulate office --out a --scans 1e9", "Invalid value for '--scans'"),
    ("simulate office --out a --scans nan", "Invalid value for '--scans'"),
    ("simulate office --out a --scans=", "Invalid value for '--scans'"),
    ("simulate office --out new/folder/a --scans 0", "scans must be >= 1, got 0"),
    ("demo --scans 1000000000", "scans must be <= 10000000"),
    ("demo --seed=-1", "seed must be >= 0, got -1"),
    ("demo --driver rout", "driver 'rout' is unknown; did you mean 'route'?"),
    ("tune --scans 1000000000", "scans must be <= 10000000"),
    ("tune --max-range nan", "max_range_m must be > 0, got nan"),
    ("thesis --jobs 1000000", "jobs must be <= "),
    ("acoustics --jobs 0", "jobs must be >= 1, got 0"),
    ("simulate office --out a --seed 3:", "got '3:'"),
    ("simulate office --out a --seed=-1", "got '-1'"),
    ("simulate office --out a --seed=-1:3", "got '-1:3'"),
    ("simulate office --out a --seed 0:99999999999", "--seed must be at most 10000 seeds"),
    ("simulate office --out a --seed 0:2 --jobs 0", "jobs must be >= 1, got 0"),
    ("simulate office --out a --seed 0:2 --gui", "--gui shows one drive: give one seed"),
    ("demo --scans 0 --out a", "scans must be >= 1, got 0"),
    ("demo --seed -1 --out a", "seed must be >= 0, got -1"),
    # Scores.
    ("score gone --world office", "gone: no such file"),
    ("score good.parquet --world office", "good.parquet: is not a sonarbed map"),
    ("score map --world nowhere", "unknown world 'nowhere'"),
    ("score far --world office", "grid must hold the start"),
    ("score map --world thesis-exp1 --align", "--align compares the readings with the room"),
    ("score map --world thesis-exp1 --log real.parquet --align", "at least 30 readings with an"),
    # Replays.
    ("replay gone.parquet --world office", "gone.parquet: no such file"),
    ("replay good.parquet --world nowhere", "unknown world 'nowhere'"),
    ("replay good.parquet --world thesis-exp1 --sonar thesi", "did you mean 'thesis'"),
    ("replay good.parquet --world thesis-exp1 --poses gps", "poses 'gps' is unknown"),
    ("replay good.parquet --world thesis-exp1 --align --poses true", "--poses must not be true"),
    ("replay good.parquet --world thesis-exp1 --png a.jpg", "must end with .png"),
    ("replay good.parquet --world thesis-exp1 --out a.csv", "a log is a Parquet file"),
    ("replay real.parquet --world thesis-exp1 --poses true", "the log has no truth"),
    ("score map --world thesis-exp1 --log gone.parquet", "gone.parquet: no such file"),
    # Imports.
    ("import gone.csv --format aria --ring amigobot --out a", "gone.csv: no such file"),
    ("import text.parquet --format aria --ring amigobot --out a", "text.parquet:1: column 'hello'"),
    ("import gone.csv --format arya --ring amigobot --out a", "did you mean 'aria'?"),
    ("import gone.csv --format aria --ring amigo --out a", "ring 'amigo' is unknown"),
    ("import gone.csv --format udacity --out a", "must get 2 files"),
    # Usage.
    ("maps", "No such command 'maps'"),
    ("map", "Missing argument 'log'; see 'sonarbed map --help'"),
    ("simulate office", "Missing option '--out'; see 'sonarbed simulate --help'"),
    ("score map --wrld office", "No such option: --wrld"),
    ("worlds a b", "unexpected extra argument"),
]


@pytest.mark.engine
@pytest.mark.parametrize(("line", "complaint"), REFUSED, ids=[line for line, _ in REFUSED])
def test_bad_input_is_refused_in_one_line_and_nothing_changes(refused, tmp_path, line, complaint):
    before = state(tmp_path)
    assert complaint in refused(line)
    assert state(tmp_path) == before


@pytest.mark.parametrize(
    ("provenance", "complaint"),
    [
        ({"world": "office"}, "must be of the world 'opening-rig', got one of 'office'"),
        (
            {"world": "opening-rig", "world_parameters": {"gap_m": 0.6}},
            "with gap_m = 0.6, not 0.8: give --set gap_m=0.6",
        ),
    ],
)
def test_the_log_of_another_room_is_not_scored(run, refused, provenance, complaint):
    sm.read_log("good.parquet").replace(provenance=provenance).write("drive.parquet")
    grid = sm.GridSpec(0.1, (-4.0, -3.4), (74, 80))
    sm.OccupancyMap(grid, np.zeros(grid.shape)).save("map")
    assert complaint in refused("score map --world opening-rig --log drive.parquet")
    run("score map --world opening-rig")


def full_disk(*args, **kwargs):
    raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.engine
def test_a_full_disk_is_one_line_and_keeps_the_older_log(refused, tmp_path, monkeypatch):
    before = state(tmp_path)
    monkeypatch.setattr("sonarmap.parquet.pq.write_table", full_disk)
    complaint = refused("simulate thesis-exp1 --scans 2 --out good.parquet")
    assert complaint == "good.parquet: cannot be written: No space left on device"
    assert state(tmp_path) == before


def test_a_full_disk_keeps_the_older_map(refused, tmp_path, monkeypatch):
    before = state(tmp_path)
    monkeypatch.setattr("sonarmap.occupancy.np.savez_compressed", full_disk)
    assert "No space left on device" in refused("map good.parquet --out map")
    assert state(tmp_path) == before


def test_an_error_of_the_system_that_nobody_expected_is_one_line(refused, monkeypatch):
    monkeypatch.setattr("sonarmap.read_log", full_disk)
    assert refused("map good.parquet --out new") == "output: No space left on device"


def test_an_error_of_ours_keeps_its_traceback(monkeypatch):
    def broken(*args, **kwargs):
        raise ValueError("a bug")

    monkeypatch.setattr("sonarmap.build_map", broken)
    with pytest.raises(ValueError, match="a bug"):
        main(["map", "good.parquet", "--out", "new"])


def test_exit_codes_are_those_of_shells():
    assert (cli.BAD_INPUT, cli.INTERRUPTED) == (2, 130)
