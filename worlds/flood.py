"""Kernel that floods a grid from a cell."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["flood"]


@njit(cache=True)
def flood(open_cells: NDArray[np.bool_], row: int, col: int) -> NDArray[np.bool_]:
    """Return the open cells that are connected to (row, col) over their four sides."""
    rows, cols = open_cells.shape
    reached = np.zeros((rows, cols), dtype=np.bool_)
    if not open_cells[row, col]:
        return reached
    # A cell is marked when it is put on the stack, so it is put there once.
    stack = np.empty(rows * cols, dtype=np.int64)
    stack[0] = row * cols + col
    reached[row, col] = True
    size = 1
    while size > 0:
        size -= 1
        r, c = divmod(stack[size], cols)
        for dr, dc in ((-1, 0), (1, 0), (0, -1), (0, 1)):
            rr, cc = r + dr, c + dc
            if not (0 <= rr < rows and 0 <= cc < cols):
                continue
            if open_cells[rr, cc] and not reached[rr, cc]:
                reached[rr, cc] = True
                stack[size] = rr * cols + cc
                size += 1
    return reached
