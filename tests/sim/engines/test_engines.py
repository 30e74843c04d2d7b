import math

import numpy as np
import pytest
from rooms import ROUGH, box, closed_room, pillar, world

import sim
import sonarmap as sm
import worlds
from sim.engines.opening import ENGINES, open_engine
from sim.engines.segments import Segments
from sim.robot import amigobot
from sim.sonar import presets as sonars
from sonarmap import InputError
from worlds import Pose

pytestmark = pytest.mark.engine

OPEN = world(box("far", 4.0, -1.0, 4.5, 1.0))


@pytest.fixture(params=ENGINES)
def opened(request):
    """Both engines, one after the other: what holds for one holds for the other."""
    return lambda *arguments, **options: open_engine(request.param, *arguments, **options)


def cast_one(engine, origin, angle_rad, range_m=5.0):
    hits = engine.cast(
        np.array([origin], float),
        np.array([[math.cos(angle_rad), math.sin(angle_rad)]]),
        np.array([range_m]),
    )
    return hits.distance_m[0], hits.normal_xy[0], hits.surface[0]


def test_ray_meets_a_wall_at_its_distance_and_sees_its_normal(opened):
    with opened(OPEN) as engine:
        distance, normal, surface = cast_one(engine, (0, 0), math.radians(10))
    assert distance == pytest.approx(4 / math.cos(math.radians(10)), abs=1e-9)
    assert normal == pytest.approx([-1, 0], abs=1e-9)
    assert surface == 0


def test_ray_meets_a_pillar(opened):
    with opened(world(pillar("post", 2.0, 0.0, 0.05))) as engine:
        distance, normal, _ = cast_one(engine, (0, 0), 0.0)
    assert distance == pytest.approx(1.95, abs=1e-9)
    assert normal == pytest.approx([-1, 0], abs=1e-9)


def test_ray_that_meets_nothing_says_so(opened):
    with opened(OPEN) as engine:
        distance, normal, surface = cast_one(engine, (0, 0), math.pi)
    assert distance == math.inf
    assert normal.tolist() == [0, 0]
    assert surface == -1


def test_robot_is_invisible_to_its_own_rays(opened):
    with opened(OPEN) as engine:
        # From behind the robot through all of it, at sonar height.
        distance, _, surface = cast_one(engine, (-1, 0), 0.0, range_m=6.0)
    assert distance == pytest.approx(5, abs=1e-9)
    assert surface == 0


@pytest.mark.parametrize("name", worlds.names())
def test_rays_agree_with_the_worlds_own_faces(opened, name, rng):
    room = worlds.load(name)
    x_min, y_min, x_max, y_max = room.bounds_m
    points = np.column_stack([rng.uniform(x_min, x_max, 2000), rng.uniform(y_min, y_max, 2000)])
    truth = worlds.truth(room)
    row, col = truth.grid.cell_of(*points.T)
    points = points[truth.state[row, col] == worlds.FREE]
    angle = rng.uniform(-math.pi, math.pi, len(points))
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    reach = np.full(len(points), 3.0)
    with opened(room) as engine:
        hits = engine.cast(points, direction, reach)
    expected = room.faces.cast(points, direction, reach)
    same = np.isclose(hits.distance_m, expected.distance_m, atol=1e-3)
    assert same.mean() >= 0.999
    assert (hits.surface == expected.surface)[same].mean() >= 0.999


def test_large_batches_lose_no_ray(opened):
    # PyBullet answers a batch of exactly 16384 rays with nothing.
    n = 16384
    angle = np.linspace(-math.pi, math.pi, n)
    direction = np.column_stack([np.cos(angle), np.sin(angle)])
    room = closed_room()
    with opened(room) as engine:
        hits = engine.cast(np.zeros((n, 2)), direction, np.full(n, 5.0))
    assert hits.distance_m == pytest.approx(1.5 / np.abs(direction).max(axis=1), abs=1e-6)


def test_straight_drive_follows_kinematics(opened):
    with opened(OPEN) as engine:
        engine.advance(0.2, 0.2, 5.0)
        pose = engine.pose
    # Speeding up costs v^2 / (2 a) of the way.
    driven_m = 0.2 * 5.0 - 0.2**2 / (2 * amigobot.ACCELERATION_MPS2)
    assert pose.x_m == pytest.approx(driven_m, abs=2e-3)
    assert pose.y_m == pytest.approx(0, abs=1e-3)
    assert pose.heading_rad == pytest.approx(0, abs=1e-3)


