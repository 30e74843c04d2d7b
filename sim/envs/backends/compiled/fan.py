"""Fans of rays that begin in one place: every ray against every face that the fan may meet.

Rays of a fan see much the same faces. To sort out the few faces in the fan's sector first, and to
try each with all rays in one straight loop, which the compiler turns into vector instructions,
takes a fraction of the time of walking ray by ray. What is found is what `worlds.raycast` finds,
to the last bit: the arithmetic is the same.
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.jit import njit
from worlds.raycast import NEAREST, OVERHANG

__all__ = ["faces_near", "meet_fan"]

# A face is kept unless it is outside of the sector by more than this; metres.
_SLACK_M = 1e-6


@njit()
def faces_near(table, room, x, y, reach_m):
    """Return the numbers, rising, of a room's faces in the cells within reach of a place."""
    _, _, _, _, span, grid, shape, cell_start, cell_face = table
    left, bottom, cell = grid[room, 0], grid[room, 1], grid[room, 2]
    rows, cols, first_cell = shape[room, 0], shape[room, 1], shape[room, 2]
    first_segment, after_segments = span[room, 0], span[room, 1]
    first_circle, after_circles = span[room, 2], span[room, 3]
    segments, circles = after_segments - first_segment, after_circles - first_circle
    is_near = np.zeros(segments + circles, np.bool_)
    first_col = max(cell_index(x - reach_m, left, cell), 0)
    last_col = min(cell_index(x + reach_m, left, cell), cols - 1)
    for row in range(
        max(cell_index(y - reach_m, bottom, cell), 0),
        min(cell_index(y + reach_m, bottom, cell), rows - 1) + 1,
    ):
        # The lists of the cells of a row lie one behind the other.
        at = first_cell + row * cols
        for k in range(cell_start[at + first_col], cell_start[at + last_col + 1]):
            face = cell_face[k]
            if face < after_segments:
                is_near[face - first_segment] = True
            else:
                is_near[segments + face - first_circle] = True
    near = np.empty(segments + circles, np.int64)
    count = 0
    for i in range(segments + circles):
        if is_near[i]:
            near[count] = first_segment + i if i < segments else first_circle + i - segments
            count += 1
    return near[:count]


@njit(error_model="numpy")
def meet_fan(table, near, x, y, dx, dy, rays, reach_m, leg_m, face):
    """Write the first face that each ray of a fan meets and how far it is; -1 and inf for none.

    Parameters
    ----------
    table : FaceTable
        The faces.
    near : ndarray of int
        Numbers of the faces to try, rising.
    x, y : float
        Where all rays begin.
    dx, dy : ndarray, shape (whole,)
        Directions, the fan's right edge first; less than half a turn in all.
    rays : int
        How many rays there are; those behind them in the arrays, directions 0, meet nothing that
        matters. Loops over whole vectors of numbers are faster than over what is left of one.
    reach_m : float
        How far the rays go.
    leg_m, face : ndarray, shape (whole,)
        Written.
    """
    segments, _, circles, _, _, _, _, _, _ = table
    flat = segments.shape[0]
    right_dx, right_dy, left_dx, left_dy = dx[0], dy[0], dx[rays - 1], dy[rays - 1]
    for j in range(dx.size):
        leg_m[j], face[j] = math.inf, -1
    for i in near:
        if i >= flat:
            cx, cy = circles[i - flat, 0] - x, circles[i - flat, 1] - y
            aside = circles[i - flat, 2] + _SLACK_M
            if right_dx * cy - right_dy * cx > -aside and left_dx * cy - left_dy * cx < aside:
                _meet_circle(circles[i - flat, 2], i, cx, cy, dx, dy, reach_m, leg_m, face)
            continue
        ax, ay = segments[i, 0] - x, segments[i, 1] - y
        bx, by = segments[i, 2] - x, segments[i, 3] - y
        right = max(right_dx * ay - right_dy * ax, right_dx * by - right_dy * bx)
        left = min(left_dx * ay - left_dy * ax, left_dx * by - left_dy * bx)
        if right > -_SLACK_M and left < _SLACK_M:
            ex, ey = segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
            _meet_segment(i, ax, ay, ex, ey, dx, dy, reach_m, leg_m, face)


@njit(error_model="numpy")
def _meet_segment(number, ax, ay, ex, ey, dx, dy, reach_m, leg_m, face):
    """Let all rays meet a segment, given as its begin as seen from theirs and its extent."""
    height = ax * ey - ay * ex
    for j in range(dx.size):
        across = dx[j] * ey - dy[j] * ex
        share = ax * dy[j] - ay * dx[j]
        share = -share if across < 0.0 else share
        length = abs(across)
        distance = height / across
        meets = (
            (share >= -OVERHANG * length)
            & (share <= (1.0 + OVERHANG) * length)
            & (across != 0.0)
            & (distance > NEAREST)
            & (distance <= reach_m)
            & (distance < leg_m[j])
        )
        leg_m[j] = distance if meets else leg_m[j]
        face[j] = number if meets else face[j]


@njit(error_model="numpy")
def _meet_circle(radius, number, ax, ay, dx, dy, reach_m, leg_m, face):
    """Let all rays meet a circle, given by its centre as seen from theirs."""
    for j in range(dx.size):
        along = ax * dx[j] + ay * dy[j]
        aside = ax * dy[j] - ay * dx[j]
        half_chord_2 = radius * radius - aside * aside
        half_chord = math.sqrt(max(half_chord_2, 0.0))
        distance = along - half_chord
        # From inside, the far side is met.
        distance = along + half_chord if distance <= NEAREST else distance
        meets = (
            (half_chord_2 >= 0.0)
            & (distance > NEAREST)
            & (distance <= reach_m)
            & (distance < leg_m[j])
        )
        leg_m[j] = distance if meets else leg_m[j]
        face[j] = number if meets else face[j]
