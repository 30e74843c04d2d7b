"""The compiled loops of the forward models: hill climbing and belief propagation over cones.

A factor (`sonarmap.methods.forward.model.ConeFactors`) is ``floor + scale * near * window``. `near`
is the product of 1 - h m over the nearer cells. The window is worked out from its bins, each with
the probability `open` that none of its cells answers::

    window = V(0),  V(b) = (1 - open(b)) density(b) + open(b) V(b + 1),  V(5) = beyond

The plain versions are in the tests (`tests/sonarmap/methods/test_forward.py`).
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["by_cell", "climb", "log_likelihood", "log_odds", "propagate", "remember"]

_BINS = 5
# Beyond this a message is certain enough, and sums of them stay far from overflow.
_MESSAGE_MAX = 20.0


@njit(inline="always", error_model="numpy")
def _window(opened, density, beyond):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return what the bins make of sound that has come up to them."""
    value = beyond
    for b in range(_BINS - 1, -1, -1):
        value = (1.0 - opened[b]) * density[b] + opened[b] * value
    return value


@njit(inline="always", error_model="numpy")
def _window_with(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    opened, density, beyond, changed, factor
):
    """Return `_window` with one bin's `open` multiplied by a factor."""
    value = beyond
    for b in range(_BINS - 1, -1, -1):
        here = opened[b] * factor if b == changed else opened[b]
        value = (1.0 - here) * density[b] + here * value
    return value


@njit(error_model="numpy")
def by_cell(first, cell, cells):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the listed places of each cell: (begin (cells + 1,), place (touched,), reading)."""
    begin = np.zeros(cells + 1, np.int64)
    for k in range(cell.size):
        begin[cell[k] + 1] += 1
    for c in range(cells):
        begin[c + 1] += begin[c]
    place, reading = np.empty(cell.size, np.int64), np.empty(cell.size, np.int32)
    free = begin[:-1].copy()
    for i in range(first.size - 1):
        for k in range(first[i], first[i + 1]):
            at = free[cell[k]]
            place[at], reading[at] = k, i
            free[cell[k]] = at + 1
    return begin, place, reading


@njit(error_model="numpy")
def remember(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied, first, cell, zone, answers, density, beyond, near, opened, window
):
    """Work out `near` (n,), `open` (n, 5) and `window` (n,) of a map, in place."""
    near[:] = 1.0
    opened[:] = 1.0
    for i in range(near.size):
        for k in range(first[i], first[i + 1]):
            if occupied[cell[k]]:
                if zone[k] < 0:
                    near[i] *= 1.0 - answers[k]
                else:
                    opened[i, zone[k]] *= 1.0 - answers[k]
        window[i] = _window(opened[i], density[i], beyond[i])


@njit(error_model="numpy")
def log_likelihood(floor, scale, vote, near, window):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the log-likelihood of all readings of the map that was remembered."""
    total = 0.0
    for i in range(near.size):
        total += vote[i] * math.log(floor[i] + scale[i] * near[i] * window[i])
    return total


@njit(inline="always", error_model="numpy")
def _gain(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    c,
    occupied,
    begin,
    place,
    reading,
    zone,
    answers,
    floor,
    scale,
    density,
    beyond,
    vote,
    near,
    opened,
    window,
):
    """Return the log-likelihood with cell c flipped, less that of the map as it is."""
    gain = 0.0
    for j in range(begin[c], begin[c + 1]):
        k, i = place[j], reading[j]
        factor = 1.0 - answers[k]
        if occupied[c]:
            factor = 1.0 / factor
        now = floor[i] + scale[i] * near[i] * window[i]
        if zone[k] < 0:
            then = floor[i] + scale[i] * near[i] * factor * window[i]
        else:
            other = _window_with(opened[i], density[i], beyond[i], zone[k], factor)
            then = floor[i] + scale[i] * near[i] * other
        gain += vote[i] * math.log(then / now)
    return gain