def test_spin_follows_the_wheels(opened):
    with opened(OPEN) as engine:
        engine.advance(-0.05, 0.05, 4.0)
        pose, (left, right) = engine.pose, engine.wheel_turns_rad
    assert pose.heading_rad == pytest.approx(
        (right - left) * amigobot.WHEEL_RADIUS_M / amigobot.TRACK_M, abs=2e-3
    )
    assert math.hypot(pose.x_m, pose.y_m) < 2e-3


def test_thesis_command_drives_the_circle_of_its_arithmetic(opened):
    left, right = amigobot.THESIS_LEFT_MPS, amigobot.THESIS_RIGHT_MPS
    radius_m = amigobot.TRACK_M / 2 * (left + right) / (right - left)
    with opened(OPEN) as engine:
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
def test_collision_is_told_and_nothing_is_passed_through(opened, thing):
    with opened(world(thing)) as engine:
        assert not engine.advance(0.3, 0.3, 0.5)
        assert engine.advance(0.3, 0.3, 4.0)
        assert engine.pose.x_m == pytest.approx(0.5 - amigobot.BODY_RADIUS_M, abs=0.01)


def test_start_too_near_a_wall_is_refused(opened):
    near = world(box("wall", 0.1, -1, 0.2, 1))
    with pytest.raises(InputError, match=r"start of \(0, 0\) m, 0 degrees must leave the robot"):
        opened(near)


def test_closing_twice_is_fine(opened):
    engine = opened(OPEN)
    engine.close()
    engine.close()


def test_two_engines_do_not_meet(opened):
    def drive(engine):
        return [(engine.advance(0.1, 0.15, 0.2), engine.pose) for _ in range(10)]

    with opened(OPEN) as alone:
        expected = drive(alone)
    wall = world(box("wall", 0.3, -1, 0.4, 1, ROUGH), start=(0.0, 0.0, 0.5))
    with opened(OPEN) as one, opened(wall) as two:
        mixed = []
        for _ in range(10):
            mixed.append((one.advance(0.1, 0.15, 0.2), one.pose))
            two.advance(0.3, 0.3, 0.2)
            assert cast_one(one, (0, 0), 0.0)[0] == pytest.approx(4)
    assert mixed == expected


def test_an_engine_of_ones_own_is_found_by_its_module(mine):
    mine.Segments = type("Own", (Segments,), {})
    with open_engine("mine:Segments", OPEN) as engine:
        assert type(engine) is mine.Segments


def test_unknown_engine_is_refused_with_the_nearest_name():
    with pytest.raises(InputError, match=r"engine 'bulet' is unknown; did you mean 'bullet'\?"):
        open_engine("bulet", OPEN)


def test_a_start_inside_of_a_solid_is_refused_however_far_its_faces_are(opened):
    block = world(box("block", -2, -2, 2, 2), start=(0.0, 0.0, 0.0))
    with (
        pytest.raises(InputError, match=r"start of \(0, 0\) m, 0 degrees must leave"),
        opened(block),
    ):
        pass


def test_a_drive_may_begin_elsewhere(opened):
    with opened(OPEN, start=Pose(1.0, -2.0, math.pi / 2)) as engine:
        engine.advance(0.1, 0.1, 1.0)
        pose = engine.pose
    assert pose.x_m == pytest.approx(1.0, abs=2e-3)
    assert pose.y_m > -1.95


def test_segments_has_no_window():
    with pytest.raises(InputError, match="engine 'segments' has no window"):
        open_engine("segments", OPEN, gui=True)


