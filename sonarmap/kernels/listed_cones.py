"""The cells of many cones as plain lists, for methods that visit them again and again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.grid import GridSpec
from sonarmap.kernels.fusion import (
    Cone,
    GridCells,
    Sensors,
    bearing_polynomial,
    count_cells,
    list_cones,
)
from sonarmap.kernels.jit import njit

__all__ = ["ListedCones"]


@dataclass(frozen=True, eq=False)
class ListedCones:
    """The cells of n cones on a grid, cone after cone.

    Parameters
    ----------
    first : ndarray of int, shape (n + 1,)
        Where the cells of each cone begin in the other arrays.
    cell : ndarray of int, shape (cells,)
        Flat index in the grid.
    range_m, share : ndarray, shape (cells,)
        Distance of the cell's centre from the sonar, metres, and its bearing / half-angle in
        [0, 1].
    """

    first: NDArray[np.int64]
    cell: NDArray[np.int32]
    range_m: NDArray[np.float64]
    share: NDArray[np.float64]

    @classmethod
    def on(
        cls,
        grid: GridSpec,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        half_angle_rad: float,
        reach_m: NDArray[np.float64],
    ) -> ListedCones:
        """List the cells whose centres lie in each cone, up to its reach.

        Parameters
        ----------
        grid : GridSpec
            Where the cells are; what lies outside is left out.
        sensor_xy_m, axis_rad : ndarray, shapes (n, 2), (n,)
            Places and axes of the sonars, metres and radians.
        half_angle_rad : float
            Half-angle of the cones, at most 60 degrees.
        reach_m : ndarray, shape (n,)
            How far each cone is listed, metres.
        """
        place = GridCells(*grid.shape, *grid.origin_xy_m, grid.resolution_m)
        sensors = Sensors(sensor_xy_m, axis_rad)
        cone = Cone(half_angle_rad, bearing_polynomial(half_angle_rad))
        bounds = count_cells(place, sensors, half_angle_rad, reach_m)
        first_run, first_cell, run_cell, run_length, range_m, share = list_cones(
            place, sensors, cone, reach_m, bounds
        )
        del first_run  # the runs of all cones follow one another, as the cells do
        return cls(first_cell, _cells_of(run_cell, run_length, range_m.size), range_m, share)


@njit(error_model="numpy")
def _cells_of(run_cell, run_length, size):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Return the flat index of each cell of runs."""
    cell = np.empty(size, np.int32)
    k = 0
    for run in range(run_cell.size):
        for step in range(run_length[run]):
            cell[k] = run_cell[run] + step
            k += 1
    return cell
