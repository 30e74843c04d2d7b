"""The compiled loop of `sonarmap.filters.consistency`: walks through a map along the rays of cones.

The plain version is in the tests (`tests/sonarmap/filters/test_consistency.py`).
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.jit import njit

__all__ = ["walk"]


@njit(error_model="numpy")
def walk(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    p,
    grid,
    sensor_xy,
    axis_rad,
    bearing_rad,
    reading_m,
    reach_m,
    step_m,
    offsets_m,
    levels,
    about_m,
):
    """Return what the map says along rays: survival about the reading, and where it falls.

    Survival at a range is the probability that nothing stands nearer on the ray: the product of
    1 - P over the cells met, each step's by its share of a cell. Outside of the map nothing stands.

    Parameters
    ----------
    p : ndarray, shape (rows, cols)
        P(occupied).
    grid : tuple of float
        Lower-left corner and cell size, metres.
    sensor_xy, axis_rad : ndarray, shapes (n, 2), (n,)
        Places and axes of the sonars.
    bearing_rad : ndarray, shape (rays,)
        Of each ray off the axis.
    reading_m : ndarray, shape (n,)
        The readings; of no echo, the maximum range.
    reach_m, step_m : float
        How far rays go, and their step.
    offsets_m : ndarray, shape (k,)
        Ascending; survival is noted at the reading and these.
    levels : ndarray, shape (m,)
        Descending, in (0, 1); the range is noted at which survival falls below each.
    about_m : float
        What is nearer than this to the reading is at it; what is not, and nearer to the sonar, is
        before it.

    Returns
    -------
    survival : ndarray, shape (n, rays, k)
    falls_m : ndarray, shape (n, rays, m)
        `reach_m` where it does not.
    mean_m : ndarray, shape (n, rays)
        Mean free way up to the reach, metres.
    peak : ndarray, shape (n, rays, 2)
        Largest P before the reading, and at it: what is diffuse, and by and by lets survival fall,
        has none.
    """
    n, rays, k, m = axis_rad.size, bearing_rad.size, offsets_m.size, levels.size
    survival = np.ones((n, rays, k))
    falls = np.full((n, rays, m), reach_m)
    mean = np.zeros((n, rays))
    peak = np.zeros((n, rays, 2))
    rows, cols = p.shape
    x0, y0, size = grid
    steps = math.ceil(reach_m / step_m)
    for i in range(n):
        for ray in range(rays):
            dx = math.cos(axis_rad[i] + bearing_rad[ray]) * step_m
            dy = math.sin(axis_rad[i] + bearing_rad[ray]) * step_m
            s, at, level, done = 1.0, 0, 0, False
            for step in range(steps):
                r = (step + 0.5) * step_m
                while at < k and reading_m[i] + offsets_m[at] <= r:
                    survival[i, ray, at] = s
                    at += 1
                row = cell_index(sensor_xy[i, 1] + (step + 0.5) * dy, y0, size)
                col = cell_index(sensor_xy[i, 0] + (step + 0.5) * dx, x0, size)
                if 0 <= row < rows and 0 <= col < cols:
                    here = p[row, col]
                    if r < reading_m[i] - about_m:
                        peak[i, ray, 0] = max(peak[i, ray, 0], here)
                    elif r <= reading_m[i] + about_m:
                        peak[i, ray, 1] = max(peak[i, ray, 1], here)
                    if not done:
                        s *= math.exp(math.log(1.0 - min(here, 0.999)) * step_m / size)
                if done:
                    continue
                mean[i, ray] += s * step_m
                while level < m and s < levels[level]:
                    falls[i, ray, level] = r
                    level += 1
                # What lies beyond has no survival left to lose, but may be where the reading is.
                done = s < 1e-3
                if done and r > reading_m[i] + about_m:
                    break
            while at < k:
                survival[i, ray, at] = s
                at += 1
    return survival, falls, mean, peak
