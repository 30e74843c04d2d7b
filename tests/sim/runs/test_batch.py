"""A batch of compiled drives is its drives one by one, to the last bit."""

import numpy as np
import pytest

import sim
import worlds
from sim.robot import drivers
from sim.runs.batch.drives import BatchDrive, is_compiled, simulate_batch
from sim.sonar import presets
from sonarmap import InputError

EXACT = {name: presets.preset(name) for name in ("thesis", "aria")}
WIDE = EXACT["aria"].replace(max_bounces=1, threshold=0.5, noise_std_m=0.01)


def single(drive):
    return sim.simulate(
        drive.world, scans=drive.scans, seed=drive.seed, driver=drive.driver, sonar=drive.sonar,
        odometry=drive.odometry, engine="segments",
    )  # fmt: skip


def assert_same(one, other):
    for name in one.DTYPES:
        a, b = getattr(one, name), getattr(other, name)
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name
    for name in one.truth.DTYPES:
        a, b = getattr(one.truth, name), getattr(other.truth, name)
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name
    assert dict(one.provenance) == dict(other.provenance)
    assert one.ring == other.ring


DRIVES = {
    "thesis": ("thesis-exp1", "thesis", EXACT["thesis"]),
    "collides": ("clutter", sim.ConstantSpeeds(0.2, 0.25), EXACT["aria"]),
    "wander": ("clutter", "wander", EXACT["aria"]),
    "wander collides": ("round-room", sim.RandomWander(0.5, 0.2, 3.0), EXACT["thesis"]),
    "follow": ("office", "follow-left", EXACT["aria"]),
    "follow right": ("l-shape", sim.WallFollower(side="right"), WIDE),
    "route": ("office", "route", EXACT["aria"]),
    "route far": ("corridor", "route", EXACT["thesis"]),
}


def drives(names=DRIVES, scans=250):
    for seed, name in enumerate(names):
        room, driver, sonar = DRIVES[name]
        odometry = sim.OdometryModel(slip_std_m=0.003) if seed % 2 else None
        yield BatchDrive(worlds.load(room), scans, seed, driver, sonar, odometry)


def test_every_log_is_that_of_the_single_drive():
    wanted = list(drives())
    seen = set()
    for index, log in simulate_batch(wanted, workers=2):
        assert_same(log, single(wanted[index]))
        seen.add(index)
    assert seen == set(range(len(wanted)))


def test_one_worker_gives_the_same_in_order():
    wanted = list(drives(scans=40))
    told = list(simulate_batch(wanted, workers=1))
    assert [index for index, _ in told] == list(range(len(wanted)))
    for index, log in simulate_batch(wanted, workers=3):
        assert_same(log, told[index][1])


def test_collisions_and_whims_were_met():
    # Or the drives above would not have tried them.
    wanted = list(drives(["wander collides", "collides"]))
    for _, log in simulate_batch(wanted):
        assert log.truth.collision.any()


def test_logs_are_handed_out_while_others_are_still_to_come():
    begun = 0

    def endless():
        nonlocal begun
        while True:
            begun += 1
            yield BatchDrive(worlds.load("thesis-exp1"), 5, begun)

    batch = simulate_batch(endless(), workers=2)
    assert len({next(batch)[0] for _ in range(20)}) == 20
    assert begun <= 24
    batch.close()


def test_a_start_of_its_own():
    room = worlds.load("office")
    start = worlds.Pose(2.5, 3.0, 0.4)
    ((_, log),) = simulate_batch([BatchDrive(room, 3, 0, start=start)])
    assert (log.truth.x_m[0], log.truth.y_m[0], log.truth.heading_rad[0]) == (2.5, 3.0, 0.4)


class Own:
    """A driver that is no numbers."""

    def begin(self, rng):
        return lambda sensed: (0.1, 0.1)


def test_drivers_and_sonars_say_whether_they_are_compiled():
    room = worlds.load("office")
    for name in drivers.names():
        assert is_compiled(drivers.driver(name, room), EXACT["aria"])
    driver = drivers.driver("wander", room)
    assert not is_compiled(driver, presets.preset("physical"))
    assert not is_compiled(driver, EXACT["aria"].replace(rays=31))
    assert not is_compiled(driver, presets.preset("webots"))
    assert not is_compiled(Own(), EXACT["aria"])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scans": 0}, r"scans must be >= 1, got 0"),
        ({"seed": -1}, r"seed must be >= 0, got -1"),
        ({"sonar": "physical"}, r"sonar 'physical' must be an exact simple cone to be compiled"),
        ({"driver": Own()}, r"driver must be one that is compiled, got <.*Own"),
        ({"driver": "wandr"}, r"driver 'wandr' is unknown; did you mean 'wander'\?"),
        ({"start": worlds.Pose(0, 0, 0)}, r"start of \(0, 0\) m.* must leave the robot"),
    ],
)
def test_bad_drives_are_refused(changes, message):
    arguments = {"world": worlds.load("office"), "scans": 3, "seed": 0} | changes
    for workers in (1, 2):
        with pytest.raises(InputError, match=message):
            list(simulate_batch([BatchDrive(**arguments)], workers=workers))
    with pytest.raises(InputError, match=r"workers must be >= 1, got 0"):
        list(simulate_batch([], workers=0))
