"""The compiled loops of `sonarmap.filters.range_confidence`: who sees which surface from where.

The plain version is in the tests (`tests/sonarmap/filters/test_range_confidence.py`).
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["facing_odds", "orientation_votes"]


@njit(inline="always", error_model="numpy")
def _faces(dx, dy, k, orientations, critical_rad):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return whether a surface with normal k sends an echo back along (dx, dy)."""
    off = math.atan2(dy, dx) - k * 2.0 * math.pi / orientations
    off = abs(off - 2.0 * math.pi * math.floor(off / (2.0 * math.pi) + 0.5))
    return off <= critical_rad


@njit(error_model="numpy")
def orientation_votes(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    evidence, first, cell, centre_x, centre_y, sensor_xy, weight, critical_rad
):
    """Add to the log-probability of each cell's orientations (cells, k) what n echoes say.

    `weight` (n,) is what an echo adds to each orientation that faces its sonar.
    """
    orientations = evidence.shape[1]
    for i in range(weight.size):
        for j in range(first[i], first[i + 1]):
            c = cell[j]
            dx, dy = sensor_xy[i, 0] - centre_x[c], sensor_xy[i, 1] - centre_y[c]
            for k in range(orientations):
                if _faces(dx, dy, k, orientations, critical_rad):
                    evidence[c, k] += weight[i]


@njit(error_model="numpy")
def facing_odds(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    evidence, first, cell, centre_x, centre_y, sensor_xy, weight, critical_rad
):
    """Return the odds that the best cell of each arc faces its sonar, (n,), 1 for no evidence.

    An echo's own vote does not count.
    """
    orientations = evidence.shape[1]
    odds = np.ones(weight.size)
    for i in range(weight.size):
        best = 0.0
        for j in range(first[i], first[i + 1]):
            c = cell[j]
            dx, dy = sensor_xy[i, 0] - centre_x[c], sensor_xy[i, 1] - centre_y[c]
            facing, others, n = 0.0, 0.0, 0
            # Probabilities relative to the likeliest, lest they overflow.
            top = evidence[c].max()
            for k in range(orientations):
                if _faces(dx, dy, k, orientations, critical_rad):
                    facing += math.exp(evidence[c, k] - weight[i] - top)
                    n += 1
                else:
                    others += math.exp(evidence[c, k] - top)
            if 0 < n < orientations:
                best = max(best, facing / n / (others / (orientations - n)))
        if best > 0.0:
            odds[i] = best
    return odds