@njit(error_model="numpy")
def climb(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied,
    order,
    prior_log_odds,
    begin,
    place,
    reading,
    zone,
    answers,
    floor,
    scale,
    density,
    beyond,
    vote,
    near,
    opened,
    window,
):
    """Visit cells in an order, flip each where that raises the posterior; return the flips.

    `occupied` and what was remembered of it are changed in place.
    """
    flips = 0
    for c in order:
        gain = _gain(
            c,
            occupied,
            begin,
            place,
            reading,
            zone,
            answers,
            floor,
            scale,
            density,
            beyond,
            vote,
            near,
            opened,
            window,
        )
        gain += -prior_log_odds if occupied[c] else prior_log_odds
        # More than rounding, or two settings of one height would be swapped for ever.
        if gain <= 1e-9:
            continue
        flips += 1
        for j in range(begin[c], begin[c + 1]):
            k, i = place[j], reading[j]
            factor = 1.0 - answers[k]
            if occupied[c]:
                factor = 1.0 / factor
            if zone[k] < 0:
                near[i] *= factor
            else:
                opened[i, zone[k]] *= factor
                window[i] = _window(opened[i], density[i], beyond[i])
        occupied[c] = not occupied[c]
    return flips


@njit(error_model="numpy")
def log_odds(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied,
    prior_log_odds,
    begin,
    place,
    reading,
    zone,
    answers,
    floor,
    scale,
    density,
    beyond,
    vote,
    near,
    opened,
    window,
):
    """Return the log-odds of each cell, all the others being as they are, shape (cells,)."""
    result = np.empty(occupied.size)
    for c in range(occupied.size):
        gain = _gain(
            c,
            occupied,
            begin,
            place,
            reading,
            zone,
            answers,
            floor,
            scale,
            density,
            beyond,
            vote,
            near,
            opened,
            window,
        )
        result[c] = prior_log_odds + (-gain if occupied[c] else gain)
    return result


@njit(error_model="numpy")
def propagate(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    belief, message, first, cell, zone, answers, floor, scale, density, beyond, vote, damping, added
):
    """Send one round of messages from all factors to their cells; return the largest change.

    Parameters
    ----------
    belief : ndarray, shape (cells,)
        Log-odds of each cell: the prior and all messages to it.
    message : ndarray of float32, shape (touched,)
        Log-odds that each factor told each of its cells; changed in place.
    first, cell, zone, answers, floor, scale, density, beyond, vote
        The factors.
    damping : float
        Share of the old message in the new one, in [0, 1).
    added : ndarray, shape (cells,)
        Changed in place: the sum of the new messages is added to it.
    """
    opened, coming, later = np.empty(_BINS), np.empty(_BINS), np.empty(_BINS + 1)
    before = np.empty(_BINS)
    room = 0
    for i in range(vote.size):
        room = max(room, first[i + 1] - first[i])
    blocks = np.empty(room)
    largest = 0.0
    for i in range(vote.size):
        # What each cell is likely to be without this factor, and how open it leaves the way.
        near = 1.0
        opened[:] = 1.0
        for k in range(first[i], first[i + 1]):
            cavity = belief[cell[k]] - message[k]
            through = 1.0 - answers[k] / (1.0 + math.exp(-cavity))
            blocks[k - first[i]] = through
            if zone[k] < 0:
                near *= through
            else:
                opened[zone[k]] *= through
        # The window: its value from each bin on, what nearer bins give, and what reaches each.
        later[_BINS] = beyond[i]
        for b in range(_BINS - 1, -1, -1):
            later[b] = (1.0 - opened[b]) * density[i, b] + opened[b] * later[b + 1]
        arriving, given = 1.0, 0.0
        for b in range(_BINS):
            coming[b], before[b] = arriving, given
            given += arriving * (1.0 - opened[b]) * density[i, b]
            arriving *= opened[b]
        for k in range(first[i], first[i + 1]):
            h, through = answers[k], blocks[k - first[i]]
            if zone[k] < 0:
                free = scale[i] * near / through * later[0]
                taken = free * (1.0 - h)
            else:
                b = zone[k]
                rest = opened[b] / through
                free = (1.0 - rest) * density[i, b] + rest * later[b + 1]
                rest *= 1.0 - h
                taken = (1.0 - rest) * density[i, b] + rest * later[b + 1]
                free = scale[i] * near * (before[b] + coming[b] * free)
                taken = scale[i] * near * (before[b] + coming[b] * taken)
            new = vote[i] * math.log((floor[i] + taken) / (floor[i] + free))
            new = min(max(new, -_MESSAGE_MAX), _MESSAGE_MAX)
            new = damping * message[k] + (1.0 - damping) * new
            largest = max(largest, abs(new - message[k]))
            message[k] = new
            added[cell[k]] += message[k]
    return largest
