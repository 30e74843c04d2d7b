import math

import numpy as np
import pytest
from rooms import closed_room, world

import sim
import worlds
from sim import ConstantSpeeds, RandomWander, Sensed, WallFollower, Waypoints
from sim.robot import drivers
from sonarmap import AMIGOBOT, InputError
from worlds import Pose


def sensed(*, x_m=0.0, y_m=0.0, heading_rad=0.0, range_m=None, time_s=0.0, collided=False):
    ranges = np.full(8, np.inf) if range_m is None else np.array(range_m, float)
    return Sensed(time_s, Pose(x_m, y_m, heading_rad), ranges, AMIGOBOT, collided=collided)


def test_nearest_looks_where_it_is_told():
    # left, front-left, front, front, front-right, right, rear-right, rear-left
    now = sensed(range_m=[1.0, 2.0, 3.0, np.inf, np.inf, -np.inf, 0.5, 0.6])
    assert now.nearest_m(80, 100) == 1.0
    assert now.nearest_m(-20, 20) == 3.0
    assert now.nearest_m(-50, -30) == math.inf
    assert now.nearest_m(-100, -80) == 0.0  # too close


def test_constant_speeds_are_the_thesis_own(rng):
    assert ConstantSpeeds().begin(rng)(sensed()) == (0.040, 0.075)


def test_way_point_ahead_is_driven_to_straight(rng):
    left, right = Waypoints(((1.0, 0.0),), speed_mps=0.2).begin(rng)(sensed())
    assert left == right == pytest.approx(0.2)


def test_way_point_behind_is_turned_to_in_place(rng):
    left, right = Waypoints(((-1.0, 0.1),)).begin(rng)(sensed())
    assert left == -right
    assert right > 0


def test_way_points_are_visited_there_and_back(rng):
    points = ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0))
    control = Waypoints(points).begin(rng)
    visited = []
    for x_m in (1, 2, 3, 2, 1, 2):
        # Standing on the target turns the eye to the next; it lies ahead or behind.
        left, right = control(sensed(x_m=x_m))
        visited.append("ahead" if left == right else "behind")
    assert visited == ["ahead", "ahead", "behind", "behind", "ahead", "ahead"]


@pytest.mark.engine
def test_route_is_driven_within_reach_of_its_points():
    room = worlds.load("l-shape")
    log = sim.simulate(room, scans=700, seed=0, driver="route", sonar="thesis")
    for x_m, y_m in room.route_m:
        assert np.hypot(log.x_m - x_m, log.y_m - y_m).min() < 0.11
    assert not log.truth.collision.any()


@pytest.mark.engine
@pytest.mark.parametrize("side", ["left", "right"])
def test_wall_is_kept_at_its_distance(side):
    towards = 1 if side == "left" else -1
    room = closed_room(2.0, start=(-1.0, towards * 1.3, 0.0))
    log = sim.simulate(room, scans=400, seed=0, driver=WallFollower(0.5, side), sonar="thesis")
    assert not log.truth.collision.any()
    # From the sonar, 0.1 m beside the middle, to the nearest wall; corners are cut.
    to_wall_m = 2.0 - np.maximum(np.abs(log.truth.x_m), np.abs(log.truth.y_m)) - 0.1
    assert np.median(to_wall_m[800:]) == pytest.approx(0.5, abs=0.12)
    # It goes all the way round.
    assert np.ptp(log.truth.x_m) > 2
    assert np.ptp(log.truth.y_m) > 2


@pytest.mark.engine
def test_wall_follower_that_finds_no_wall_does_not_circle_for_ever():
    log = sim.simulate(
        closed_room(4.5), scans=500, seed=0, driver=WallFollower(speed_mps=0.3), sonar="thesis"
    )
    assert np.hypot(log.truth.x_m, log.truth.y_m).max() > 3


