"""`sonarbed refine`: poses that echoes agree on."""

import json

import numpy as np
import pytest
from drives import by_odometry, log_of, way

import sonarmap as sm


@pytest.fixture
def log(tmp_path):
    rng = np.random.default_rng(1)
    true = way(1)
    log_of(true, by_odometry(true, rng, turn=1.01), rng).write(tmp_path / "drive.parquet")
    return sm.read_log(tmp_path / "drive.parquet")


def test_it_writes_the_log_with_refined_poses(run, log):
    told = json.loads(run("refine drive.parquet --out refined.parquet --json"))
    refined = sm.read_log("refined.parquet")
    assert np.array_equal(refined.x_m, sm.refine_poses(log).x_m)
    assert told["readings"] == len(log)
    assert told["pose_errors"] is None
    assert 0 < told["moved_m"] < 0.2
    assert "refined.parquet" in run("refine drive.parquet --out refined.parquet")


@pytest.mark.engine
def test_with_truth_it_tells_the_errors(run):
    run("simulate thesis-exp2 --engine segments --scans 60 --out drive.parquet")
    told = json.loads(run("refine drive.parquet --out refined.parquet --json"))
    log = sm.read_log("drive.parquet")
    away_m = np.hypot(log.x_m - log.truth.x_m, log.y_m - log.truth.y_m)
    before = told["pose_errors"]["before"]
    assert before["place_m"] == pytest.approx(np.sqrt(np.mean(away_m**2)))
    assert "by odometry" in run("refine drive.parquet --out refined.parquet")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("refine drive.parquet --out drive.parquet", "--out must be another file"),
        ("refine drive.parquet --out refined.csv", "refined.csv"),
        ("refine drive.parquet --out r.parquet --knot-m 0", "knot_m must be"),
        ("refine none.parquet --out r.parquet", "none.parquet"),
    ],
)
def test_bad_input(refused, log, line, message):
    assert message in refused(line)
