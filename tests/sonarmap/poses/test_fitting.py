"""One fit of a path and its walls: derivatives, and which way is square."""

import math

import numpy as np
import pytest

import sonarmap as sm
from sonarmap.poses.echoes import used_echoes
from sonarmap.poses.fitting import _Agreement, fitted, square_axis
from sonarmap.poses.path import CorrectedPath
from sonarmap.poses.walls import attributed, find_walls

SIGMA_M = 0.05


@pytest.fixture
def path(drive):
    return CorrectedPath(drive[1], sm.OdometryErrors(), 1.0)


@pytest.fixture
def echoes(drive, path):
    return used_echoes(drive[1], path)


@pytest.fixture
def walls(path, echoes):
    return find_walls(echoes.seen(path, np.zeros(path.parameters)), SIGMA_M)


@pytest.fixture
def agreement(path, echoes, walls):
    echo, wall = attributed(echoes.seen(path, np.zeros(path.parameters)), walls, SIGMA_M)
    used, wall = np.unique(wall, return_inverse=True)
    at = np.concatenate([np.zeros(path.parameters), walls[used].ravel(), [0.1]])
    return _Agreement(echoes.some(echo), wall, path, SIGMA_M), at


def test_derivatives_are_those_of_small_steps(agreement, rng):
    agreement, at = agreement
    at = at + rng.normal(0, 0.01, at.size)
    rates = agreement.jacobian(at)
    for k in range(at.size):
        step = np.zeros(at.size)
        step[k] = 1e-6
        difference = agreement.residuals(at + step) - agreement.residuals(at - step)
        assert np.allclose(rates[:, k], difference / 2e-6, rtol=1e-4, atol=1e-3)


def test_the_loss_has_its_own_derivatives(agreement):
    agreement, at = agreement
    squared = agreement.residuals(at) ** 2 + 0.1
    told, step = agreement.loss(squared), 1e-5
    more, less = agreement.loss(squared + step), agreement.loss(squared - step)
    assert np.allclose(told[1], (more[0] - less[0]) / (2 * step), atol=1e-6)
    assert np.allclose(told[2], (more[1] - less[1]) / (2 * step), atol=1e-6)


def test_a_fit_explains_the_echoes_better(path, echoes, walls):
    def unexplained(parameters, walls):
        seen = echoes.seen(path, parameters)
        echo, wall = attributed(seen, walls, SIGMA_M)
        off_m = seen.distance_m(walls[:, 0])[echo, wall] - walls[wall, 1]
        return len(seen.range_m) - np.exp(-0.5 * (off_m / 0.02) ** 2).sum()

    start = np.zeros(path.parameters)
    assert unexplained(*fitted(echoes, path, start, walls, SIGMA_M)) < unexplained(start, walls)


def test_walls_that_no_echo_met_change_nothing(path, echoes):
    start = np.full(path.parameters, 0.001)
    parameters, walls = fitted(echoes, path, start, np.array([[0.0, 99.0]]), SIGMA_M)
    assert np.array_equal(parameters, start)
    assert walls.shape == (0, 2)


@pytest.mark.parametrize("turned_rad", [0.0, 0.4, -2.0])
def test_most_walls_decide_what_is_square(turned_rad):
    # Four walls of a room, a slanted one with more echoes than any of them, and two others.
    normal_rad = turned_rad + np.array([0.0, math.pi / 2, math.pi, -math.pi / 2, 0.5, 1.0, 2.4])
    support = np.array([30.0, 20.0, 30.0, 20.0, 60.0, 5.0, 5.0])
    askew = 4 * (square_axis(normal_rad, support) - turned_rad)
    assert math.cos(askew) == pytest.approx(1)


def test_a_wall_that_is_far_from_square_stays_slanted(agreement):
    """Its vote costs the less to overrule the farther off it is: the loss is robust."""
    agreement, at = agreement
    near, far = at.copy(), at.copy()
    square = near[-1]
    count = (at.size - 1 - agreement._m) // 2
    first = agreement._m
    slopes = []
    for askew_rad, x in ((0.01, near), (0.3, far)):
        x[first] = square + askew_rad
        squared = agreement.residuals(x) ** 2
        row = squared.size - agreement._m - count
        weight = agreement.loss(squared)[1][row]
        slopes.append(weight * abs(agreement.residuals(x)[row]))
    assert slopes[1] < slopes[0] / 5
