"""Logs of real robots: imported, mapped, looked at."""

import json
import math

import numpy as np
import pytest
from support import REAL_LOG

import sonarmap as sm

MEASUREMENT = """\
1000 5110 1190 1000 1000 1000 1000 1000 1000
1250 2320 1190 1010 1010 1010 1010 1010 1010
"""
POSES = """\
1000 0 0 3590
1250 100 20 3600
"""
ARIA = """\
time_ms,x,y,heading,s0,s1,s2,s3,s4,s5,s6,s7
1000,0,0,0,5000,1190,1000,1000,1000,1000,1000,1000
1250,100,20,90,2320,1190,1010,1010,1010,1010,1010,1010
"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "measurement.txt").write_text(MEASUREMENT)
    (tmp_path / "poses.txt").write_text(POSES)
    (tmp_path / "drive.csv").write_text(ARIA)


UDACITY = "import measurement.txt poses.txt --format udacity --ring udacity8 --out log.parquet"


@pytest.mark.usefixtures("files")
def test_an_udacity_pair_becomes_a_log_with_its_repeats_marked(run):
    told = json.loads(run(f"{UDACITY} --json"))
    log = sm.read_log("log.parquet")
    assert told == {
        "file": "log.parquet",
        "scans": 2,
        "readings": 16,
        "seconds": 0.25,
        "no_echo": 1,
        "too_close": 0,
        "rejected": 0,
        "stale": 1,
        "used": 15,
    }
    assert log.ring == sm.ring("udacity8")
    assert log.truth is None
    assert math.isinf(log.range_m[0])
    assert log.range_m[8:10].tolist() == [2.32, 1.19]
    assert np.flatnonzero(log.stale).tolist() == [9]  # 1190 again
    shown = run(UDACITY)
    for name, value in told.items():
        (line,) = [line for line in shown.splitlines() if f" {name} " in line]
        assert line.split("│")[2].strip() == str(value)


@pytest.mark.usefixtures("files")
def test_repeats_are_kept_on_request(run):
    assert json.loads(run(f"{UDACITY} --keep-stale --json"))["stale"] == 0
    assert not sm.read_log("log.parquet").stale.any()


@pytest.mark.usefixtures("files")
def test_a_format_knows_its_own_ring_or_asks_for_one(run, refused):
    run("import measurement.txt poses.txt --format udacity --out log.parquet")
    assert sm.read_log("log.parquet").ring == sm.ring("udacity8")
    assert "needs the ring" in refused("import drive.csv --format aria --out other.parquet")


@pytest.mark.usefixtures("files")
def test_an_aria_table_becomes_a_log_and_a_map(run):
    run("import drive.csv --format aria --ring amigobot-aria --out log.parquet")
    log = sm.read_log("log.parquet")
    assert log.ring == sm.ring("amigobot-aria")
    np.testing.assert_allclose(log.heading_rad[[0, 8]], [0, math.pi / 2])
    np.testing.assert_allclose(log.x_m[[0, 8]], [0, 0.1])
    told = json.loads(run("map log.parquet --out map --json"))
    # The cone of the model is the ring's own unless told.
    assert f"p5_rad={log.ring.half_angle_rad}" in told["model"]
    assert sm.OccupancyMap.load("map").log_odds.any()


def test_ones_own_importer_is_found_in_the_folder_of_the_command(run, tmp_path):
    (tmp_path / "toy_robot.py").write_text(TOY, encoding="utf-8")
    (tmp_path / "toy.txt").write_text("1.5\n2.5\n")
    told = json.loads(run("import toy.txt --format toy_robot:read --out log.parquet --json"))
    assert told["readings"] == 2
    assert sm.read_log("log.parquet").range_m.tolist() == [1.5, 2.5]


TOY = """
import numpy as np
import sonarmap as sm


def read(paths, ring):
    range_m = np.loadtxt(paths[0], ndmin=1)
    still = np.zeros(range_m.size)
    steps = np.arange(range_m.size)
    return sm.SonarLog(ring or sm.AMIGOBOT, steps, still, steps, still, still, still, range_m)
"""


@pytest.mark.skipif(not REAL_LOG.exists(), reason=f"the real log is not at {REAL_LOG.parent.name}/")
def test_the_real_corridor_is_l_shaped_with_free_space_between_two_walls(run):
    files = [REAL_LOG / "measurement.txt", REAL_LOG / "poses.txt"]
    run(["import", *files, "--format", "udacity", "--ring", "udacity8", "--out", "log.parquet"])
    run("map log.parquet --out map")
    built = sm.OccupancyMap.load("map")

    def seen_around(x_m, y_m, across):
        """Return (free at a place, wall to its one side, wall to its other), within 2 m.

        A wall counts when it is met anywhere on 1.5 m along the corridor, for the robot's few
        sonars leave gaps in it.
        """
        beside, along = np.meshgrid(np.arange(-2, 2.01, 0.05), np.arange(-0.75, 0.76, 0.05))
        right = np.array(across)
        ahead = right[::-1]
        points = np.array([x_m, y_m]) + beside[..., None] * right + along[..., None] * ahead
        p = built.probability[built.grid.cell_of(points[..., 0], points[..., 1])]
        here = (np.abs(beside) < 0.15) & (np.abs(along) < 0.15)
        return np.median(p[here]) < 0.2, p[beside < -0.3].max() > 0.9, p[beside > 0.3].max() > 0.9

    log = sm.read_log("log.parquet")
    east = log.x_m < log.x_m.max() - 2.5
    assert np.ptp(log.x_m[east]) > 13
    assert np.ptp(log.y_m[east]) < 1
    stations = np.arange(1, 9, 0.5)
    y_m = np.interp(stations, log.x_m[east], log.y_m[east])
    seen = np.array([seen_around(x, y, (0, 1)) for x, y in zip(stations, y_m, strict=True)])
    assert (seen.mean(axis=0) >= 0.7).all(), seen

    # After a right turn the robot drove along -y.
    south = log.y_m < -3
    assert log.y_m.min() < -8
    assert np.ptp(log.x_m[south]) < 1.5
    stations = np.arange(-9, -3.5, 0.5)
    x_m = np.interp(-stations, -log.y_m[south], log.x_m[south])
    seen = np.array([seen_around(x, y, (1, 0)) for x, y in zip(x_m, stations, strict=True)])
    assert (seen.mean(axis=0) >= 0.7).all(), seen
