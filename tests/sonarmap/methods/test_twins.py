"""Each method against its plain twin: the equations as they are written, cell by cell."""

import math

import numpy as np
import pytest
from support import random_log

import sonarmap as sm

GRID = sm.GridSpec(0.09, (-1.1, -0.9), (21, 25))


def beams(log, method):
    """Yield (row of the log, reading, was there an echo) of the readings that say anything."""
    limit = method.longest_reading_m(log.ring)
    for i in range(len(log)):
        if log.stale[i] or log.rejected[i] or log.range_m[i] == -math.inf:
            continue
        echo = log.range_m[i] <= limit
        if echo or method.no_echo == "clear":
            yield i, (log.range_m[i] if echo else limit), bool(echo)


def cone(log, i, grid, half_angle):
    """Yield (row, col, range, bearing / half-angle) of the cells in a cone, however far."""
    x, y = log.sensor_xy_m[i]
    for row in range(grid.rows):
        for col in range(grid.cols):
            cx, cy = grid.centre_of(row, col)
            turn = math.remainder(math.atan2(cy - y, cx - x) - log.axis_rad[i], 2 * math.pi)
            if abs(turn) <= half_angle:
                yield row, col, math.hypot(cx - x, cy - y), abs(turn) / half_angle


def logistic(log_odds):
    return 0.5 * (1 + np.tanh(log_odds / 2))


def plain_thrun(log, grid, m):
    log_odds = np.zeros(grid.shape)
    for i, z, echo in beams(log, m):
        for row, col, r, _ in cone(log, i, grid, log.ring.half_angle_rad):
            if r > min(m.longest_reading_m(log.ring), z + m.thickness_m / 2):
                continue
            if echo and abs(r - z) < m.thickness_m / 2:
                log_odds[row, col] += m.occupied_log_odds
            elif r <= z:
                log_odds[row, col] += m.free_log_odds
    return logistic(log_odds)


def plain_free_space(log, grid, m):
    p = np.full(grid.shape, m.share)
    for i in np.flatnonzero(log.usable):
        for row in range(grid.rows):
            for col in range(grid.cols):
                x, y = grid.centre_of(row, col)
                if math.hypot(x - log.x_m[i], y - log.y_m[i]) <= m.radius_m:
                    p[row, col] = m.driven
    return p


CASES = [
    ("free-space", {}, plain_free_space),
    ("thrun-inverse", {}, plain_thrun),
    ("thrun-inverse", {"no_echo": "ignore", "occupied_log_odds": 1.3}, plain_thrun),
]


@pytest.mark.parametrize(("name", "parameters", "twin"), CASES)
def test_the_compiled_map_is_the_plain_one(name, parameters, twin, rng):
    log = random_log(rng, 30, reach_m=1.5, spread_m=0.8)
    if "max_range_m" in vars(sm.method(name)):
        parameters = {"max_range_m": 1.4, **parameters}  # a reading or two are above it
    method = sm.method(name, **parameters)
    p = twin(log, GRID, method)
    assert (p != np.median(p)).mean() > 0.02, "the case says nothing"
    np.testing.assert_allclose(method.map(log, GRID).probability, p, rtol=0, atol=1e-9)
