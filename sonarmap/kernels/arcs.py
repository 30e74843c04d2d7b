"""Where the arcs of readings cross one another, and what that says of the target on each.

An arc is the part of a circle around the sonar, as far away as it read, that lies in its cone.
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["clustered_crossings", "median_crossings"]


@njit(error_model="numpy")
def _crossings(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    xy, along, reading, i, j, cos_half, most_cosine, found, n
):
    """Append the bearings on arc i at which it crosses arc j to `found`; return how many there are.

    The circles cross under an angle whose cosine is at most `most_cosine`, which the law of
    cosines gives before any point is known.
    """
    dx, dy = xy[j, 0] - xy[i, 0], xy[j, 1] - xy[i, 1]
    squared = dx * dx + dy * dy
    a, b = reading[i], reading[j]
    if abs(a * a + b * b - squared) > 2 * a * b * most_cosine or squared == 0.0:
        return n
    # Foot of the common chord on the line between the sonars, and half of the chord, over d.
    foot = (a * a - b * b + squared) / (2 * squared)
    chord = math.sqrt(max(a * a / squared - foot * foot, 0.0))
    for sign in (-1.0, 1.0):
        px, py = foot * dx - sign * chord * dy, foot * dy + sign * chord * dx
        ahead = px * along[i, 0] + py * along[i, 1]
        if ahead < a * cos_half:
            continue
        if (px - dx) * along[j, 0] + (py - dy) * along[j, 1] < b * cos_half:
            continue
        found[n] = math.atan2(along[i, 0] * py - along[i, 1] * px, ahead)
        n += 1
    return n


@njit(error_model="numpy")
def median_crossings(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    xy, along, reading, cos_half, most_cosine
):
    """Return the median bearing of all crossings of each arc with others, NaN where there is none.

    Parameters
    ----------
    xy, along : ndarray, shape (n, 2)
        Places of the sonars and unit vectors of their axes.
    reading : ndarray, shape (n,)
        Ranges, metres.
    cos_half : float
        Cosine of the cones' half-angle.
    most_cosine : float
        Cosine of the least angle between arcs that cross.
    """
    size = reading.size
    bearing = np.full(size, np.nan)
    found = np.empty(2 * size)
    for i in range(size):
        n = 0
        for j in range(size):
            if j != i:
                n = _crossings(xy, along, reading, i, j, cos_half, most_cosine, found, n)
        if n > 0:
            ordered = np.sort(found[:n])
            bearing[i] = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    return bearing


@njit(error_model="numpy")
def clustered_crossings(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    xy, along, reading, cos_half, most_cosine, window, tolerance, least
):
    """Return the mean bearing of the largest cluster of each arc's crossings with earlier arcs.

    Only the `window` arcs before it count; a cluster lies within `tolerance` metres along the arc.
    NaN where no cluster has `least` crossings. Of equal clusters that nearer to the axis counts.
    """
    size = reading.size
    bearing = np.full(size, np.nan)
    found = np.empty(2 * size)
    for i in range(size):
        n = 0
        for j in range(max(i - window, 0), i):
            n = _crossings(xy, along, reading, i, j, cos_half, most_cosine, found, n)
        if n < least:
            continue
        ordered = np.sort(found[:n])
        width, best, end = tolerance / max(reading[i], 1e-9), 0, 0
        for begin in range(n):
            while end < n and ordered[end] - ordered[begin] <= width:
                end += 1
            count = end - begin
            if count < max(best, least):
                continue
            mean = ordered[begin:end].mean()
            if count > best or abs(mean) < abs(bearing[i]):
                best, bearing[i] = count, mean
    return bearing
