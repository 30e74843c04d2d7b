"""Cones as lists: the cells by plain geometry."""

import math

import numpy as np
from support import random_log

import sonarmap as sm
from sonarmap.kernels.listed_cones import ListedCones

GRID = sm.GridSpec(0.1, (-1.5, -1.2), (23, 31))


def test_equals_plain_geometry(rng):
    log = random_log(rng, 40)
    reach_m = rng.uniform(0, 2, len(log))
    cones = ListedCones.on(GRID, log.sensor_xy_m, log.axis_rad, 0.3, reach_m)
    assert cones.first[0] == 0
    assert cones.first[-1] == cones.cell.size == cones.range_m.size == cones.share.size
    for i, (x, y) in enumerate(log.sensor_xy_m):
        listed = slice(cones.first[i], cones.first[i + 1])
        expected = {}
        for row in range(GRID.rows):
            for col in range(GRID.cols):
                dx, dy = np.subtract(GRID.centre_of(row, col), (x, y))
                off = abs(math.remainder(math.atan2(dy, dx) - log.axis_rad[i], 2 * math.pi))
                if math.hypot(dx, dy) <= reach_m[i] and off <= 0.3:
                    expected[row * GRID.cols + col] = (math.hypot(dx, dy), off / 0.3)
        assert cones.cell[listed].tolist() == sorted(expected)
        got = np.column_stack([cones.range_m[listed], cones.share[listed]])
        np.testing.assert_allclose(
            got, np.reshape([expected[c] for c in sorted(expected)], (-1, 2)), atol=1e-9
        )