@pytest.mark.engine
@pytest.mark.parametrize("seed", range(3))
def test_wanderer_stays_clear_and_gets_about(seed):
    log = sim.simulate(closed_room(1.8), scans=400, seed=seed, driver="wander", sonar="thesis")
    assert log.truth.collision.mean() < 0.02
    assert np.ptp(log.truth.x_m) + np.ptp(log.truth.y_m) > 1.5


def test_wanderer_backs_off_after_a_collision(rng):
    left, right = RandomWander().begin(rng)(sensed(collided=True))
    assert left == right < 0


def test_names_make_drivers():
    room = worlds.load("l-shape")
    for name in drivers.names():
        assert callable(drivers.driver(name, room).begin(np.random.default_rng(0)))


def test_without_a_name_the_route_is_driven_or_one_wanders():
    with_route, without = worlds.load("office"), worlds.load("thesis-exp1")
    assert drivers.driver("auto", with_route) == drivers.driver("route", with_route)
    assert drivers.driver("auto", without) == RandomWander()
    for room in (with_route, without):
        default = sim.simulate(room, scans=2, seed=0, sonar="aria", engine="segments")
        auto = sim.simulate(room, scans=2, seed=0, driver="auto", sonar="aria", engine="segments")
        assert default.provenance == auto.provenance


@pytest.mark.parametrize("name", worlds.names())
def test_the_default_driver_does_not_scrape_along_walls(name):
    log = sim.simulate(worlds.load(name), scans=500, seed=0, sonar="thesis", engine="segments")
    assert np.unique(log.scan[log.truth.collision]).size <= 5


def test_a_driver_of_ones_own_is_an_instance_a_class_or_a_function_of_the_world(mine):
    class Spin:
        def begin(self, rng):
            return lambda sensed: (-0.1, 0.1)

    mine.Spin, mine.spin = Spin, Spin()
    mine.along = lambda room: Waypoints(room.route_m)
    room = worlds.load("l-shape")
    assert isinstance(drivers.driver("mine:Spin", room), Spin)
    assert drivers.driver("mine:spin", room) is mine.spin
    assert drivers.driver("mine:along", room) == drivers.driver("route", room)
    log = sim.simulate(room, scans=3, seed=0, driver="mine:Spin", sonar="aria", engine="segments")
    assert (np.diff(log.truth.heading_rad[::8]) >= 0).all()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mine:number", "driver 'mine:number' must be a driver or make one, got 3"),
        ("sim:Waypoints", "driver 'sim:Waypoints' must be made without arguments: .*points_m"),
        ("mine:Nobody", "driver 'mine:Nobody' cannot be imported: 'mine' has no 'Nobody'"),
    ],
)
def test_what_is_no_driver_is_refused(mine, name, message):
    mine.number = 3
    with pytest.raises(InputError, match=message):
        drivers.driver(name, world())


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ConstantSpeeds(math.nan, 0.1), r"left_mps must be a finite number, got nan"),
        (lambda: Waypoints(()), r"points_m must have at least one point, got none"),
        (lambda: Waypoints("ab"), r"points_m must be points \(x, y\), got 'ab'"),
        (lambda: Waypoints(((0, 0, 1),)), r"points_m\[0\] must be \(x, y\) in metres"),
        (lambda: Waypoints((1.0, 2.0)), r"points_m\[0\] must be \(x, y\) in metres, got 1.0"),
        (lambda: Waypoints(((0, "1"),)), r"points_m\[0\] must be a number, got '1'"),
        (lambda: Waypoints(((0, math.nan),)), r"points_m\[0\] must be a finite number"),
        (lambda: Waypoints(((0, 0),), speed_mps=0), r"speed_mps must be > 0, got 0"),
        (lambda: WallFollower(-1), r"distance_m must be > 0, got -1"),
        (lambda: WallFollower(side="up"), r"side must be 'left' or 'right', got 'up'"),
        (lambda: RandomWander(whim_s=0), r"whim_s must be > 0, got 0"),
        (
            lambda: drivers.driver("rout", world()),
            r"driver 'rout' is unknown; did you mean 'route'",
        ),
    ],
)
def test_bad_settings_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()
