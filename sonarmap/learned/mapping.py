"""`learned_map`: from a log to P(occupied) and what was observed, on any grid.

The network sees cells of 5 cm, those that it was fitted to. A grid of that size is extended by a
margin, so that its border gives nothing away; one of another size is mapped on 5 cm cells over it,
and their logits are interpolated (smaller cells) or averaged as the largest of each cell (larger
cells), with a calibration of its own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.grid import GridSpec
from sonarmap.learned.channels import channels, telling
from sonarmap.learned.network import logits
from sonarmap.learned.weights import Calibration, Weights
from sonarmap.log import SonarLog

__all__ = ["CELL_M", "LearnedCells", "cells_of", "learned_cells", "logits_on"]

CELL_M = 0.05
"""Side of the cells that the network was fitted to, metres."""
_MARGIN = 8
# Probabilities that a cell was observed from which on it counts so, and up to which it hardly was.
# The first is even odds; the second, chosen on a shipped room, keeps maps turning with their logs.
_OBSERVED, _HARDLY = 0.5, 0.125


@dataclass(frozen=True, eq=False)
class LearnedCells:
    """What the network says of the cells of a grid.

    Parameters
    ----------
    probability : ndarray, shape (rows, cols)
        P(occupied), calibrated.
    observed : ndarray of bool, shape (rows, cols)
        Which cells the sonars could have seen, more likely than not.
    """

    probability: NDArray[np.float64]
    observed: NDArray[np.bool_]


def learned_cells(weights: Weights, log: SonarLog, grid: GridSpec) -> LearnedCells:
    """Return what the network says of the cells of a grid; without readings, the share of walls."""
    told = telling(log)
    if not len(told):
        return LearnedCells(np.full(grid.shape, weights.share), np.zeros(grid.shape, bool))
    return cells_of(weights, logits_on(weights, told, grid), grid)


def cells_of(weights: Weights, stack: NDArray[np.float32], grid: GridSpec) -> LearnedCells:
    """Return cells from their two logits, see `logits_on`.

    Where a cell hardly was observed, what the network makes of it is its fancy, which does not even
    turn with the log: the less likely, the nearer P is to the share of walls among such cells.
    """
    p = weights.calibration(grid.resolution_m / CELL_M).probability(stack[0])
    observed = Calibration().probability(stack[1])
    known = np.minimum(observed / _HARDLY, 1.0)
    return LearnedCells(known * p + (1 - known) * weights.share, observed > _OBSERVED)


def logits_on(weights: Weights, log: SonarLog, grid: GridSpec) -> NDArray[np.float32]:
    """Return the two logits of each cell of a grid, before calibration, shape (2, rows, cols)."""
    if math.isclose(grid.resolution_m, CELL_M, rel_tol=1e-9):
        around = _with_margin(grid)
        stack = logits(weights, channels(log, around))
        return stack[:, _MARGIN : _MARGIN + grid.rows, _MARGIN : _MARGIN + grid.cols]
    left, right, bottom, top = grid.extent_m
    inner = GridSpec.covering(left, bottom, right, top, CELL_M)
    around = _with_margin(inner)
    stack = logits(weights, channels(log, around))
    if grid.resolution_m < CELL_M:
        return _interpolated(stack, around, grid)
    return _largest(stack, around, grid)


def _with_margin(grid: GridSpec) -> GridSpec:
    x_m, y_m = grid.origin_xy_m
    beyond = _MARGIN * grid.resolution_m
    shape = (grid.rows + 2 * _MARGIN, grid.cols + 2 * _MARGIN)
    return GridSpec(grid.resolution_m, (x_m - beyond, y_m - beyond), shape)


def _interpolated(
    stack: NDArray[np.float32], source: GridSpec, grid: GridSpec
) -> NDArray[np.float32]:
    """Return layers at the centres of smaller cells, linear between the centres of the larger."""
    from scipy.ndimage import map_coordinates

    x_m, _ = grid.centre_of(0, np.arange(grid.cols))
    _, y_m = grid.centre_of(np.arange(grid.rows), 0)
    x0, y0 = source.origin_xy_m
    at = np.meshgrid(
        (y_m - y0) / source.resolution_m - 0.5,
        (x_m - x0) / source.resolution_m - 0.5,
        indexing="ij",
    )
    return np.stack([map_coordinates(layer, at, order=1, mode="nearest") for layer in stack])


def _largest(stack: NDArray[np.float32], source: GridSpec, grid: GridSpec) -> NDArray[np.float32]:
    """Return the largest of each layer over the smaller cells whose centres lie in a larger one."""
    x_m, y_m = source.centre_of(np.arange(source.rows), np.arange(source.cols))
    row, _ = grid.cell_of(np.full(source.rows, grid.origin_xy_m[0]), y_m)
    _, col = grid.cell_of(x_m, np.full(source.cols, grid.origin_xy_m[1]))
    rows = (row >= 0) & (row < grid.rows)
    cols = (col >= 0) & (col < grid.cols)
    flat = row[rows][:, None] * grid.cols + col[cols][None]
    out = np.full((len(stack), grid.rows * grid.cols), -np.inf, np.float32)
    for layer, values in zip(out, stack, strict=True):
        np.maximum.at(layer, flat.ravel(), values[rows][:, cols].ravel())
    return out.reshape(-1, *grid.shape)
