"""`FaceTable`: the faces of rooms for compiled code, with a grid that says which face lies where.

A ray looks only at the faces in the cells that it passes, so that a room with a thousand walls
costs little more than one with forty. Cells are squares; each lists every face that touches it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.jit import njit

__all__ = ["FaceTable", "face_table"]

_Floats = NDArray[np.float64]
_Ints = NDArray[np.int64]

# Cells for each face: more cells cost more steps of a ray, fewer cells more faces a step.
# Measured in the shipped rooms.
_CELLS_A_FACE = 2.0
# A grid has no more cells than this on a side: a long, thin room need not cost much memory.
_MOST_CELLS = 512
# Faces are listed in cells that they only just do not touch, this share of a cell: rounding must
# not hide a face from a ray.
_MARGIN = 1e-6


class FaceTable(NamedTuple):
    """Segments and circles of one or more rooms, for compiled code.

    Faces are numbered segments first, then circles, through all rooms.

    Parameters
    ----------
    segments : ndarray, shape (s, 4)
        (x0, y0, x1, y1) of each segment.
    normals : ndarray, shape (s, 2)
        Unit normal of each segment, on the right of the way from its begin to its end.
    circles : ndarray, shape (c, 3)
        (x, y, radius) of each circle.
    surface : ndarray of int32, shape (s + c,)
        Index of each face's surface within its room.
    span : ndarray of int64, shape (rooms, 4)
        Numbers of each room's first segment and the one after its last, and likewise of its
        circles.
    grid : ndarray, shape (rooms, 3)
        Lower-left corner and cell size of each room's grid.
    shape : ndarray of int64, shape (rooms, 3)
        Rows and columns of the grid, and where its cells begin in `cell_start`.
    cell_start : ndarray of int64
        Where the list of each cell begins in `cell_face`; rows * cols + 1 numbers a room.
    cell_face : ndarray of int64
        Numbers of the faces, cell by cell.
    """

    segments: _Floats
    normals: _Floats
    circles: _Floats
    surface: NDArray[np.int32]
    span: _Ints
    grid: _Floats
    shape: _Ints
    cell_start: _Ints
    cell_face: _Ints


def face_table(rooms: Sequence[tuple[_Floats, _Floats, NDArray[np.int32]]]) -> FaceTable:
    """Return the table of rooms given as (segments, circles, surface of each face).

    Parameters
    ----------
    rooms : sequence
        Of each room its segments (n, 4), circles (m, 3) and surfaces (n + m,), segments first.
    """
    flat = sum(len(segments) for segments, _, _ in rooms)
    spans, grids, shapes, starts, listed = [], [], [], [], []
    first_segment, first_circle, first_cell, first_listed = 0, flat, 0, 0
    for segments, circles, _ in rooms:
        grid, rows, cols = _grid_over(segments, circles)
        start, faces = _list_faces(*grid, rows, cols, np.array(segments), np.array(circles))
        is_segment = faces < len(segments)
        faces += np.where(is_segment, first_segment, first_circle - len(segments))
        grids.append(grid)
        shapes.append((rows, cols, first_cell))
        starts.append(start + first_listed)
        listed.append(faces)
        after_segments, after_circles = first_segment + len(segments), first_circle + len(circles)
        spans.append((first_segment, after_segments, first_circle, after_circles))
        first_segment, first_circle = after_segments, after_circles
        first_cell += start.size
        first_listed += faces.size
    surfaces = [surface[: len(segments)] for segments, _, surface in rooms]
    surfaces += [surface[len(segments) :] for segments, _, surface in rooms]
    every_segment = np.concatenate([np.empty((0, 4)), *(segments for segments, _, _ in rooms)])
    along = every_segment[:, 2:] - every_segment[:, :2]
    length = np.sqrt(along[:, 0] * along[:, 0] + along[:, 1] * along[:, 1])
    return FaceTable(
        every_segment,
        np.column_stack([along[:, 1], -along[:, 0]]) / length[:, None],
        np.concatenate([np.empty((0, 3)), *(circles for _, circles, _ in rooms)]),
        np.concatenate(surfaces).astype(np.int32),
        np.array(spans, np.int64),
        np.array(grids),
        np.array(shapes, np.int64),
        np.concatenate(starts),
        np.concatenate(listed),
    )


def _grid_over(segments: _Floats, circles: _Floats) -> tuple[tuple[float, float, float], int, int]:
    """Return (left, bottom, cell) of the grid over a room's faces, and its rows and columns."""
    centre, radius = circles[:, :2], circles[:, 2:]
    corners = np.concatenate(
        [segments[:, :2], segments[:, 2:], centre - radius, centre + radius, np.empty((0, 2))]
    )
    if not len(corners):
        return (0.0, 0.0, 1.0), 1, 1
    low, size = corners.min(axis=0), np.ptp(corners, axis=0)
    faces = len(segments) + len(circles)
    cell = math.sqrt(max(size[0], 1e-3) * max(size[1], 1e-3) / (_CELLS_A_FACE * faces))
    cell = max(cell, float(size.max()) / _MOST_CELLS)
    low = low - 0.5 * cell
    cols, rows = (int(n) for n in np.ceil(size / cell + 1.0))
    return (float(low[0]), float(low[1]), cell), rows, cols


