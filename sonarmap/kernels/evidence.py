"""The compiled loops of `sonarmap.learned.channels`: what the cones of a log say of each cell.

The plain versions are in the tests (`tests/sonarmap/learned/test_channels.py`).
"""

from __future__ import annotations

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["SUMS", "arc_shares", "sum_evidence"]

(
    TIMID,
    PASS_AXIS,
    PASS_EDGE,
    PASS_CORE,
    PASS_SHORT,
    PASS_STEADY,
    NONE_AXIS,
    NONE_EDGE,
    HIT_AXIS,
    HIT_EDGE,
    HIT_CORE,
    HIT_ALL,
    HIT_FAR,
    HIT_STEADY,
    SHADOW,
    NONE_FAR,
    HIT_TRAVEL,
) = range(17)
SUMS = 17
"""Sums that `sum_evidence` keeps of each cell."""


@njit(error_model="numpy")
def sum_evidence(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    first,
    cell,
    range_m,
    share,
    reading_m,
    echo,
    steady,
    vote,
    bin_of,
    arc_weight,
    travel_m,
    limits,
    sums,
    passed,
    hit,
    nearest,
):
    """Add what readings say of the cells in their cones.

    Parameters
    ----------
    first, cell, range_m, share
        Cells of each reading, see `sonarmap.kernels.listed_cones.ListedCones`.
    reading_m : ndarray, shape (n,)
        The reading; of no echo, the maximum range, metres.
    echo, steady : ndarray of bool, shape (n,)
        Which readings have an echo, and which agree with one of the same sonar before or after.
    vote : ndarray, shape (n,)
        Weight of each reading.
    bin_of : ndarray of int, shape (n,)
        Direction of the axis, one of 16.
    arc_weight : ndarray, shape (n,)
        One over the number of cells on the arc.
    travel_m : ndarray, shape (n,)
        Way of the robot up to each reading, metres.
    limits : tuple of float
        Half of the thickness of an arc, and of one in the competition, depth of the shadow behind
        one, bound of a short reading, bearings / half-angle of the core and of the axis, up to
        where no echo is near, maximum range; metres.
    sums : ndarray of float32, shape (cells of the grid, SUMS)
        Added to.
    passed, hit : ndarray of uint16, shape (cells of the grid,)
        Directions from which a cell was passed through, or lay on an arc, as bits; added to.
    nearest : ndarray of float32, shape (cells of the grid, 3)
        Least range at which a cell was passed through, and lay on an arc, and least way at which
        it was passed through; lowered.

    Returns
    -------
    first, cell, claim
        The cells that are something to their reading in the competition, and what, as
        `sonarmap.kernels.competition.claims` says; of no echo only the near ones.
    """
    tolerance, narrow, depth, short, core, middle, near, farthest = limits
    of = np.zeros(reading_m.size + 1, np.int64)
    claimed, claim = np.empty(cell.size, np.int32), np.empty(cell.size, np.float32)
    n = 0
    for i in range(reading_m.size):
        r, v, a = reading_m[i], vote[i], arc_weight[i]
        until = r if echo[i] else min(r, near)
        bit = np.uint16(1 << bin_of[i])
        is_short, is_far = r <= short, r > short
        for k in range(first[i], first[i + 1]):
            at, rho, s = cell[k], range_m[k], share[k]
            beam = 1.0 - s * s
            mine = 0.0
            if echo[i] and abs(rho - r) <= narrow:
                mine = beam
            elif rho < until:
                mine = -beam * max(1.0 - rho / farthest, 0.0)
            if mine != 0.0:
                claimed[n], claim[n] = at, mine
                n += 1
            if not echo[i]:
                if rho >= near:
                    sums[at, NONE_FAR] += v * beam
                else:
                    sums[at, NONE_AXIS if s <= middle else NONE_EDGE] += v
                    sums[at, TIMID] -= 0.1 * v * beam * (1.0 - rho / farthest)
            elif rho < r - tolerance:
                sums[at, PASS_AXIS if s <= middle else PASS_EDGE] += v
                if s <= core:
                    sums[at, PASS_CORE] += v
                if is_short:
                    sums[at, PASS_SHORT] += v
                if steady[i]:
                    sums[at, PASS_STEADY] += v
                sums[at, TIMID] -= 0.3 * v * beam * (1.0 - rho / farthest)
                passed[at] |= bit
                nearest[at, 0] = min(nearest[at, 0], rho)
                nearest[at, 2] = min(nearest[at, 2], travel_m[i])
            elif rho <= r + tolerance:
                w = v * (1.0 - abs(rho - r) / tolerance)
                sums[at, HIT_AXIS if s <= middle else HIT_EDGE] += w * a
                sums[at, HIT_ALL] += w
                if s <= core:
                    sums[at, HIT_CORE] += w
                if is_far:
                    sums[at, HIT_FAR] += w * a
                if steady[i]:
                    sums[at, HIT_STEADY] += w * a
                sums[at, HIT_TRAVEL] += w * a * travel_m[i]
                sums[at, TIMID] += 6.0 * w * a * beam
                hit[at] |= bit
                nearest[at, 1] = min(nearest[at, 1], rho)
            elif rho <= r + depth:
                sums[at, SHADOW] += v * beam
        of[i + 1] = n
    return of, claimed[:n].copy(), claim[:n].copy()


@njit(error_model="numpy")
def arc_shares(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    p, first, cell, claim, vote, sensor_xy, unexplained, cols, place, out
):
    """Add up, for each cell, what the echoes that it may have caused say after the competition.

    Parameters
    ----------
    p : ndarray, shape (cells of the grid,)
        P(occupied) by the competition.
    first, cell, claim, vote
        See `sonarmap.kernels.competition.compete`.
    sensor_xy : ndarray, shape (n, 2)
        Places of the sonars, metres.
    unexplained : float
        Odds that an echo has a cause off its arc.
    cols : int
        Columns of the grid.
    place : tuple of float
        Lower-left corner and cell size, metres.
    out : ndarray, shape (cells of the grid, 4)
        Added to: shares of echoes, and cosine and sine of twice the direction from the sonar,
        each by its share. The last is the largest share; raised.
    """
    x0, y0, size = place
    for i in range(vote.size):
        odds = 0.0
        for k in range(first[i], first[i + 1]):
            if claim[k] > 0.0:
                odds += claim[k] * p[cell[k]] / (1.0 - p[cell[k]])
        if odds == 0.0:
            continue
        trust = odds / (odds + unexplained)
        for k in range(first[i], first[i + 1]):
            if claim[k] <= 0.0:
                continue
            at = cell[k]
            share = trust * claim[k] * p[at] / (1.0 - p[at]) / odds
            dx = x0 + (at % cols + 0.5) * size - sensor_xy[i, 0]
            dy = y0 + (at // cols + 0.5) * size - sensor_xy[i, 1]
            squared = max(dx * dx + dy * dy, 1e-12)
            out[at, 0] += vote[i] * share
            out[at, 1] += vote[i] * share * (dx * dx - dy * dy) / squared
            out[at, 2] += vote[i] * share * 2.0 * dx * dy / squared
            out[at, 3] = max(out[at, 3], share)
