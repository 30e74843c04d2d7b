import json
import math

import numpy as np
import pytest
from rooms import MIRROR, box, closed_room, world

import sim
import worlds
from sim import ConstantSpeeds, OdometryModel, WallFollower
from sim.runs.arguments import MOST_SCANS, DriveArguments
from sim.sonar import presets as sonars
from sonarmap import Cause, InputError

pytestmark = pytest.mark.engine

# No noise and a fine scale, so that logs of turned and mirrored rooms can be compared.
STILL = sonars.preset("thesis").replace(noise_std_m=0, quantum_m=0)


def mixed_room(**arguments):
    """A room without any symmetry: rough and mirroring walls, a box in a corner."""
    room = closed_room(1.4)
    extra = (
        box("box", 0.7, 0.8, 1.1, 1.2),
        box("mirror", -1.3, -1.0, -1.2, 0.9, MIRROR, turned_deg=20, about=(-1.25, 0)),
    )
    return world(*room.solids, *extra, start=(0.1, -0.3, 0.4), **arguments)


def drive(room=None, **changes):
    exact = OdometryModel.exact()
    arguments = {"scans": 60, "seed": 3, "driver": "thesis", "sonar": STILL, "odometry": exact}
    return sim.simulate(mixed_room() if room is None else room, **(arguments | changes))