@pytest.mark.parametrize("heading_deg", [20, 45, 70])
def test_a_robot_slides_along_a_wall_and_never_into_it(heading_deg):
    wall = world(box("wall", 1, -9, 1.1, 9), start=(0.0, 0.0, math.radians(heading_deg)))
    with open_engine("segments", wall) as engine:
        touched = [engine.advance(0.3, 0.3, 0.5) for _ in range(20)]
        pose = engine.pose
    assert touched[-1]
    assert pose.x_m == pytest.approx(1 - amigobot.BODY_RADIUS_M, abs=1e-6)
    # Along the wall the speed is what the heading leaves of it.
    driven_m = 0.3 * 10 - 0.3**2 / (2 * amigobot.ACCELERATION_MPS2)
    assert pose.y_m == pytest.approx(driven_m * math.sin(math.radians(heading_deg)), abs=0.01)
    assert pose.heading_rad == pytest.approx(math.radians(heading_deg))


def test_a_robot_stays_in_a_corner_and_its_wheels_turn_on():
    corner = world(
        box("right", 1, -3, 1.1, 1.1), box("top", -3, 1, 1.1, 1.1), start=(0, 0, math.pi / 4)
    )
    with open_engine("segments", corner) as engine:
        for _ in range(20):
            engine.advance(0.3, 0.3, 0.5)
            before = engine.pose
        assert engine.advance(0.3, 0.3, 0.5)
        pose, turns = engine.pose, engine.wheel_turns_rad
    assert (pose.x_m, pose.y_m) == pytest.approx((before.x_m, before.y_m), abs=1e-6)
    assert pose.x_m == pytest.approx(1 - amigobot.BODY_RADIUS_M, abs=1e-6)
    assert turns[0] * amigobot.WHEEL_RADIUS_M > 2.9


def test_a_slot_narrower_than_the_robot_lets_it_in_nowhere():
    half = amigobot.BODY_RADIUS_M - 0.02
    slot = world(box("left", 1, half, 3, 2), box("right", 1, -2, 3, -half))
    with open_engine("segments", slot) as engine:
        for _ in range(20):
            engine.advance(0.3, 0.3, 0.5)
            x_m, y_m = engine.pose.x_m, engine.pose.y_m
            # The nearest points are the two edges of the slot.
            apart_m = math.hypot(max(1 - x_m, 0), half - abs(y_m))
            assert apart_m >= amigobot.BODY_RADIUS_M - 1e-6
    assert x_m < 1


# The same rays on both engines: where faces are known sonars need none.
FAN = sonars.preset("aria").replace(rays=31)
BY_RAYS = sonars.preset("physical").replace(search="rays")


def score(log, world):
    grid = sm.GridSpec.covering(*world.bounds_m, 0.05)
    map_ = sm.build_map(log, sm.ParameterizedModel.thesis(), grid)
    return sm.score_map(map_, worlds.truth(world, grid)).map_score


@pytest.mark.parametrize("room", ["thesis-exp1", "clutter", "office"])
@pytest.mark.parametrize("sonar", [FAN, BY_RAYS], ids=["aria", "physical"])
def test_the_same_drive_sounds_the_same_on_both_engines(room, sonar):
    known = worlds.load(room)
    log = sim.simulate(known, scans=100, seed=5, sonar=sonar, driver="follow-left")
    poses = log.at_true_poses()
    readings = {}
    for engine in ENGINES:
        with open_engine(engine, known) as rays:
            rng = np.random.default_rng(1)
            heard = sonar.listen(rays, known, poses.sensor_xy_m, poses.axis_rad, rng)
            readings[engine] = heard.range_m
    same = np.isclose(readings["bullet"], readings["segments"], atol=2e-3)
    assert same.mean() >= 0.995
    bullet, segments = (score(poses.replace(range_m=readings[e]), known) for e in ENGINES)
    assert bullet == pytest.approx(segments, abs=0.005)


@pytest.mark.parametrize("room", ["thesis-exp1", "round-room", "clutter"])
def test_a_drive_on_either_engine_scores_alike(room):
    # Without collisions, in which PyBullet's friction turns the robot.
    known = worlds.load(room)
    logs = [
        sim.simulate(known, scans=250, seed=5, sonar=FAN, driver="thesis", engine=engine)
        for engine in ENGINES
    ]
    assert not any(log.truth.collision.any() for log in logs)
    bullet, segments = (score(log, known) for log in logs)
    assert bullet == pytest.approx(segments, abs=0.02)
    shares = [np.bincount(log.truth.cause, minlength=6) / len(log) for log in logs]
    assert shares[0] == pytest.approx(shares[1], abs=0.03)
