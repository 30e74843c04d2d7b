"""Faces near a sonar, gathered from the grid of a `worlds.facetable.FaceTable`."""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.jit import njit

__all__ = ["first_reach", "gather"]

# A room with no more faces is taken as a whole: to look for the near ones would cost more.
_ALL_FACES = 96
# In other rooms the first look takes in about so many faces.
_FIRST_FACES = 48


@njit(error_model="numpy", makes_arrays=False)
def first_reach(table, room, far_m):
    """Return how far to look first, metres: what is found there need not be looked for farther."""
    _, _, _, _, span, grid, shape, _, _ = table
    faces = span[room, 1] - span[room, 0] + span[room, 3] - span[room, 2]
    if faces <= _ALL_FACES:
        return far_m
    area_m2 = shape[room, 0] * shape[room, 1] * grid[room, 2] * grid[room, 2]
    return min(far_m, math.sqrt(_FIRST_FACES * area_m2 / (math.pi * faces)))


@njit(error_model="numpy")
def gather(table, room, x, y, reach_m):
    """Return the faces of a room in the cells within reach of a place.

    Returns
    -------
    segments : ndarray, shape (5, n)
        Begin (x, y), end (x, y) and number of each segment: a row each, for straight loops.
    circles : ndarray, shape (4, m)
        Centre (x, y), radius and number of each circle.
    """
    all_segments, _, all_circles, _, span, grid, shape, cell_start, cell_face = table
    first_segment, after_segments = span[room, 0], span[room, 1]
    first_circle, after_circles = span[room, 2], span[room, 3]
    flat = all_segments.shape[0]
    near = np.empty(after_segments - first_segment + after_circles - first_circle, np.int64)
    count, lines = 0, 0
    if near.size <= _ALL_FACES:
        for i in range(first_segment, after_segments):
            near[count] = i
            count += 1
        lines = count
        for i in range(first_circle, after_circles):
            near[count] = i
            count += 1
    else:
        left, bottom, cell = grid[room, 0], grid[room, 1], grid[room, 2]
        rows, cols, first_cell = shape[room, 0], shape[room, 1], shape[room, 2]
        is_listed = np.zeros(near.size, np.bool_)
        segments = after_segments - first_segment
        first_col = max(cell_index(x - reach_m, left, cell), 0)
        last_col = min(cell_index(x + reach_m, left, cell), cols - 1)
        for row in range(
            max(cell_index(y - reach_m, bottom, cell), 0),
            min(cell_index(y + reach_m, bottom, cell), rows - 1) + 1,
        ):
            if first_col > last_col:
                break
            # The lists of the cells of a row lie one behind the other.
            at = first_cell + row * cols
            for k in range(cell_start[at + first_col], cell_start[at + last_col + 1]):
                face = cell_face[k]
                place = face - first_segment
                if face >= after_segments:
                    place = segments + face - first_circle
                if not is_listed[place]:
                    is_listed[place] = True
                    near[count] = face
                    count += 1
                    lines += 1 if face < flat else 0

    near_segments, near_circles = np.empty((5, lines)), np.empty((4, count - lines))
    i, j = 0, 0
    for k in range(count):
        face = near[k]
        if face < flat:
            for column in range(4):
                near_segments[column, i] = all_segments[face, column]
            near_segments[4, i] = face
            i += 1
        else:
            for column in range(3):
                near_circles[column, j] = all_circles[face - flat, column]
            near_circles[3, j] = face
            j += 1
    return near_segments, near_circles
