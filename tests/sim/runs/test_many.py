import json

import numpy as np
import pytest

import sim
import sonarmap as sm
import worlds
from sim.runs import many
from sim.runs.arguments import DriveArguments
from sim.runs.batch.drives import simulate_batch
from sim.runs.many import MANIFEST
from sim.runs.plain import plain_log

pytestmark = pytest.mark.engine


class Spin:
    """A person's own driver, which no compiled code knows."""

    def begin(self, rng):
        return lambda sensed: (-0.1, 0.1)


def test_parallel_logs_equal_single_ones(tmp_path):
    room = worlds.load("thesis-exp1")
    done = []
    manifest = sim.simulate_many(
        room, tmp_path, seeds=[4, 2], jobs=2, on_done=done.append, scans=5, driver="wander"
    )
    assert sorted(done) == [2, 4]
    assert json.loads((tmp_path / MANIFEST).read_text()) == manifest
    assert [entry["file"] for entry in manifest["logs"]] == [
        "seed-0002.parquet",
        "seed-0004.parquet",
    ]
    for entry in manifest["logs"]:
        path = tmp_path / entry["file"]
        single = sim.simulate(room, scans=5, seed=entry["seed"], driver="wander")
        single.write(tmp_path / "single.parquet")
        assert path.read_bytes() == (tmp_path / "single.parquet").read_bytes()
        assert entry["readings"] == len(single) == sum(entry["causes"].values())


@pytest.mark.parametrize(
    ("arguments", "compiled"),
    [
        ({"sonar": "thesis", "driver": "wander"}, True),
        ({"sonar": "aria", "odometry": sim.OdometryModel(slip_std_m=0.01)}, True),
        ({"sonar": sim.ConeSonar("fan", sm.AMIGOBOT, 0.1, rays=5)}, False),
        ({"sonar": "thesis", "packets": sim.StatusPackets()}, False),
        ({"sonar": "thesis", "driver": Spin()}, False),
        ({"sonar": "physical"}, True),
        ({"sonar": "physical", "driver": Spin()}, False),
    ],
)
def test_what_can_be_compiled_is_and_the_logs_are_those_of_single_drives(
    tmp_path, monkeypatch, arguments, compiled
):
    room, batches = worlds.load("l-shape"), []
    monkeypatch.setattr(
        many, "simulate_batch", lambda *args, **kw: batches.append(1) or simulate_batch(*args, **kw)
    )
    arguments = {"engine": "segments", "scans": 7, **arguments}
    manifest = sim.simulate_many(room, tmp_path, seeds=[3, 5, 1], **arguments)
    assert bool(batches) is compiled
    assert [entry["seed"] for entry in manifest["logs"]] == [1, 3, 5]
    for entry in manifest["logs"]:
        asked = DriveArguments.of(room, seed=entry["seed"], **arguments)
        plain_log(asked).write(tmp_path / "single.parquet")
        single = (tmp_path / "single.parquet").read_bytes()
        assert (tmp_path / entry["file"]).read_bytes() == single


def test_what_was_written_before_an_interruption_stands_in_the_manifest(tmp_path):
    def interrupt(seed):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        sim.simulate_many(
            worlds.load("l-shape"), tmp_path, seeds=range(4), on_done=interrupt, scans=2,
            engine="segments", sonar="thesis", jobs=2,
        )  # fmt: skip
    (entry,) = json.loads((tmp_path / MANIFEST).read_text())["logs"]
    assert (tmp_path / entry["file"]).exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"jobs": 0}, r"jobs must be >= 1, got 0"),
        ({"seeds": []}, r"seeds must be at least one and none twice, got \[\]"),
        ({"seeds": [1, 1]}, r"seeds must be at least one and none twice, got \[1, 1\]"),
        ({"jobs": 1.5}, r"jobs must be a whole number, got 1.5"),
        ({"jobs": "2"}, r"jobs must be a number, got '2'"),
        ({"jobs": True}, r"jobs must be a number, got True"),
        ({"jobs": 10**6}, r"jobs must be <= \d+, got 1000000"),
        ({"seeds": "01"}, r"seeds must be whole numbers such as range\(10\), got '01'"),
        ({"seeds": 3}, r"seeds must be whole numbers such as range\(10\), got 3"),
        ({"seeds": [0, 1.5]}, r"seeds\[1\] must be a whole number, got 1.5"),
        ({"seeds": [0, -1]}, r"seeds\[1\] must be >= 0, got -1"),
        ({"seeds": [1, 1.0]}, r"seeds must be at least one and none twice, got \[1, 1\]"),
        # What is for `simulate` is refused before any process begins.
        ({"scans": 0}, r"scans must be >= 1, got 0"),
        ({"driver": "rout"}, r"driver 'rout' is unknown; did you mean 'route'\?"),
        ({"packets": True}, r"packets must be a StatusPackets, got True"),
        ({"engine": "bulet"}, r"engine 'bulet' is unknown"),
    ],
)
def test_bad_arguments_are_refused_and_leave_no_manifest(tmp_path, changes, message):
    arguments = {"seeds": [0], "scans": 2} | changes
    with pytest.raises(sm.InputError, match=message):
        sim.simulate_many(worlds.load("thesis-exp1"), tmp_path, **arguments)
    assert list(tmp_path.iterdir()) == []


def test_seeds_may_be_an_array(tmp_path):
    manifest = sim.simulate_many(
        worlds.load("thesis-exp1"),
        tmp_path,
        seeds=np.arange(2),
        scans=np.int64(2),
        engine="segments",
        sonar="aria",
    )
    assert [entry["seed"] for entry in manifest["logs"]] == [0, 1]
    assert json.loads((tmp_path / MANIFEST).read_text())["arguments"]["scans"] == 2