@njit()
def _list_faces(
    left: float,
    bottom: float,
    cell: float,
    rows: int,
    cols: int,
    segments: _Floats,
    circles: _Floats,
) -> tuple[_Ints, _Ints]:
    """Return where the list of each cell begins, and the lists of faces, one after the other."""
    start = np.zeros(rows * cols + 1, np.int64)
    faces = np.empty(0, np.int64)
    # Once to count, once to write.
    for writes in (False, True):
        free = start[:-1].copy()
        for face in range(segments.shape[0] + circles.shape[0]):
            for row in range(rows):
                low, high = bottom + (row - _MARGIN) * cell, bottom + (row + 1 + _MARGIN) * cell
                if face < segments.shape[0]:
                    from_x, to_x = _segment_between(segments[face], low, high)
                else:
                    from_x, to_x = _circle_between(circles[face - segments.shape[0]], low, high)
                if from_x > to_x:
                    continue
                first = max(math.floor((from_x - left) / cell - _MARGIN), 0)
                last = min(math.floor((to_x - left) / cell + _MARGIN), cols - 1)
                for col in range(first, last + 1):
                    if writes:
                        faces[free[row * cols + col]] = face
                        free[row * cols + col] += 1
                    else:
                        start[row * cols + col + 1] += 1
        if not writes:
            start = np.cumsum(start)
            faces = np.empty(start[-1], np.int64)
    return start, faces


@njit()
def _segment_between(segment: _Floats, low: float, high: float) -> tuple[float, float]:
    """Return the span in x of the part of a segment with low <= y <= high; (1, 0) if none."""
    x0, y0, x1, y1 = segment[0], segment[1], segment[2], segment[3]
    if max(y0, y1) < low or min(y0, y1) > high:
        return 1.0, 0.0
    if y0 == y1:
        return min(x0, x1), max(x0, x1)
    slope = (x1 - x0) / (y1 - y0)
    at_low = x0 + slope * (min(max(low, min(y0, y1)), max(y0, y1)) - y0)
    at_high = x0 + slope * (max(min(high, max(y0, y1)), min(y0, y1)) - y0)
    return min(at_low, at_high), max(at_low, at_high)


@njit()
def _circle_between(circle: _Floats, low: float, high: float) -> tuple[float, float]:
    """Return a span in x that holds the part of a circle with low <= y <= high; (1, 0) if none."""
    x, y, radius = circle[0], circle[1], circle[2]
    if y + radius < low or y - radius > high:
        return 1.0, 0.0
    nearest = max(low - y, y - high, 0.0)
    half = math.sqrt(max(radius * radius - nearest * nearest, 0.0))
    return x - half, x + half