def test_same_seed_gives_the_same_bytes(tmp_path):
    for name in ("one", "two"):
        sim.simulate(worlds.load("thesis-exp1"), scans=20, seed=0).write(tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_another_seed_gives_another_log():
    one, other = (
        sim.simulate(mixed_room(), scans=20, seed=seed, driver="thesis") for seed in (0, 1)
    )
    assert (one.range_m != other.range_m).any()
    assert (one.x_m != other.x_m).any()
    # What is true of the drive itself does not depend on noise.
    assert (one.truth.x_m == other.truth.x_m).all()


def test_a_simulation_does_not_touch_another_that_runs_meanwhile():
    alone = drive()
    halfway = []

    def another(scan):
        if scan == 30:
            halfway.append(sim.simulate(worlds.load("thesis-exp1"), scans=10, seed=9))

    mixed = drive(on_scan=another)
    assert len(halfway) == 1
    for name in ("range_m", "x_m", "heading_rad"):
        assert (getattr(mixed, name) == getattr(alone, name)).all()


def same_ranges(a_m, b_m):
    """Return the share of readings that agree to a tenth of a millimetre."""
    return (np.isclose(a_m, b_m, atol=1e-4) | (np.isinf(a_m) & (a_m == b_m))).mean()


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_quarter_turn_of_world_and_robot_turns_the_log(turns):
    log, turned = drive(), drive(mixed_room().transformed(quarter_turns=turns))
    angle = turns * math.pi / 2
    cos, sin = math.cos(angle), math.sin(angle)
    assert turned.x_m == pytest.approx(cos * log.x_m - sin * log.y_m, abs=1e-4)
    assert turned.y_m == pytest.approx(sin * log.x_m + cos * log.y_m, abs=1e-4)
    assert same_ranges(turned.range_m, log.range_m) > 0.99
    assert (turned.truth.cause == log.truth.cause).mean() > 0.99


def test_mirrored_world_gives_a_mirrored_log():
    log = drive(driver=ConstantSpeeds(0.04, 0.075))
    mirrored = drive(mixed_room().mirrored(), driver=ConstantSpeeds(0.075, 0.04))
    # The AmigoBot's ring is symmetric: sonar 0 looks left where 5 looks right, and so on.
    partner = np.array([5, 4, 3, 2, 1, 0, 7, 6])
    seen = mirrored.range_m.reshape(-1, 8)[:, partner].ravel()
    causes = mirrored.truth.cause.reshape(-1, 8)[:, partner].ravel()
    assert mirrored.x_m == pytest.approx(log.x_m, abs=1e-4)
    assert mirrored.y_m == pytest.approx(-log.y_m, abs=1e-4)
    assert mirrored.heading_rad == pytest.approx(-log.heading_rad, abs=1e-4)
    assert same_ranges(seen, log.range_m) > 0.99
    assert (causes == log.truth.cause).mean() > 0.99


def test_log_has_every_sonar_at_every_sample():
    log = drive(scans=5)
    assert log.scan.tolist() == np.repeat(range(5), 8).tolist()
    assert log.sonar.tolist() == list(range(8)) * 5
    assert log.time_s == pytest.approx(np.repeat(np.arange(5) * 0.175, 8))


def test_exact_odometry_follows_the_true_pose():
    log = drive(scans=200)
    assert log.x_m == pytest.approx(log.truth.x_m, abs=2e-3)
    assert log.y_m == pytest.approx(log.truth.y_m, abs=2e-3)
    assert log.heading_rad == pytest.approx(np.unwrap(log.truth.heading_rad), abs=2e-3)


def test_causes_agree_with_the_ranges_they_stand_beside():
    truth, heard = (log := drive(scans=200, driver="wander")).truth, log.range_m
    cause = truth.cause
    silent = np.isposinf(heard)
    assert np.isposinf(heard[cause == Cause.OUT_OF_RANGE]).all()
    assert np.isposinf(truth.cone_range_m[cause == Cause.OUT_OF_RANGE]).all()
    assert np.isfinite(truth.cone_range_m[silent & (cause == Cause.DROPOUT)]).all()
    direct = (cause == Cause.DIRECT) & np.isfinite(heard)
    assert np.abs(heard - truth.axis_range_m)[direct].max() <= 0.06 + 1e-9
    off_axis = (cause == Cause.OFF_AXIS) & np.isfinite(heard)
    assert (heard < truth.axis_range_m - 0.06)[off_axis].all()
    assert (truth.bounces[cause == Cause.BOUNCE] > 0).all()
    assert (truth.bounces[cause != Cause.BOUNCE] == 0).all()
    assert (heard >= truth.cone_range_m - 1e-9)[np.isfinite(heard)].all()
    assert (truth.surface[silent] == "").all()
    assert set(truth.surface[~silent]) <= {"east", "north", "west", "south", "box", "mirror"}
    for seen in (Cause.DIRECT, Cause.OFF_AXIS, Cause.BOUNCE, Cause.DROPOUT):
        assert (cause == seen).any()


def test_collision_is_recorded_and_the_robot_stays_in_its_room():
    log = drive(scans=120, driver=ConstantSpeeds(0.2, 0.2))
    assert not log.truth.collision[:8].any()
    assert log.truth.collision[-8:].all()
    assert np.abs(log.truth.x_m).max() < 1.4 - 0.17
    assert np.abs(log.truth.y_m).max() < 1.4 - 0.17


def test_provenance_tells_how_the_log_was_made():
    told = json.loads(json.dumps(dict(drive(driver=WallFollower(0.4)).provenance)))
    assert told["world"] == "test"
    assert told["seed"] == 3
    assert told["driver"]["kind"] == "WallFollower"
    assert told["driver"]["distance_m"] == 0.4
    assert told["sonar"]["noise_std_m"] == 0


def test_numbers_of_numpy_are_those_of_python():
    log = drive(scans=np.int64(3), seed=np.uint8(4))
    assert (log.provenance["scans"], log.provenance["seed"]) == (3, 4)
    json.dumps(dict(log.provenance))
    np.testing.assert_array_equal(log.range_m, drive(scans=3, seed=4).range_m)


def test_the_longest_drive_is_a_limit_not_a_wish():
    asked = DriveArguments.of(mixed_room(), scans=MOST_SCANS, seed=0)
    assert asked.scans == 10_000_000


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scans": 0}, r"scans must be >= 1, got 0"),
        ({"scans": 2.5}, r"scans must be a whole number, got 2.5"),
        ({"scans": "5"}, r"scans must be a number, got '5'"),
        ({"scans": True}, r"scans must be a number, got True"),
        ({"scans": np.True_}, r"scans must be a number, got np.True_"),
        ({"scans": math.inf}, r"scans must be a whole number, got inf"),
        ({"scans": None}, r"scans must be a number, got None"),
        ({"scans": 10**9}, r"scans must be <= 10000000, .* memory, got 1000000000"),
        ({"scans": 10**400}, r"scans must be a number that fits 64 bits"),
        ({"seed": -1}, r"seed must be >= 0, got -1"),
        ({"seed": 1.5}, r"seed must be a whole number, got 1.5"),
        ({"seed": "1"}, r"seed must be a number, got '1'"),
        ({"seed": False}, r"seed must be a number, got False"),
        ({"seed": None}, r"seed must be a number, got None"),
        ({"room": "office"}, r"world must be a World, got 'office': worlds.load"),
        ({"packets": True}, r"packets must be a StatusPackets, got True"),
        ({"packets": 0.1}, r"packets must be a StatusPackets, got 0.1"),
        ({"odometry": "exact"}, r"odometry must be an OdometryModel, got 'exact'"),
        ({"gui": "no"}, r"gui must be True or False, got 'no'"),
        ({"gui": 0}, r"gui must be True or False, got 0"),
        ({"driver": None}, r"driver must be a driver, got None"),
        ({"driver": WallFollower}, r"driver must be a driver, got <class .*WallFollower"),
        ({"sonar": 3}, r"sonar must be a sonar, got 3"),
        ({"sonar": sim.PhysicalSonar}, r"sonar must be a sonar, got <class .*PhysicalSonar"),
        ({"engine": None}, r"engine must be a name, got None"),
        ({"driver": "wandr"}, r"driver 'wandr' is unknown; did you mean 'wander'\?"),
        ({"driver": "route"}, r"driver 'route' needs route_m in the world 'test', it has none"),
        ({"sonar": "thesys"}, r"sonar 'thesys' is unknown; did you mean 'thesis'\?"),
        ({"engine": "bulet"}, r"engine 'bulet' is unknown; did you mean 'bullet'\?"),
        (
            {"sonar": STILL.replace(scan_period_s=0.1234)},
            r"scan_period_s must be a multiple of 0.005 s, got 0.1234",
        ),
    ],
)
def test_bad_arguments_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        drive(**changes)
