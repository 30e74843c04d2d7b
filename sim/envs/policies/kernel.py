"""Compiled: the shortest path through the cells of a patch."""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["step_towards"]

_DIAGONAL = math.sqrt(2)


@njit()
def _next_cell(length, row, col):
    """Return the neighbour over which a goal is nearest."""
    best, best_row, best_col = np.inf, row, col
    for i in range(max(row - 1, 0), min(row + 2, length.shape[0])):
        for j in range(max(col - 1, 0), min(col + 2, length.shape[1])):
            if i == row and j == col:
                continue
            left = length[i, j] + (1.0 if i == row or j == col else _DIAGONAL)
            if left < best:
                best, best_row, best_col = left, i, j
    return best_row, best_col


@njit()
def _relax(length, cost):
    """Sweep up and down until no path becomes shorter: the lengths are then the shortest."""
    rows, cols = length.shape
    changed = True
    while changed:
        changed = False
        for sweep in range(4):
            for i in range(rows):
                row = i if sweep < 2 else rows - 1 - i
                for j in range(cols):
                    col = j if sweep % 2 == 0 else cols - 1 - j
                    if cost[row, col] == np.inf:
                        continue
                    shortest = np.inf
                    for m in range(max(row - 1, 0), min(row + 2, rows)):
                        for n in range(max(col - 1, 0), min(col + 2, cols)):
                            step = 1.0 if m == row or n == col else _DIAGONAL
                            shortest = min(shortest, length[m, n] + step * cost[row, col])
                    if shortest < length[row, col] - 1e-9:
                        length[row, col] = shortest
                        changed = True


@njit()
def step_towards(goals, cost, row, col, steps):
    """Return the cell that is some steps down the shortest path to the nearest goal.

    Parameters
    ----------
    goals : ndarray of bool, shape (rows, cols)
        Where to go.
    cost : ndarray, shape (rows, cols)
        Cost of a step into each cell, > 0; inf where there is no path.
    row, col : int
        Where the path begins.
    steps : int
        After so many steps the path is cut.

    Returns
    -------
    tuple of int
        Row and column; (-1, -1) if there is no path.
    """
    length = np.where(goals, 0.0, np.inf)
    _relax(length, cost)
    if length[row, col] == np.inf:
        return -1, -1
    for _ in range(steps):
        if goals[row, col]:
            break
        row, col = _next_cell(length, row, col)
    return row, col
