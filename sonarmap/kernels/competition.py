"""The compiled loops of `sonarmap.methods.arc_competition`: who caused each echo, and a round.

The plain version is in the tests (`tests/sonarmap/methods/test_arc_competition.py`).
"""

from __future__ import annotations

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["claims", "compete"]


@njit(error_model="numpy")
def claims(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    first, range_m, share, reading_m, echo, tolerance_m, range_max_m
):
    """Return what each listed cell is to its reading, float32 (cells,).

    Positive: on the arc, with the strength of the beam, 1 - share**2. Negative: passed through,
    less the strength of the beam and the nearness, 1 - range / range_max. 0: neither.
    """
    claim = np.zeros(range_m.size, np.float32)
    for i in range(reading_m.size):
        for k in range(first[i], first[i + 1]):
            beam = 1.0 - share[k] * share[k]
            if echo[i] and abs(range_m[k] - reading_m[i]) <= tolerance_m:
                claim[k] = beam
            elif range_m[k] < reading_m[i]:
                claim[k] = -beam * max(1.0 - range_m[k] / range_max_m, 0.0)
    return claim


@njit(error_model="numpy")
def compete(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    p, first, cell, claim, vote, echo, unexplained, rival_weight, pass_weight, hits, misses
):
    """Share each echo out among the cells of its arc, and add up what they gain and lose.

    Parameters
    ----------
    p : ndarray, shape (cells of the grid,)
        P(occupied) so far, below 1.
    first, cell, claim
        Cells of each reading (`ListedCones`), and what they are to it (`claims`).
    vote : ndarray, shape (n,)
        Weight of each reading.
    echo : ndarray of bool, shape (n,)
        Which readings have an echo.
    unexplained : float
        Odds that an echo has a cause off its arc.
    rival_weight, pass_weight : float
        What an echo that another cell caused, and a pass, count against a cell.
    hits, misses : ndarray, shape (cells of the grid,)
        Changed in place.
    """
    for i in range(vote.size):
        odds = 0.0
        for k in range(first[i], first[i + 1]):
            if claim[k] > 0.0:
                odds += claim[k] * p[cell[k]] / (1.0 - p[cell[k]])
        # How far the reading is believed: an echo by what may have caused it.
        trust = vote[i] * (odds / (odds + unexplained) if echo[i] else 1.0)
        for k in range(first[i], first[i + 1]):
            at, mine = cell[k], claim[k]
            if mine > 0.0:
                share = mine * p[at] / (1.0 - p[at]) / odds
                hits[at] += trust * share
                misses[at] += trust * (1.0 - share) * mine * rival_weight
            else:
                misses[at] -= trust * mine * pass_weight
