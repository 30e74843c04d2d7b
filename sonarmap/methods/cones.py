"""The readings that a method uses, and the cells that each of them touches.

A method of evidence sees the log through two values: `Beams`, the readings that say anything, and
`Cells`, the cells of their cones (or of their axes) as one flat list with range and bearing. What
stands between the two may drop cells: that is how the remedies for repeated readings work
(`sonarmap.methods.remedies`), for any method alike.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog

__all__ = ["Beams", "Cells", "NoEcho", "beams_of", "cone_cells"]

NoEcho = Literal["ignore", "clear"]

# Cells that are listed at a time, 20 bytes each: what the processor's caches hold.
_PART_CELLS = 250_000


@dataclass(frozen=True, eq=False)
class Beams:
    """The n readings of a log that say anything, in the order of firing.

    Parameters
    ----------
    sonar : ndarray of int, shape (n,)
        Number of the sonar in the ring.
    robot_xy_m, sensor_xy_m : ndarray, shape (n, 2)
        Place of the robot and of the sonar by odometry.
    axis_rad : ndarray, shape (n,)
        Direction of the acoustic axis.
    range_m : ndarray, shape (n,)
        The reading in metres; for no echo the range up to which one would have been heard.
    echo : ndarray of bool, shape (n,)
        Whether there was an echo.
    """

    sonar: NDArray[np.int64]
    robot_xy_m: NDArray[np.float64]
    sensor_xy_m: NDArray[np.float64]
    axis_rad: NDArray[np.float64]
    range_m: NDArray[np.float64]
    echo: NDArray[np.bool_]

    def __len__(self) -> int:
        return int(self.range_m.size)

    def select(self, rows: slice | NDArray[np.bool_]) -> Beams:
        """Return the beams of the given rows."""
        return Beams(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Cells:
    """The cells that n beams touch, beam by beam.

    Parameters
    ----------
    first : ndarray of int, shape (n + 1,)
        Where the cells of each beam begin.
    cell : ndarray of int, shape (cells,)
        Flat index in the grid.
    range_m : ndarray, shape (cells,)
        Distance of the cell's centre from the sonar.
    share : ndarray, shape (cells,)
        Absolute bearing of the cell's centre off the axis, over the half-angle.
    """

    first: NDArray[np.int64]
    cell: NDArray[np.int64]
    range_m: NDArray[np.float64]
    share: NDArray[np.float64]

    def keep(self, kept: NDArray[np.bool_]) -> Cells:
        """Return the list without the cells that are not kept."""
        from sonarmap.kernels.layers import keep_cells  # numba: loaded when mapping

        return Cells(*keep_cells(self.first, self.cell, self.range_m, self.share, kept))


def beams_of(log: SonarLog, limit_m: float, no_echo: NoEcho) -> Beams:
    """Return the readings of a log that say anything.

    Stale, rejected and too close readings never do. One above `limit_m` is taken as no echo, which
    says nothing ("ignore") or that the cone is free up to there ("clear").
    """
    known = log.usable & (log.range_m >= 0)
    echo = known & (log.range_m <= limit_m)
    used = echo if no_echo == "ignore" else known
    return Beams(
        log.sonar[used].astype(np.int64),
        np.column_stack([log.x_m[used], log.y_m[used]]),
        log.sensor_xy_m[used],
        log.axis_rad[used],
        np.where(echo, log.range_m, limit_m)[used],
        echo[used],
    )


def cone_cells(
    beams: Beams, grid: GridSpec, half_angle_rad: float, reach_m: NDArray[np.float64]
) -> Iterator[tuple[slice, Cells]]:
    """List the cells of beams' cones, part by part.

    A cell belongs to a cone when its centre lies within the half-angle of the axis and within
    reach of the sonar, both borders included.

    Parameters
    ----------
    beams : Beams
        The beams.
    grid : GridSpec
        Where the cells are.
    half_angle_rad : float
        Half of the cone's width.
    reach_m : ndarray, shape (n,)
        How far each cone is listed.

    Yields
    ------
    rows : slice
        Which of the beams; the parts follow one another.
    cells : Cells
        The cells of these.
    """
    from sonarmap.kernels import fusion  # numba: loaded when mapping
    from sonarmap.kernels.layers import expand_runs

    if len(beams) == 0:
        return
    where = fusion.GridCells(*grid.shape, *grid.origin_xy_m, grid.resolution_m)
    cone = fusion.Cone(half_angle_rad, fusion.bearing_polynomial(half_angle_rad))
    sensors = fusion.Sensors(beams.sensor_xy_m, beams.axis_rad)
    bounds = fusion.count_cells(where, sensors, half_angle_rad, reach_m)
    parts = bounds[:, 0].cumsum() // _PART_CELLS
    begins = [0, *(np.flatnonzero(np.diff(parts)) + 1).tolist(), len(beams)]
    for begin, end in itertools.pairwise(begins):
        rows = slice(begin, end)
        part = fusion.Sensors(beams.sensor_xy_m[rows], beams.axis_rad[rows])
        _, first, run_cell, run_length, range_m, share = fusion.list_cones(
            where, part, cone, reach_m[rows], bounds[rows]
        )
        yield rows, Cells(first, expand_runs(run_cell, run_length, range_m.size), range_m, share)
