"""`GridSpec`: the one place that knows how metres become cells."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sonarmap.errors import InputError, finite, positive

__all__ = ["GridSpec"]

_T = TypeVar("_T")

# A grid of this many cells takes 3.2 GB as float64; more is a slip of units, not a wish.
_MAX_CELLS = 400_000_000


@dataclass(frozen=True, slots=True)
class GridSpec:
    """Geometry of a grid: ``array[row, col]``, row grows with y, col with x.

    Parameters
    ----------
    resolution_m : float
        Side of a cell in metres, > 0.
    origin_xy_m : tuple of float
        Lower-left corner of cell (0, 0) in metres.
    shape : tuple of int
        (rows, cols), each >= 1.

    Notes
    -----
    A cell holds its lower and left border and not its upper and right one: the cell of a point
    is the `floor` of its distance from the origin in cells, also left of the origin.
    """

    resolution_m: float
    origin_xy_m: tuple[float, float]
    shape: tuple[int, int]

    def __post_init__(self) -> None:
        object.__setattr__(self, "resolution_m", positive("resolution_m", self.resolution_m))
        x_m, y_m = _pair("origin_xy_m", self.origin_xy_m)
        object.__setattr__(
            self, "origin_xy_m", (finite("origin_xy_m[0]", x_m), finite("origin_xy_m[1]", y_m))
        )
        rows, cols = (_whole("shape", n) for n in _pair("shape", self.shape))
        if rows < 1 or cols < 1:
            raise InputError(f"shape must be at least (1, 1), got {self.shape!r}")
        if rows * cols > _MAX_CELLS:
            raise InputError(f"shape must have at most {_MAX_CELLS} cells, got {self.shape!r}")
        object.__setattr__(self, "shape", (rows, cols))

    @classmethod
    def covering(
        cls, x_min_m: float, y_min_m: float, x_max_m: float, y_max_m: float, resolution_m: float
    ) -> GridSpec:
        """Return the smallest grid over a box whose cell borders are multiples of the resolution.

        Aligned borders let the grids of two logs, or of a log and a world, be laid over each
        other cell by cell.
        """
        size = positive("resolution_m", resolution_m)
        for name, low_m, high_m in (("x", x_min_m, x_max_m), ("y", y_min_m, y_max_m)):
            if finite(f"{name}_min_m", low_m) > finite(f"{name}_max_m", high_m):
                raise InputError(
                    f"{name}_min_m must be <= {name}_max_m, got {low_m!r} and {high_m!r}"
                )
        # The small slack keeps 0.3 / 0.1 = 2.9999... from adding a row for a rounding error.
        left, bottom = math.floor(x_min_m / size + 1e-9), math.floor(y_min_m / size + 1e-9)
        right, top = math.ceil(x_max_m / size - 1e-9), math.ceil(y_max_m / size - 1e-9)
        shape = (max(top - bottom, 1), max(right - left, 1))
        return cls(size, (left * size, bottom * size), shape)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.shape[0]

    @property
    def cols(self) -> int:
        """Number of columns."""
        return self.shape[1]

    @property
    def cell_area_m2(self) -> float:
        """Area of one cell in square metres."""
        return self.resolution_m**2

    @property
    def extent_m(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) in metres, as matplotlib's ``extent`` with origin 'lower'."""
        x_m, y_m = self.origin_xy_m
        return (x_m, x_m + self.cols * self.resolution_m, y_m, y_m + self.rows * self.resolution_m)

    def cell_of(
        self, x_m: ArrayLike, y_m: ArrayLike
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return (row, col) of points; they may lie outside the grid, see `contains`.

        A coordinate that is not finite, as of the data point of no echo, is in row or column -1,
        outside of every grid.
        """
        row = (np.asarray(y_m, float) - self.origin_xy_m[1]) / self.resolution_m
        col = (np.asarray(x_m, float) - self.origin_xy_m[0]) / self.resolution_m
        return _floor(row), _floor(col)

    def centre_of(
        self, row: ArrayLike, col: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (x_m, y_m) of cell centres."""
        x_m = self.origin_xy_m[0] + (np.asarray(col) + 0.5) * self.resolution_m
        y_m = self.origin_xy_m[1] + (np.asarray(row) + 0.5) * self.resolution_m
        return x_m, y_m

    def contains(self, row: ArrayLike, col: ArrayLike) -> NDArray[np.bool_]:
        """Return which (row, col) lie inside the grid."""
        row, col = np.asarray(row), np.asarray(col)
        inside: NDArray[np.bool_] = (row >= 0) & (row < self.rows) & (col >= 0) & (col < self.cols)
        return inside


def _floor(cells: NDArray[np.float64]) -> NDArray[np.int64]:
    # What integer a NaN becomes differs between processors; comparing it is False everywhere.
    known = np.abs(cells) < 2**62
    return np.floor(np.where(known, cells, -1)).astype(np.int64)


def _pair(name: str, values: tuple[_T, _T]) -> tuple[_T, _T]:
    try:
        first, second = values
    except (TypeError, ValueError):
        raise InputError(f"{name} must be two numbers, got {values!r}") from None
    return first, second


def _whole(name: str, value: float) -> int:
    if not finite(name, value).is_integer():
        raise InputError(f"{name} must be whole numbers, got {value!r}")
    return int(value)
