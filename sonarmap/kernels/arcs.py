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
    xy, along, reading, i, j, cos_half, most_cosine, on_i, on_j, n
):
    """Append the bearings at which arcs i and j cross to `on_i` and `on_j`; return how many are in.

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
        qx, qy = px - dx, py - dy
        ahead_of_j = qx * along[j, 0] + qy * along[j, 1]
        if ahead_of_j < b * cos_half:
            continue
        on_i[n] = math.atan2(along[i, 0] * py - along[i, 1] * px, ahead)
        on_j[n] = math.atan2(along[j, 0] * qy - along[j, 1] * qx, ahead_of_j)
        n += 1
    return n


@njit(fastmath={"contract", "nsz"}, error_model="numpy")
def _near(x, y, reach, begin, at_x, at_y, at_reach, near):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """List the discs from `begin` on that touch the one given; return how many there are."""
    n = 0
    for j in range(begin, x.size):
        dx, dy, sum_reach = x[j] - at_x, y[j] - at_y, reach[j] + at_reach
        near[n] = j
        # No branch: most are far, but nobody can guess which.
        n += dx * dx + dy * dy <= sum_reach * sum_reach
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
    # Every point of an arc lies within this of its middle: 2 sin(half / 2), and rounding.
    reach = reading * (math.sqrt(max(2 * (1 - cos_half), 0.0)) + 1e-9) + 1e-9
    x, y = xy[:, 0] + reading * along[:, 0], xy[:, 1] + reading * along[:, 1]
    near, partner = np.empty(size + 1, np.int64), np.empty(2 * size, np.int64)
    on_i, on_j = np.empty(2 * size), np.empty(2 * size)
    arc, found, total = np.empty(4 * size, np.int64), np.empty(4 * size), 0
    for i in range(size):
        n = 0
        for k in range(_near(x, y, reach, i + 1, x[i], y[i], reach[i], near)):
            j = near[k]
            before = n
            n = _crossings(xy, along, reading, i, j, cos_half, most_cosine, on_i, on_j, n)
            partner[before:n] = j
        if total + 2 * n > arc.size:
            arc = np.concatenate((arc, np.empty(arc.size + 2 * n, np.int64)))
            found = np.concatenate((found, np.empty(arc.size - found.size)))
        for m in range(n):
            arc[total], found[total] = i, on_i[m]
            arc[total + 1], found[total + 1] = partner[m], on_j[m]
            total += 2
    return _medians(arc[:total], found[:total], size)


@njit(error_model="numpy")
def _medians(group, values, size):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the median of the values of each group, NaN of an empty one."""
    first = np.zeros(size + 1, np.int64)
    for k in range(group.size):
        first[group[k] + 1] += 1
    first = first.cumsum()
    place, grouped = first[:-1].copy(), np.empty(values.size)
    for k in range(group.size):
        grouped[place[group[k]]] = values[k]
        place[group[k]] += 1
    medians = np.full(size, np.nan)
    for i in range(size):
        n = first[i + 1] - first[i]
        if n > 0:
            ordered = np.sort(grouped[first[i] : first[i + 1]])
            medians[i] = 0.5 * (ordered[(n - 1) // 2] + ordered[n // 2])
    return medians


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
    found, on_j = np.empty(2 * size), np.empty(2 * size)
    for i in range(size):
        n = 0
        for j in range(max(i - window, 0), i):
            n = _crossings(xy, along, reading, i, j, cos_half, most_cosine, found, on_j, n)
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
