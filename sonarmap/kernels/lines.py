"""The cells that straight lines pass through."""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.jit import njit

__all__ = ["list_lines"]


@njit(error_model="numpy")
def list_lines(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    rows, cols, origin_x, origin_y, resolution, start_xy, end_xy
):
    """List the cells of n lines in the order in which they are passed, ends included.

    Each step goes to the cell on the other side of the border that the line meets next (Amanatides
    and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987).

    Parameters
    ----------
    rows, cols, origin_x, origin_y, resolution
        The grid, metres; cells outside of it are left out.
    start_xy, end_xy : ndarray, shape (n, 2)
        Ends of the lines, metres.

    Returns
    -------
    first : ndarray, shape (n + 1,)
        Where the cells of each line begin.
    cell : ndarray, shape (cells,)
        Flat indices.
    ranges : ndarray, shape (cells,)
        Distance of the cells' centres from the line's start, metres.
    """
    n = start_xy.shape[0]
    first = np.zeros(n + 1, np.int64)
    room = 0
    for i in range(n):
        room += abs(
            cell_index(end_xy[i, 1], origin_y, resolution)
            - cell_index(start_xy[i, 1], origin_y, resolution)
        )
        room += 1 + abs(
            cell_index(end_xy[i, 0], origin_x, resolution)
            - cell_index(start_xy[i, 0], origin_x, resolution)
        )
    cell, ranges = np.empty(room, np.int64), np.empty(room)
    size = 0
    for i in range(n):
        x, y = start_xy[i, 0], start_xy[i, 1]
        dx, dy = end_xy[i, 0] - x, end_xy[i, 1] - y
        row, col = cell_index(y, origin_y, resolution), cell_index(x, origin_x, resolution)
        more_rows = abs(cell_index(end_xy[i, 1], origin_y, resolution) - row)
        more_cols = abs(cell_index(end_xy[i, 0], origin_x, resolution) - col)
        up, right = (1 if dy > 0 else -1), (1 if dx > 0 else -1)
        while True:
            if 0 <= row < rows and 0 <= col < cols:
                cell[size] = row * cols + col
                ranges[size] = math.hypot(
                    origin_x + (col + 0.5) * resolution - x, origin_y + (row + 0.5) * resolution - y
                )
                size += 1
            if more_rows == 0 and more_cols == 0:
                break
            # How far along the line the next border lies, as a share of its length.
            next_row = (origin_y + (row + (up > 0)) * resolution - y) / dy if more_rows else np.inf
            next_col = (
                (origin_x + (col + (right > 0)) * resolution - x) / dx if more_cols else np.inf
            )
            if next_row < next_col:
                row += up
                more_rows -= 1
            else:
                col += right
                more_cols -= 1
        first[i + 1] = size
    return first, cell[:size].copy(), ranges[:size].copy()
