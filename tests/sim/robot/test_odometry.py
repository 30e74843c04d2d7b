import math

import numpy as np
import pytest

from sim.robot.amigobot import TRACK_M, WHEEL_RADIUS_M
from sim.robot.odometry import Odometer, OdometryModel
from sonarmap import InputError
from worlds import Pose

START = Pose(1.0, 2.0, math.pi / 2)


def turns(left_m, right_m):
    return left_m / WHEEL_RADIUS_M, right_m / WHEEL_RADIUS_M


def test_straight_way_is_added_along_the_heading(rng):
    odometer = Odometer(OdometryModel.exact(), START, rng)
    pose = odometer.update(turns(0.5, 0.5))
    assert (pose.x_m, pose.y_m) == pytest.approx((1.0, 2.5), abs=1e-6)
    assert pose.heading_rad == START.heading_rad


@pytest.mark.parametrize("steps", [1, 7, 200])
def test_half_circle_ends_where_it_must_however_often_it_is_read(rng, steps):
    radius_m = 0.4
    left_m, right_m = math.pi * (radius_m - TRACK_M / 2), math.pi * (radius_m + TRACK_M / 2)
    odometer = Odometer(OdometryModel.exact(), START, rng)
    for step in range(1, steps + 1):
        pose = odometer.update(turns(left_m * step / steps, right_m * step / steps))
    assert (pose.x_m, pose.y_m) == pytest.approx((1.0 - 2 * radius_m, 2.0), abs=1e-4)
    assert pose.heading_rad == pytest.approx(START.heading_rad + math.pi, abs=1e-4)


def test_encoders_never_lose_more_than_a_tick(rng):
    model = OdometryModel(scale_spread=0, turn_spread=0, slip_std_m=0)
    odometer = Odometer(model, START, rng)
    tick_m = 2 * math.pi * WHEEL_RADIUS_M / model.ticks_per_turn
    for driven_m in np.linspace(0, 1, 337):
        pose = odometer.update(turns(driven_m, driven_m))
        assert -1e-12 <= 2.0 + driven_m - pose.y_m <= tick_m + 1e-12


def errors(model, drive, seeds=400):
    found = []
    for seed in range(seeds):
        odometer = Odometer(model, Pose(0, 0, 0), np.random.default_rng(seed))
        found.append(drive(odometer))
    return np.array(found)


def test_scale_error_is_even_over_its_spread_and_leaves_turns_alone():
    model = OdometryModel(ticks_per_turn=10**6, scale_spread=0.02, turn_spread=0.0, slip_std_m=0.0)
    way = errors(model, lambda odometer: odometer.update(turns(1.0, 1.0)).x_m - 1.0)
    assert np.abs(way).max() <= 0.01 + 1e-5
    assert way.std() == pytest.approx(0.02 / math.sqrt(12), rel=0.1)
    turned = errors(model, lambda odometer: odometer.update(turns(-0.3, 0.3)).heading_rad)
    assert np.ptp(turned) < 1e-4


def test_turn_error_is_even_over_its_spread():
    model = OdometryModel(ticks_per_turn=10**6, scale_spread=0.0, turn_spread=0.02, slip_std_m=0.0)
    turn = 0.6 / TRACK_M
    turned = errors(model, lambda odometer: odometer.update(turns(-0.3, 0.3)).heading_rad)
    assert np.abs(turned / turn - 1).max() <= 0.01 + 1e-5
    assert (turned / turn - 1).std() == pytest.approx(0.02 / math.sqrt(12), rel=0.1)


def test_slip_grows_with_the_root_of_the_way_whatever_the_steps():
    model = OdometryModel(ticks_per_turn=10**6, scale_spread=0.0, turn_spread=0.0, slip_std_m=0.01)

    def drive(odometer, steps):
        for step in range(1, steps + 1):
            pose = odometer.update(turns(4.0 * step / steps, 4.0 * step / steps))
        return pose.heading_rad * TRACK_M

    expected = math.sqrt(2) * 0.01 * math.sqrt(4.0)  # two wheels, 4 m
    for steps in (1, 50):
        found = errors(model, lambda odometer, steps=steps: drive(odometer, steps))
        assert found.std() == pytest.approx(expected, rel=0.12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ticks_per_turn": 0}, r"ticks_per_turn must be >= 1, got 0"),
        ({"scale_spread": -1}, r"scale_spread must be >= 0, got -1"),
        ({"turn_spread": math.inf}, r"turn_spread must be >= 0, got inf"),
        ({"slip_std_m": math.nan}, r"slip_std_m must be >= 0, got nan"),
    ],
)
def test_bad_settings_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        OdometryModel(**changes)
