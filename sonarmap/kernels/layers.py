"""Compiled loops of the one-pass methods: what beams say of listed cells, into flat layers.

All take `first`, `cell`, `ranges` and `shares` of `sonarmap.methods.cones.Cells`. Each has its
plain twin in the tests of its method.
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = [
    "add_empty",
    "add_gaussian",
    "add_himm",
    "add_masses",
    "add_occupied",
    "add_thrun",
    "expand_runs",
]

_P_MIN = 1e-6
_MOST_LOG_ODDS = math.log((1 - _P_MIN) / _P_MIN)
# Standard deviations from the reading beyond which nothing of the Gaussian is left.
_TAIL = 8.0


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


@njit(error_model="numpy")
def add_gaussian(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds,
    seen,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    sigma,
    sigma_share,
    detection,
    density,
):
    """Add the Gaussian model's log-odds; `sigma_share` is the angle's sigma over the half-angle."""
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            t = shares[k] / sigma_share
            w = detection * math.exp(-0.5 * t * t)
            v = (ranges[k] - z) / sigma + density * sigma if echo[i] else -2 * _TAIL
            ratio = 1 - w
            if v > -_TAIL:
                peak = math.exp(-0.5 * v * v) / math.sqrt(2 * math.pi)
                ratio += w * (0.5 * math.erfc(-v / math.sqrt(2.0)) + peak / (density * sigma))
            c = cell[k]
            log_odds[c] += min(max(math.log(ratio), -_MOST_LOG_ODDS), _MOST_LOG_ODDS)
            seen[c] = True


@njit(error_model="numpy")
def add_masses(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied,
    free,
    unknown,
    first,
    cell,
    ranges,
    shares,
    reading,
    echo,
    longest,
    tolerance,
    max_occupied,
    matching,
):
    """Combine the masses of beams with those of the cells by Dempster's rule.

    `matching` is 0 for the textbook's masses, 1 for pignistic and 2 for plausibility matching.
    """
    for i in range(reading.size):
        z = reading[i]
        for k in range(first[i], first[i + 1]):
            r = ranges[k]
            belief = ((longest - r) / longest + (1.0 - shares[k])) / 2.0
            if r < z - tolerance:
                p = 1.0 - belief
                on_arc = False
            elif echo[i] and r <= z + tolerance:
                p = belief * max_occupied
                on_arc = True
            else:
                continue
            p = min(max(p, _P_MIN), 1.0 - _P_MIN)
            m_occ, m_free = 0.0, 0.0
            if matching == 0:
                if on_arc:
                    m_occ = p
                else:
                    m_free = 1.0 - p
            elif matching == 1:
                m_occ, m_free = max(0.0, 2 * p - 1), max(0.0, 1 - 2 * p)
            elif p >= 0.5:
                m_occ = (2 * p - 1) / p
            else:
                m_free = (1 - 2 * p) / (1 - p)
            m_unknown = 1.0 - m_occ - m_free
            c = cell[k]
            o, f, u = occupied[c], free[c], unknown[c]
            agreed = 1.0 - (o * m_free + f * m_occ)
            occupied[c] = (o * m_occ + o * m_unknown + u * m_occ) / agreed
            free[c] = (f * m_free + f * m_unknown + u * m_free) / agreed
            unknown[c] = u * m_unknown / agreed


@njit(error_model="numpy")
def add_himm(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    count, seen, first, cell, target, up, down, top, growth
):
    """Count down the cells of axes (n) and up their `target`, -1 for none; count is (rows, cols).

    With `growth` a hit also adds that much of each of the eight neighbours' counts.
    """
    rows, cols = count.shape
    for i in range(target.size):
        hit = False
        for k in range(first[i], first[i + 1]):
            row, col = cell[k] // cols, cell[k] % cols
            seen[cell[k]] = True
            if cell[k] == target[i]:
                hit = True
            else:
                count[row, col] = max(count[row, col] - down, 0.0)
        if not hit:
            continue
        row, col = target[i] // cols, target[i] % cols
        total = count[row, col] + up
        if growth > 0.0:
            around = 0.0
            for r in range(max(row - 1, 0), min(row + 2, rows)):
                for c in range(max(col - 1, 0), min(col + 2, cols)):
                    if r != row or c != col:
                        around += count[r, c]
            total += growth * around
        count[row, col] = min(total, top)


@njit(error_model="numpy")
def add_empty(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    empty, first, cell, ranges, shares, reading, nearest, error
):
    """Superpose the empty areas of Moravec and Elfes; return which cells lie on an arc."""
    on_arc = np.zeros(cell.size, np.bool_)
    for i in range(reading.size):
        z = reading[i]
        border = z - error
        for k in range(first[i], first[i + 1]):
            r = ranges[k]
            if r > border:
                on_arc[k] = True
            elif r >= nearest and border > nearest:
                depth = (r - nearest) / (border - nearest)
                p = (1.0 - depth * depth) * (1.0 - shares[k] * shares[k])
                c = cell[k]
                empty[c] += p - empty[c] * p
    return on_arc


@njit(error_model="numpy")
def add_occupied(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    occupied, empty, first, cell, ranges, shares, reading, error, least
):
    """Cancel, normalise and enhance the occupied areas of Moravec and Elfes."""
    for i in range(reading.size):
        begin, end = first[i], first[i + 1]
        total = 0.0
        for step in range(2):
            # A sum of next to nothing says that all of the arc is empty: it is not blown up.
            norm = total if total > least else 1.0
            for k in range(begin, end):
                depth = (ranges[k] - reading[i]) / error
                if abs(depth) > 1.0:
                    continue
                c = cell[k]
                p = (1.0 - depth * depth) * (1.0 - shares[k] * shares[k]) * (1.0 - empty[c])
                if step == 0:
                    total += p
                else:
                    p /= norm
                    occupied[c] += p - occupied[c] * p
