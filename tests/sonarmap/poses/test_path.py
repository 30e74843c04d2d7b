"""Paths corrected for the errors of odometry: what each parameter does, and derivatives."""

import math

import numpy as np
import pytest

import sonarmap as sm
from sonarmap.poses.path import CorrectedPath


@pytest.fixture
def path(drive):
    return CorrectedPath(drive[1], sm.OdometryErrors(), 1.0)


def test_no_error_leaves_the_poses_of_odometry(drive, path):
    _, log = drive
    xy, heading = path.poses(np.zeros(path.parameters))
    assert np.allclose(xy, np.column_stack([log.x_m, log.y_m]), atol=1e-12)
    assert np.allclose(np.exp(1j * heading), np.exp(1j * log.heading_rad), atol=1e-12)


def test_the_first_pose_stays(path, rng):
    before, turned = path.poses(np.zeros(path.parameters))
    after, still = path.poses(rng.normal(0, 0.05, path.parameters))
    assert np.array_equal(before[0], after[0])
    assert turned[0] == still[0]


def test_the_first_parameter_scales_distances_and_the_second_turns(path):
    none = np.zeros(path.parameters)
    scaled, turned = none.copy(), none.copy()
    scaled[0], turned[1] = 0.1, 0.1
    xy, heading = path.poses(none)
    larger, same = path.poses(scaled)
    assert np.allclose(larger - larger[0], 1.1 * (xy - xy[0]))
    assert np.array_equal(same, heading)
    _, more = path.poses(turned)
    assert np.allclose(more - more[0], 1.1 * (heading - heading[0]))


def test_knots_drift_linearly_over_the_wheels_way(path):
    parameters = np.zeros(path.parameters)
    knots = path.parameters - 2
    parameters[2:] = 0.2 * np.arange(1, knots + 1) / knots
    _, before = path.poses(np.zeros(path.parameters))
    _, after = path.poses(parameters)
    assert np.allclose(after - before, 0.2 * path.way_m / path.way_m[-1])


def test_derivatives_are_those_of_small_steps(path, rng):
    at = rng.normal(0, 0.02, path.parameters)
    rows = np.array([0, 1, 100, 1000, len(path.way_m) - 1])
    moves, turns = path.derivatives(at, rows)
    for k in range(path.parameters):
        step = np.zeros(path.parameters)
        step[k] = 1e-6
        (more, more_turned), (less, less_turned) = path.poses(at + step), path.poses(at - step)
        assert np.allclose(moves[:, :, k], (more - less)[rows] / 2e-6, atol=1e-6)
        assert np.allclose(turns[:, k], (more_turned - less_turned)[rows] / 2e-6, atol=1e-6)


def test_the_prior_is_the_slip_of_the_way_between_knots(drive):
    errors = sm.OdometryErrors(scale=0.1, turn=0.2, slip=0.03)
    path = CorrectedPath(drive[1], errors, 1.0)
    between_m = path.way_m[-1] / (path.parameters - 2)
    parameters = np.concatenate(
        [[0.1, 0.2], 0.03 * math.sqrt(between_m) * np.ones(path.parameters - 2)]
    )
    # All knots drifted as far as one is likely to: only the first step is one.
    assert np.allclose(path.prior @ parameters, [1, 1, 1, *np.zeros(path.parameters - 3)])


@pytest.mark.parametrize(
    ("field", "value", "rule"),
    [
        ("scale", 0.0, "scale must be .*> 0"),
        ("turn", -1.0, "turn must be .*> 0"),
        ("slip", math.nan, "slip must be .*> 0"),
        ("track_m", -0.1, "track_m must be .*>= 0"),
    ],
)
def test_errors_of_odometry_have_rules(field, value, rule):
    with pytest.raises(sm.InputError, match=rule):
        sm.OdometryErrors(**{field: value})
