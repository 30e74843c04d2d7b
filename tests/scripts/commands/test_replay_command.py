"""A log beside its simulation, and a real log's map scored, from the command line."""

import json

import pytest

import sim
import sonarmap as sm
import worlds


@pytest.fixture(scope="module")
def log():
    """A short drive, its odometry exact."""
    room = worlds.load("l-shape")
    return sim.simulate(room, scans=60, seed=1, sonar="thesis", engine="segments").at_true_poses()


@pytest.fixture
def real(log, tmp_path):
    """The same as a real robot logs it, in a frame of its own."""
    moved = log.replace(x_m=log.x_m + 3.0, y_m=log.y_m - 1.0, truth=None, provenance={})
    moved.write(tmp_path / "real.parquet")
    return moved


def test_a_simulated_log_agrees_with_its_simulation(run, log):
    log.write("drive.parquet")
    line = "replay drive.parquet --world l-shape --sonar thesis"
    told = json.loads(run(f"{line} --out again.parquet --png p.png --json"))
    assert (told["agreement"], told["poses"]) == (1, "true")
    assert told["within"]["0.05"] > 0.99
    assert told["account"]["in_log"] == len(log)
    again = sm.read_log("again.parquet")
    assert (again.ring, len(again)) == (log.ring, len(log))
    shown = run(line)
    assert "Echo or silence agrees in 100.0%." in shown
    assert f"{len(log)} of {len(log)} readings used." in shown


def test_a_real_log_is_aligned_first(run, real):
    told = json.loads(run("replay real.parquet --world l-shape --sonar thesis --align --json"))
    assert told["poses"] == "odometry"
    assert told["alignment"]["motion"]["x_m"] == pytest.approx(-3, abs=0.05)
    assert told["alignment"]["motion"]["y_m"] == pytest.approx(1, abs=0.05)
    assert told["agreement"] > 0.9
    assert "Poses by odometry" in run("replay real.parquet --world l-shape --sonar thesis --align")


def test_the_map_of_a_real_log_is_scored_as_that_of_the_simulated_one(run, log, real):
    log.write("drive.parquet")
    for name in ("drive", "real"):
        run(f"map {name}.parquet --out {name}")
    known = json.loads(run("score drive --world l-shape --log drive.parquet --json"))
    found = json.loads(run("score real --world l-shape --log real.parquet --align --json"))
    assert (known["poses"], found["poses"]) == ("true", "odometry")
    assert found["map_score"] == pytest.approx(known["map_score"], abs=0.15)
    assert any("follows from the poses of odometry" in note for note in found["notes"])
    # In the room's frame nothing needs to be found.
    log.replace(truth=None).write("there.parquet")
    same = json.loads(run("score drive --world l-shape --log there.parquet --json"))
    assert same["map_score"] == known["map_score"]
    assert same["poses"] == "odometry"
