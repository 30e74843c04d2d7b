"""What of the faces in a beam can be seen: intervals of slope, each with the face nearest there."""

from __future__ import annotations

import math

import numpy as np

from sim.sonar.cone.exact.beam import NARROWEST, PILLARS
from sim.sonar.cone.exact.meeting import (
    FROM,
    KIND,
    NEAR_0,
    NEAR_1,
    NEAREST_M,
    NUMBER,
    SEGMENT,
    TO,
    crossings,
    nearness,
)
from sonarmap.kernels.jit import njit

__all__ = ["BEGIN", "COLUMNS", "END", "OF_FACE", "look"]

# Columns of a visible piece: its slopes, and the row of its face.
BEGIN, END, OF_FACE = range(3)
# For the use of `sim.sonar.cone.exact.echo`: the part of the piece that returns sound.
COLUMNS = 5

# Faces whose ranges differ by less than this share of them coincide; the lower number is seen.
_SAME = 1e-12


@njit(error_model="numpy")
def look(beam, faces, count, pieces, order):
    """Find what is visible of some faces in a beam.

    Parameters
    ----------
    beam, faces : ndarray
        The beam, and the faces in it.
    count : int
        How many faces there are.
    pieces : ndarray, shape (2, n, COLUMNS)
        Room for the visible pieces.
    order : ndarray of int, shape (n,)
        Room for as many numbers as there are faces.

    Returns
    -------
    pieces, now, shown
        The same room or a larger one, in which half of it the pieces are, from right to left, and
        how many.
    """
    for k in range(count):
        # The nearest first: of the others little is seen then.
        place = k
        while place > 0 and faces[order[place - 1], NEAREST_M] > faces[k, NEAREST_M]:
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    is_straight = beam[PILLARS] == 0.0
    now, shown = 0, 0
    for i in range(count):
        k = order[i]
        if is_straight and faces[k, KIND] == SEGMENT and _is_hidden(faces, k, pieces, now, shown):
            continue
        if 3 * shown + 4 > pieces.shape[1]:
            larger = np.empty((2, 6 * shown + 8, COLUMNS))
            larger[:, : pieces.shape[1]] = pieces
            pieces = larger
        now, shown = _put(beam, faces, k, pieces, now, shown)
    return pieces, now, shown


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def _is_hidden(faces, k, pieces, now, shown):
    """Return whether a segment is behind nearer segments all along; quick, may miss it."""
    at, high = faces[k, FROM], faces[k, TO]
    near_0, near_1 = faces[k, NEAR_0], faces[k, NEAR_1]
    for p in range(shown):
        end = pieces[now, p, END]
        if end <= at:
            continue
        if pieces[now, p, BEGIN] > at:
            return False
        j = int(pieces[now, p, OF_FACE])
        if faces[j, KIND] != SEGMENT:
            return False
        last = min(end, high)
        apart_0, apart_1 = faces[j, NEAR_0] - near_0, faces[j, NEAR_1] - near_1
        same = _SAME * (abs(near_0) + abs(near_1))
        if not (apart_0 + at * apart_1 > same and apart_0 + last * apart_1 > same):
            return False
        if last == high:
            return True
        at = last
    return False


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def _put(beam, faces, k, pieces, now, count):
    """Put a face where it is nearer than the pieces so far; return where they are and how many."""
    low, high = faces[k, FROM], faces[k, TO]
    is_straight = beam[PILLARS] == 0.0 and faces[k, KIND] == SEGMENT
    new, out, at = 1 - now, 0, low
    for p in range(count):
        begin, end = pieces[now, p, BEGIN], pieces[now, p, END]
        j = int(pieces[now, p, OF_FACE])
        if end <= low or begin >= high:
            if begin >= high and at < high:
                out = _add(pieces, new, out, at, high, k)
                at = high
            out = _add(pieces, new, out, begin, end, j)
            continue
        if at < begin:
            out = _add(pieces, new, out, at, begin, k)
        first, last = max(begin, low), min(end, high)
        if begin < first:
            out = _add(pieces, new, out, begin, first, j)
        if is_straight and faces[j, KIND] == SEGMENT:
            same = _SAME * (abs(faces[k, NEAR_0]) + abs(faces[k, NEAR_1]))
            apart_0 = faces[k, NEAR_0] - faces[j, NEAR_0]
            apart_1 = faces[k, NEAR_1] - faces[j, NEAR_1]
            gap_first, gap_last = apart_0 + first * apart_1, apart_0 + last * apart_1
            at_first = int(gap_first > same) - int(gap_first < -same)
            at_last = int(gap_last > same) - int(gap_last < -same)
            if at_first * at_last < 0:
                middle = first + (last - first) * (gap_first / (gap_first - gap_last))
                out = _add(pieces, new, out, first, middle, k if at_first > 0 else j)
                out = _add(pieces, new, out, middle, last, k if at_last > 0 else j)
            else:
                is_nearer = at_first + at_last > 0
                if at_first == 0 and at_last == 0:
                    is_nearer = faces[k, NUMBER] < faces[j, NUMBER]
                out = _add(pieces, new, out, first, last, k if is_nearer else j)
        else:
            one, two = crossings(beam, faces, k, j, first, last)
            while first < last:
                # Up to the next crossing, NaN for none.
                until = last
                if first < one < last:
                    until = one
                elif first < two < last:
                    until = two
                here = _compare(beam, faces, k, j, 0.5 * (first + until))
                if here == 0:
                    here = 1 if faces[k, NUMBER] < faces[j, NUMBER] else -1
                out = _add(pieces, new, out, first, until, k if here > 0 else j)
                first = until
        if last < end:
            out = _add(pieces, new, out, last, end, j)
        at = last
    if at < high:
        out = _add(pieces, new, out, at, high, k)
    return new, out


@njit(error_model="numpy", makes_arrays=False)
def _compare(beam, faces, i, j, slope):
    """Return 1 where face i is nearer than face j, -1 where it is farther, 0 for the same."""
    one, other = nearness(beam, faces, i, slope), nearness(beam, faces, j, slope)
    apart = one - other
    if math.isnan(apart) or abs(apart) <= _SAME * (abs(one) + abs(other)):
        return 0
    return 1 if apart > 0.0 else -1


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def _add(pieces, new, out, begin, end, k):
    """Add a piece, joined to the last one if it is of the same face; return how many there are."""
    if out > 0 and pieces[new, out - 1, OF_FACE] == k and pieces[new, out - 1, END] == begin:
        pieces[new, out - 1, END] = end
        return out
    if end - begin <= NARROWEST:
        return out
    pieces[new, out, BEGIN], pieces[new, out, END], pieces[new, out, OF_FACE] = begin, end, k
    return out + 1
