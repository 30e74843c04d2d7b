"""Kernel that marks the cells which cones of rays see: up to the first surface, and that too.

Everything here is in cells: x counts columns and y rows from the lower-left corner of cell
(0, 0), a grid of cells of side 1.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.jit import njit
from worlds.facetable import FaceTable
from worlds.raycast import face_normal, first_hit

__all__ = ["mark_visible"]

_Floats = NDArray[np.float64]


@njit()
def mark_visible(
    seen: NDArray[np.bool_],
    cones: _Floats,
    half_angle: float,
    rays: int,
    reach: float,
    behind: float,
    faces: FaceTable,
) -> None:
    """Mark in `seen` (rows, cols) what cones (n, 3) of x, y and axis angle see.

    Each cone is swept by `rays` rays from edge to edge. Two neighbours that end on the same
    face have seen the face between them as well: under a grazing angle their ends lie several
    cells apart. `behind` is how far the surface's own cell is looked for behind its face.
    """
    segments, normals, circles, _, _, grid, shape, cell_start, cell_face = faces
    for k in range(cones.shape[0]):
        x, y = cones[k, 0], cones[k, 1]
        last_face, last_x, last_y = -1, 0.0, 0.0
        for i in range(rays):
            angle = cones[k, 2] + half_angle * (2.0 * i / (rays - 1) - 1.0)
            dx, dy = math.cos(angle), math.sin(angle)
            distance, face = first_hit(
                segments, circles, grid, shape, cell_start, cell_face, 0, x, y, dx, dy, reach
            )
            if face < 0:
                _mark_line(seen, x, y, x + reach * dx, y + reach * dy)
            else:
                hit_x, hit_y = x + distance * dx, y + distance * dy
                _mark_line(seen, x, y, hit_x, hit_y)
                nx, ny = face_normal(normals, circles, face, hit_x, hit_y, dx, dy)
                hit_x, hit_y = hit_x - behind * nx, hit_y - behind * ny
                _mark_line(seen, hit_x, hit_y, hit_x, hit_y)
                if face == last_face:
                    _mark_line(seen, last_x, last_y, hit_x, hit_y)
                last_x, last_y = hit_x, hit_y
            last_face = face


@njit()
def _mark_line(seen: NDArray[np.bool_], x0: float, y0: float, x1: float, y1: float) -> None:
    """Mark every cell that the line from (x0, y0) to (x1, y1) passes through."""
    rows, cols = seen.shape
    col, row = cell_index(x0, 0.0, 1.0), cell_index(y0, 0.0, 1.0)
    last_col, last_row = cell_index(x1, 0.0, 1.0), cell_index(y1, 0.0, 1.0)
    dx, dy = x1 - x0, y1 - y0
    step_col, step_row = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    # Share of the line at which it crosses the next column and row, and from one to the next.
    next_col = (col + (dx > 0) - x0) / dx if dx != 0 else math.inf
    next_row = (row + (dy > 0) - y0) / dy if dy != 0 else math.inf
    per_col = abs(1.0 / dx) if dx != 0 else math.inf
    per_row = abs(1.0 / dy) if dy != 0 else math.inf
    # The count, and not a comparison with the last cell, ends the walk: rounding cannot
    # make it miss its end.
    for _ in range(abs(last_col - col) + abs(last_row - row) + 1):
        if 0 <= row < rows and 0 <= col < cols:
            seen[row, col] = True
        if next_col < next_row:
            col += step_col
            next_col += per_col
        else:
            row += step_row
            next_row += per_row
