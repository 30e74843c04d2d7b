"""The compiled loops of `sonarmap.filters.conflict_evaluation`: who speaks loudest of each cell.

The plain version is in the tests (`tests/sonarmap/filters/test_conflict_evaluation.py`).
"""

from __future__ import annotations

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["judge", "loudest_votes"]


@njit(error_model="numpy")
def loudest_votes(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    loudest, occupied, first, cell, range_m, pressure, reading_m, echo, thickness_m
):
    """Let each cell keep the vote of the reading whose sound pressure there is largest.

    `loudest` (cells,) and `occupied` (cells,) are changed in place; a tie goes to occupied.
    """
    for i in range(reading_m.size):
        for k in range(first[i], first[i + 1]):
            near = range_m[k] < reading_m[i] - thickness_m or not echo[i]
            c = cell[k]
            if pressure[k] > loudest[c]:
                loudest[c], occupied[c] = pressure[k], not near
            elif pressure[k] == loudest[c] and not near:
                occupied[c] = True


@njit(error_model="numpy")
def judge(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied, first, cell, range_m, reading_m, echo, thickness_m
):
    """Return which readings the map contradicts, and the nearest occupied cell of each cone.

    Returns
    -------
    wrong : ndarray of bool, shape (n,)
    nearest_m : ndarray, shape (n,)
        Metres; inf for none within the cone as listed.
    """
    n = reading_m.size
    wrong, nearest_m = np.zeros(n, np.bool_), np.full(n, np.inf)
    for i in range(n):
        on_arc = False
        for k in range(first[i], first[i + 1]):
            if occupied[cell[k]]:
                nearest_m[i] = min(nearest_m[i], range_m[k])
                on_arc = on_arc or range_m[k] >= reading_m[i] - thickness_m
        if not echo[i]:
            wrong[i] = nearest_m[i] < np.inf
        else:
            wrong[i] = nearest_m[i] < reading_m[i] - thickness_m or not on_arc
    return wrong, nearest_m
