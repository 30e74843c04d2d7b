"""Compiled loops of the one-pass methods: what beams say of listed cells, into flat layers.

All take `first`, `cell`, `ranges` and `shares` of `sonarmap.methods.cones.Cells`. Each has its
plain twin in the tests of its method.
"""

from __future__ import annotations

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["add_thrun", "expand_runs"]


@njit(error_model="numpy")
def expand_runs(run_cell, run_length, size):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the cells of runs one by one: flat indices, int64 (size,)."""
    cell = np.empty(size, np.int64)
    n = 0
    for run in range(run_cell.size):
        for k in range(run_length[run]):
            cell[n] = run_cell[run] + k
            n += 1
    return cell


@njit(error_model="numpy")
def add_thrun(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds, seen, first, cell, ranges, reading, echo, half_thickness, occupied, free
):
    """Add the three cases of table 9.2 to the log-odds and mark the cells they speak of."""
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            r, c = ranges[k], cell[k]
            if echo[i] and abs(r - z) < half_thickness:
                log_odds[c] += occupied
            elif r <= z:
                log_odds[c] += free
            else:
                continue
            seen[c] = True
