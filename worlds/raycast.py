"""Kernels that find where a ray meets segments and circles first, and how near they are.

A ray is an origin and a unit vector; lengths are in whatever unit the faces are in. Distances
come from sums and products only, in a fixed order: a mirrored or quarter-turned room gives the
same ones to the last bit.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.jit import njit
from worlds.facetable import FaceTable

__all__ = ["NEAREST", "OVERHANG", "cast_rays", "clearance", "face_normal", "first_hit"]

_Floats = NDArray[np.float64]
_Ints = NDArray[np.int64]

NEAREST = 1e-9
"""A ray that begins on the surface that mirrored it must not meet that surface again."""
OVERHANG = 1e-9
"""Segments reach this share of their length beyond their ends, so that no ray slips through the
corner of two walls by a rounding error."""


# The kernels below index their tables by number: a slice of an array would cost more than the
# arithmetic.


@njit(error_model="numpy", inline="always")
def _meet_segment(segments: _Floats, i: int, x: float, y: float, dx: float, dy: float) -> float:
    """Return the distance at which a ray meets a segment, inf if it does not."""
    ex, ey = segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
    across = dx * ey - dy * ex
    if across == 0.0:
        return math.inf  # a ray along a wall meets the wall's end, which is another segment
    ax, ay = segments[i, 0] - x, segments[i, 1] - y
    # Where on the segment, as a share of its length times `across`; a division can wait.
    share = ax * dy - ay * dx
    if across < 0.0:
        share = -share
    length = abs(across)
    if not -OVERHANG * length <= share <= (1.0 + OVERHANG) * length:
        return math.inf
    distance = (ax * ey - ay * ex) / across
    return distance if distance > NEAREST else math.inf


@njit(error_model="numpy", inline="always")
def _meet_circle(circles: _Floats, i: int, x: float, y: float, dx: float, dy: float) -> float:
    """Return the distance at which a ray meets a circle, from outside or inside, or inf."""
    ax, ay = circles[i, 0] - x, circles[i, 1] - y
    along = ax * dx + ay * dy
    aside = ax * dy - ay * dx
    half_chord_2 = circles[i, 2] * circles[i, 2] - aside * aside
    if half_chord_2 < 0.0:
        return math.inf
    half_chord = math.sqrt(half_chord_2)
    distance = along - half_chord
    if distance <= NEAREST:
        distance = along + half_chord  # from inside, the far side is met
    return distance if distance > NEAREST else math.inf


@njit(error_model="numpy", inline="always")
def first_hit(
    segments: _Floats,
    circles: _Floats,
    grid: _Floats,
    shape: _Ints,
    cell_start: _Ints,
    cell_face: _Ints,
    room: int,
    x: float,
    y: float,
    dx: float,
    dy: float,
    reach: float,
) -> tuple[float, int]:
    """Return (distance, face) of the first face of a room within `reach`; (inf, -1) for none.

    The first six parameters are fields of a `FaceTable`, one by one: handing on the table itself
    would cost as much as the walk. Of faces at the same distance it is the one with the lowest
    number. The ray walks from cell to cell of the table's grid (Amanatides and Woo, "A Fast Voxel
    Traversal Algorithm for Ray Tracing", Eurographics 1987).
    """
    best, face = math.inf, -1
    left, bottom, cell = grid[room, 0], grid[room, 1], grid[room, 2]
    rows, cols, first_cell = shape[room, 0], shape[room, 1], shape[room, 2]
    per_x = 1.0 / dx if dx != 0.0 else math.inf
    per_y = 1.0 / dy if dy != 0.0 else math.inf

    # The part of the ray that is within the grid.
    begin, end = 0.0, reach
    if dx != 0.0:
        to_left, to_right = (left - x) * per_x, (left + cols * cell - x) * per_x
        begin, end = max(begin, min(to_left, to_right)), min(end, max(to_left, to_right))
    elif not left <= x <= left + cols * cell:
        return best, face
    if dy != 0.0:
        to_low, to_high = (bottom - y) * per_y, (bottom + rows * cell - y) * per_y
        begin, end = max(begin, min(to_low, to_high)), min(end, max(to_low, to_high))
    elif not bottom <= y <= bottom + rows * cell:
        return best, face
    if begin > end:
        return best, face

    col = min(max(int((x + begin * dx - left) / cell), 0), cols - 1)
    row = min(max(int((y + begin * dy - bottom) / cell), 0), rows - 1)
    step_col, step_row = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    # Where the ray leaves the cell through its right or left, upper or lower side.
    leave_x, leave_y = math.inf, math.inf
    if dx != 0.0:
        leave_x = (left + (col + (dx > 0.0)) * cell - x) * per_x
    if dy != 0.0:
        leave_y = (bottom + (row + (dy > 0.0)) * cell - y) * per_y
    step_x, step_y = cell * abs(per_x), cell * abs(per_y)
    flat = segments.shape[0]
    while True:
        at = first_cell + row * cols + col
        for k in range(cell_start[at], cell_start[at + 1]):
            i = cell_face[k]
            if i < flat:
                distance = _meet_segment(segments, i, x, y, dx, dy)
            else:
                distance = _meet_circle(circles, i - flat, x, y, dx, dy)
            if distance <= reach and (distance < best or (distance == best and i < face)):
                best, face = distance, i
        leave = min(leave_x, leave_y)
        if best < leave or leave > end:
            return best, face
        if leave_x < leave_y:
            col += step_col
            leave_x += step_x
            if not 0 <= col < cols:
                return best, face
        else:
            row += step_row
            leave_y += step_y
            if not 0 <= row < rows:
                return best, face


@njit(error_model="numpy", makes_arrays=False)
def face_normal(
    normals: _Floats,
    circles: _Floats,
    face: int,
    hit_x: float,
    hit_y: float,
    dx: float,
    dy: float,
) -> tuple[float, float]:
    """Return the unit normal of a face at a point, turned against the ray (dx, dy)."""
    flat = normals.shape[0]
    if face < flat:
        nx, ny = normals[face, 0], normals[face, 1]
    else:
        nx, ny = hit_x - circles[face - flat, 0], hit_y - circles[face - flat, 1]
        length = math.sqrt(nx * nx + ny * ny)
        nx, ny = nx / length, ny / length
    if nx * dx + ny * dy > 0.0:
        nx, ny = -nx, -ny
    return nx, ny


@njit(error_model="numpy")
def cast_rays(
    table: FaceTable, room: int, origins: _Floats, directions: _Floats, reach: _Floats
) -> tuple[_Floats, _Floats, NDArray[np.int32]]:
    """Return (distance, normal, surface) of n rays in a room, see `worlds.RayHits`."""
    n = origins.shape[0]
    segments, normals, circles, surface, _, grid, shape, cell_start, cell_face = table
    distances = np.full(n, np.inf)
    against = np.zeros((n, 2))
    surfaces = np.full(n, -1, dtype=np.int32)
    for i in range(n):
        x, y = origins[i, 0], origins[i, 1]
        dx, dy = directions[i, 0], directions[i, 1]
        distance, face = first_hit(
            segments, circles, grid, shape, cell_start, cell_face, room, x, y, dx, dy, reach[i]
        )
        if face < 0:
            continue
        distances[i] = distance
        surfaces[i] = surface[face]
        against[i, 0], against[i, 1] = face_normal(
            normals, circles, face, x + distance * dx, y + distance * dy, dx, dy
        )
    return distances, against, surfaces


@njit(error_model="numpy", makes_arrays=False)
def clearance(
    table: FaceTable, room: int, x: float, y: float, reach: float
) -> tuple[float, float, float]:
    """Return how near a room's nearest face is to a point, and the unit vector away from it.

    Only faces nearer than `reach` are looked for; (inf, 0, 0) if there is none.
    """
    segments, _, circles, _, _, grid, shape, cell_start, cell_face = table
    left, bottom, cell = grid[room, 0], grid[room, 1], grid[room, 2]
    rows, cols, first_cell = shape[room, 0], shape[room, 1], shape[room, 2]
    flat = segments.shape[0]
    best, away_x, away_y = math.inf, 0.0, 0.0
    first_col = max(math.floor((x - reach - left) / cell), 0)
    last_col = min(math.floor((x + reach - left) / cell), cols - 1)
    first_row = max(math.floor((y - reach - bottom) / cell), 0)
    last_row = min(math.floor((y + reach - bottom) / cell), rows - 1)
    for row in range(first_row, last_row + 1):
        for col in range(first_col, last_col + 1):
            at = first_cell + row * cols + col
            for k in range(cell_start[at], cell_start[at + 1]):
                i = cell_face[k]
                if i < flat:
                    dx, dy = _from_segment(segments, i, x, y)
                    distance = math.sqrt(dx * dx + dy * dy)
                    length = distance
                else:
                    circle = i - flat
                    dx, dy = x - circles[circle, 0], y - circles[circle, 1]
                    length = math.sqrt(dx * dx + dy * dy)
                    distance = length - circles[circle, 2]
                if distance < best and distance < reach:
                    best = distance
                    away_x, away_y = (dx / length, dy / length) if length > 0.0 else (0.0, 0.0)
    return best, away_x, away_y


@njit(error_model="numpy", makes_arrays=False)
def _from_segment(segments: _Floats, i: int, x: float, y: float) -> tuple[float, float]:
    """Return the vector to a point from the nearest point of a segment."""
    ax, ay = x - segments[i, 0], y - segments[i, 1]
    ex, ey = segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
    share = min(max((ax * ex + ay * ey) / (ex * ex + ey * ey), 0.0), 1.0)
    return ax - share * ex, ay - share * ey
