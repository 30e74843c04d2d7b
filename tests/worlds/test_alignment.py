"""The rigid motion between a log's frame and its room's."""

import math

import numpy as np
import pytest
from support import make_log

import sim
import sonarmap as sm
import worlds
from worlds import Pose
from worlds.alignment import LEAST_READINGS, align


def own_frame(log, pose):
    """Return a log as a robot writes it whose frame lies at a pose in the room."""
    cos, sin = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    x_m, y_m = log.x_m - pose.x_m, log.y_m - pose.y_m
    return log.replace(
        x_m=cos * x_m + sin * y_m,
        y_m=cos * y_m - sin * x_m,
        heading_rad=log.heading_rad - pose.heading_rad,
        truth=None,
    )


def drive(name, sonar="thesis", scans=120):
    log = sim.simulate(worlds.load(name), scans=scans, seed=1, sonar=sonar, engine="segments")
    return log.at_true_poses()


@pytest.fixture(scope="module")
def office():
    return drive("office")


@pytest.mark.parametrize("pose", [Pose(0.4, -0.2, 0.3), Pose(5.0, -7.0, 3.0), Pose(-20, 1, -1.6)])
def test_the_motion_is_found_wherever_the_robot_was_switched_on(office, pose):
    found = align(own_frame(office, pose), worlds.load("office"))
    assert math.remainder(found.motion.heading_rad - pose.heading_rad, math.tau) == pytest.approx(
        0, abs=math.radians(1)
    )
    assert found.alternatives == ()
    assert found.median_m < 0.02
    assert 0 < found.std.x_m < 0.05
    back = found.moved(own_frame(office, pose))
    assert np.hypot(back.x_m - office.x_m, back.y_m - office.y_m).mean() < 0.04


def test_the_physical_sonar_is_aligned_in_spite_of_its_wrong_readings():
    log = drive("l-shape", "physical", scans=60)
    pose = Pose(1.0, 2.0, -2.0)
    found = align(own_frame(log, pose), worlds.load("l-shape"))
    assert math.hypot(found.motion.x_m - pose.x_m, found.motion.y_m - pose.y_m) < 0.05


def test_the_same_seed_finds_the_same(office):
    one, other = (align(office, worlds.load("office"), seed=3) for _ in range(2))
    assert one == other


def test_a_symmetric_room_is_said_to_be_so():
    box = worlds.Solid.wall(
        "walls", [(0, 0), (4, 0), (4, 3), (0, 3)], thickness_m=0.1, height_m=2, material="brick",
        closed=True, side="right",
    )  # fmt: skip
    room = worlds.World.of("box", [box], bounds_m=(-0.2, -0.2, 4.2, 3.2), start=(1, 1, 0.4))
    log = sim.simulate(room, scans=60, seed=0, sonar="aria", driver="wander", engine="segments")
    found = align(log.at_true_poses(), room)
    # Of two that are as good the nearest to none is taken; the other turns the room by half.
    assert abs(found.motion.heading_rad) < 0.02
    (other,) = found.alternatives
    assert abs(other.heading_rad) == pytest.approx(math.pi, abs=0.02)
    assert (other.x_m, other.y_m) == pytest.approx((4, 3), abs=0.05)
    assert "the room looks the same from (4.0" in str(found)


def test_a_map_of_the_own_frame_lies_in_the_room_that_was_moved(office):
    pose, room = Pose(1.0, -2.0, 0.7), worlds.load("office")
    log = own_frame(office, pose)
    seen = align(log, room).world_in_log_frame(room)
    expected = room.placed(Pose(0, 0, 0)).start
    x_m, y_m = seen.start.x_m, seen.start.y_m
    cos, sin = math.cos(pose.heading_rad), math.sin(pose.heading_rad)
    assert pose.x_m + cos * x_m - sin * y_m == pytest.approx(expected.x_m, abs=0.03)
    assert pose.y_m + sin * x_m + cos * y_m == pytest.approx(expected.y_m, abs=0.03)


def test_stale_rejected_and_silent_readings_do_not_count(office):
    few = np.arange(len(office)) >= LEAST_READINGS
    for marks in ({"stale": few}, {"rejected": few}):
        marked = office.replace(**marks).select(np.isfinite(office.range_m))
        with pytest.raises(sm.InputError, match=r"must have at least 30 readings with an echo"):
            align(marked, worlds.load("office"))
    silent = make_log(np.full(50, np.inf))
    with pytest.raises(sm.InputError, match=r"must have at least 30 .* got 0"):
        align(silent, worlds.load("office"))


def test_bad_arguments_are_refused(office):
    with pytest.raises(sm.InputError, match="seed must be >= 0"):
        align(office, worlds.load("office"), seed=-1)
    with pytest.raises(sm.InputError, match="world must be a World"):
        align(office, "office")


def test_a_world_that_is_placed_and_placed_back_is_the_same():
    room = worlds.load("clutter")
    there = room.placed(Pose(2.0, -1.0, 0.9))
    cos, sin = math.cos(0.9), math.sin(0.9)
    back = there.placed(Pose(-(cos * 2 + sin * -1), -(-sin * 2 + cos * -1), -0.9))
    for before, after in zip(room.solids, back.solids, strict=True):
        assert before.outline.equals_exact(after.outline, 1e-9)
        if before.circle is not None:
            assert after.circle == pytest.approx(before.circle)
    assert back.start.heading_rad == pytest.approx(room.start.heading_rad)
    assert np.allclose(back.route_m, room.route_m)
