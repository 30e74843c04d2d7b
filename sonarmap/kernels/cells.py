"""The rule by which metres become cells, for compiled code: `sonarmap.GridSpec` once more."""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["cell_index"]


@njit(inline="always", error_model="numpy")
def cell_index(place, origin, resolution):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the row or column of a finite coordinate, metres, as `GridSpec.cell_of` does.

    A cell holds its lower border and not its upper one. The result may lie outside of the grid.
    """
    return np.int64(math.floor((place - origin) / resolution))
