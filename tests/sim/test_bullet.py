import math

import numpy as np
import pytest
from rooms import ROUGH, box, closed_room, pillar, world

import worlds
from sim import amigobot
from sim.bullet import Bullet
from sim.engine import open_engine
from sonarmap import InputError

pytestmark = pytest.mark.engine

OPEN = world(box("far", 4.0, -1.0, 4.5, 1.0))


def cast_one(engine, origin, angle_rad, range_m=5.0):
    hits = engine.cast(
        np.array([origin], float),
        np.array([[math.cos(angle_rad), math.sin(angle_rad)]]),
        np.array([range_m]),
    )
    return hits.distance_m[0], hits.normal_xy[0], hits.surface[0]


def test_ray_meets_a_wall_at_its_distance_and_sees_its_normal():
    with Bullet(OPEN) as engine:
        distance, normal, surface = cast_one(engine, (0, 0), math.radians(10))
    assert distance == pytest.approx(4 / math.cos(math.radians(10)), abs=1e-9)
    assert normal == pytest.approx([-1, 0], abs=1e-9)
    assert surface == 0


def test_ray_meets_a_pillar():
    with Bullet(world(pillar("post", 2.0, 0.0, 0.05))) as engine:
        distance, normal, _ = cast_one(engine, (0, 0), 0.0)
    assert distance == pytest.approx(1.95, abs=1e-9)
    assert normal == pytest.approx([-1, 0], abs=1e-9)


def test_ray_that_meets_nothing_says_so():
    with Bullet(OPEN) as engine:
        distance, normal, surface = cast_one(engine, (0, 0), math.pi)
    assert distance == math.inf
    assert normal.tolist() == [0, 0]
    assert surface == -1


def test_robot_is_invisible_to_its_own_rays():
    with Bullet(OPEN) as engine:
        # From behind the robot through all of it, at sonar height.
        distance, _, surface = cast_one(engine, (-1, 0), 0.0, range_m=6.0)
    assert distance == pytest.approx(5, abs=1e-9)
    assert surface == 0


@pytest.mark.parametrize("name", worlds.names())
def test_rays_agree_with_the_worlds_own_faces(name, rng):
    room = worlds.load(name)
    x_min, y_min, x_max, y_max = room.bounds_m
    points = np.column_stack([rng.uniform(x_min, x_max, 2000), rng.uniform(y_min, y_max, 2000)])
    truth = worlds.truth(room)
    row, col = truth.grid.cell_of(*points.T)
    points = points[truth.state[row, col] == worlds.FREE]
    angle = rng.uniform(-math.pi, math.pi, len(points))
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    reach = np.full(len(points), 3.0)
    with Bullet(room) as engine:
        hits = engine.cast(points, direction, reach)
    expected = room.faces.cast(points, direction, reach)
    same = np.isclose(hits.distance_m, expected.distance_m, atol=1e-3)
    assert same.mean() >= 0.999
    assert (hits.surface == expected.surface)[same].mean() >= 0.999


def test_large_batches_lose_no_ray():
    # PyBullet answers a batch of exactly 16384 rays with nothing.
    n = 16384
    angle = np.linspace(-math.pi, math.pi, n)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    room = closed_room()
    with Bullet(room) as engine:
        hits = engine.cast(np.zeros((n, 2)), direction, np.full(n, 5.0))
    assert hits.distance_m == pytest.approx(1.5 / np.abs(direction).max(axis=1), abs=1e-6)


def test_straight_drive_follows_kinematics():
    with Bullet(OPEN) as engine:
        engine.advance(0.2, 0.2, 5.0)
        pose = engine.pose
    # Speeding up costs v^2 / (2 a) of the way.
    way_m = 0.2 * 5.0 - 0.2**2 / (2 * amigobot.ACCELERATION_MPS2)
    assert pose.x_m == pytest.approx(way_m, abs=2e-3)
    assert pose.y_m == pytest.approx(0, abs=1e-3)
    assert pose.heading_rad == pytest.approx(0, abs=1e-3)


def test_spin_follows_the_wheels():
    with Bullet(OPEN) as engine:
        engine.advance(-0.05, 0.05, 4.0)
        pose, (left, right) = engine.pose, engine.wheel_turns_rad
    assert pose.heading_rad == pytest.approx(
        (right - left) * amigobot.WHEEL_RADIUS_M / amigobot.TRACK_M, abs=2e-3
    )
    assert math.hypot(pose.x_m, pose.y_m) < 2e-3


def test_thesis_command_drives_the_circle_of_its_arithmetic():
    left, right = amigobot.THESIS_LEFT_MPS, amigobot.THESIS_RIGHT_MPS
    radius_m = amigobot.TRACK_M / 2 * (left + right) / (right - left)
    with Bullet(OPEN) as engine:
        engine.advance(left, right, 1.0)
        centre = _left_of(engine.pose, radius_m)
        for _ in range(8):
            engine.advance(left, right, 4.0)
            assert _left_of(engine.pose, radius_m) == pytest.approx(centre, abs=3e-3)


def _left_of(pose, distance_m):
    return (
        pose.x_m - distance_m * math.sin(pose.heading_rad),
        pose.y_m + distance_m * math.cos(pose.heading_rad),
    )


@pytest.mark.parametrize("thing", [box("wall", 0.5, -1, 0.6, 1), pillar("post", 0.6, 0, 0.1)])
def test_collision_is_told_and_nothing_is_passed_through(thing):
    with Bullet(world(thing)) as engine:
        assert not engine.advance(0.3, 0.3, 0.5)
        assert engine.advance(0.3, 0.3, 4.0)
        assert engine.pose.x_m == pytest.approx(0.5 - amigobot.BODY_RADIUS_M, abs=0.01)


def test_start_too_near_a_wall_is_refused():
    near = world(box("wall", 0.1, -1, 0.2, 1))
    with pytest.raises(InputError, match=r"start of \(0, 0\) m, 0 degrees must leave the robot"):
        Bullet(near)


def test_closing_twice_is_fine():
    engine = Bullet(OPEN)
    engine.close()
    engine.close()


def test_two_engines_do_not_meet():
    def drive(engine):
        return [(engine.advance(0.1, 0.15, 0.2), engine.pose) for _ in range(10)]

    with Bullet(OPEN) as alone:
        expected = drive(alone)
    wall = world(box("wall", 0.3, -1, 0.4, 1, ROUGH), start=(0.0, 0.0, 0.5))
    with Bullet(OPEN) as one, Bullet(wall) as two:
        mixed = []
        for _ in range(10):
            mixed.append((one.advance(0.1, 0.15, 0.2), one.pose))
            two.advance(0.3, 0.3, 0.2)
            assert cast_one(one, (0, 0), 0.0)[0] == pytest.approx(4)
    assert mixed == expected


def test_unknown_engine_is_refused_with_the_nearest_name():
    with pytest.raises(InputError, match=r"engine 'bulet' is unknown; did you mean 'bullet'\?"):
        open_engine("bulet", OPEN)
