"""Which cells of a grid a solid covers a part of."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from sonarmap.grid import GridSpec
from worlds.solids import Solid

__all__ = ["INSET_M", "touched_cells"]

# Cells are shrunk by this on every side, so that a face that lies on the border of two cells
# touches only the cell behind it, whatever the rounding of its coordinates.
INSET_M = 1e-6
# Blocks of this many cells a side are tested before their cells: a room's wall is a ring, and
# most of the cells within its bounds are nowhere near it.
_BLOCK = 32

_Indices = NDArray[np.int64]


def touched_cells(solid: Solid, grid: GridSpec) -> tuple[_Indices, _Indices]:
    """Return (row, col) of the cells of which the solid covers a positive area."""
    x_min, y_min, x_max, y_max = solid.outline.bounds
    (row_min, row_max), (col_min, col_max) = grid.cell_of([x_min, x_max], [y_min, y_max])
    rows = np.arange(max(row_min, 0), min(row_max + 1, grid.rows))
    cols = np.arange(max(col_min, 0), min(col_max + 1, grid.cols))
    shapely.prepare(solid.outline)
    block_row, block_col = _pairs(np.unique(rows // _BLOCK), np.unique(cols // _BLOCK))
    near = _overlaps(solid, grid, block_row * _BLOCK, block_col * _BLOCK, span=_BLOCK)
    within_row, within_col = _pairs(np.arange(_BLOCK), np.arange(_BLOCK))
    row = (block_row[near, None] * _BLOCK + within_row).ravel()
    col = (block_col[near, None] * _BLOCK + within_col).ravel()
    inside = grid.contains(row, col)
    row, col = row[inside], col[inside]
    touched = _overlaps(solid, grid, row, col, span=1)
    return row[touched], col[touched]


def _overlaps(
    solid: Solid, grid: GridSpec, row: _Indices, col: _Indices, *, span: int
) -> NDArray[np.bool_]:
    """Return whether the solid meets each block of `span` cells a side that begins at a cell."""
    first_x, first_y = grid.centre_of(row, col)
    half = grid.resolution_m / 2 - INSET_M
    length = (span - 1) * grid.resolution_m
    left, right = first_x - half, first_x + length + half
    bottom, top = first_y - half, first_y + length + half
    overlaps: NDArray[np.bool_]
    if solid.circle is None:
        overlaps = shapely.intersects(solid.outline, shapely.box(left, bottom, right, top))
    else:
        x_m, y_m, radius_m = solid.circle
        nearest_x, nearest_y = np.clip(x_m, left, right), np.clip(y_m, bottom, top)
        overlaps = np.hypot(nearest_x - x_m, nearest_y - y_m) < radius_m
    return overlaps


def _pairs(first: _Indices, second: _Indices) -> tuple[_Indices, _Indices]:
    one, two = np.meshgrid(first, second, indexing="ij")
    return one.ravel(), two.ravel()
