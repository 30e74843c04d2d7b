"""Conflict evaluation with sound pressure, in the style of Lee and Chung: a verdict, and a repair.

Lee and Chung (US patent 8,018,792, 2011; IEEE Transactions on Robotics 25(4), 2009): where readings
contradict each other, the one whose sound was stronger at the cell is believed (maximum
approximated likelihood), and readings that the map so made contradicts are wrong. The papers could
not be had in full; a public implementation for a cleaning robot was read as a specification, and
its numbers are the defaults. With r the range of a cell in millimetres and t its bearing in
degrees::

    pressure = -0.00102 t^2 + 0.00241 t - log10(r)     r / 2 on the arc of a reading up to 400 mm

1. A reading R votes occupied for the cells of its cone with |r - R| <= `thickness_m`, and free for
   the nearer ones; a no echo votes free up to the ring's maximum range.
2. Each cell keeps the vote of the greatest pressure there, a tie goes to occupied. Cells within two
   (king's moves) of the robot's path are free.
3. A reading is wrong if any cell of its cone nearer than its arc is occupied, or if none of its arc
   is; a no echo if any cell of its cone is.
4. A wrong reading is mended to the nearest occupied cell of its cone, if that is shorter.

Ours: a wrong reading that cannot be shortened is rejected (there it marks nothing), and a mended
one is a reading like any other (there it only frees what is before it, which a log cannot say). The
cone is the ring's own (there 40 degrees). Left out: a margin of relevance whose use is not clear.
A single short ghost, close and so loud, keeps its cells for ever: the method's own weak spot.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from sonarmap.errors import non_negative, one_of, positive, whole
from sonarmap.filters.protocol import Filtered
from sonarmap.grid import GridSpec
from sonarmap.log import Cause, SonarLog
from sonarmap.mapping import grid_over
from sonarmap.parameters import Real, Space, Whole

__all__ = ["ConflictEvaluationStyle", "sound_pressure"]

Action = Literal["mend", "reject"]

# Of the public implementation: bearing in degrees, range in millimetres.
_SQUARE, _LINEAR = -0.00102, 0.00241
# A cell that is the sonar's own place is as loud as at 1 mm.
_NEAREST_M = 0.001


@dataclass(frozen=True)
class ConflictEvaluationStyle:
    """Judges readings against the map of the loudest votes, and mends them; see the module.

    Parameters
    ----------
    cell_m : float
        Side of a cell, metres, > 0.
    thickness_m : float
        Half of the thickness of an arc, metres, > 0.
    short_m : float
        Up to this reading its arc counts as half as far away, metres, >= 0.
    path_cells : int
        Cells within so many king's moves of the path are free, >= 0.
    action : {"mend", "reject"}
        What becomes of a wrong reading that can be shortened; others are rejected in any case.
    """

    name: ClassVar[str] = "conflict-evaluation-style"
    source: ClassVar[str] = (
        "After Lee and Chung (US 8,018,792; IEEE T-RO 25(4), 2009) by the description of a public "
        "implementation; what a log makes of its repair is ours."
    )

    cell_m: float = 0.12
    thickness_m: float = 0.07
    short_m: float = 0.4
    path_cells: int = 2
    action: Action = "mend"

    def __post_init__(self) -> None:
        positive("cell_m", self.cell_m)
        positive("thickness_m", self.thickness_m)
        non_negative("short_m", self.short_m)
        object.__setattr__(self, "path_cells", whole("path_cells", self.path_cells, least=0))
        one_of("action", self.action, get_args(Action))

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with its wrong readings mended or rejected."""
        rows = np.flatnonzero(log.usable & (log.range_m >= 0))
        changed, cause = np.zeros(len(log), bool), np.full(len(log), -1)
        predicted_m = np.full(len(log), np.nan)
        if not rows.size:
            return Filtered(log, changed, predicted_m, cause)
        wrong, nearest_m = self._judged(log.select(rows))
        reading_m = log.range_m[rows]
        shorter = wrong & (nearest_m < reading_m)
        # A right reading is what it should be; of a wrong one without a wall nobody knows.
        predicted_m[rows] = np.where(shorter, nearest_m, np.where(wrong, np.nan, reading_m))
        cause[rows[shorter]] = Cause.BOUNCE
        cause[rows[shorter & np.isposinf(reading_m)]] = Cause.DROPOUT
        mended = shorter & (self.action == "mend")
        range_m, rejected = log.range_m.copy(), log.rejected.copy()
        range_m[rows[mended]] = nearest_m[mended]
        rejected[rows[wrong & ~mended]] = True
        after = log.replace(range_m=range_m, rejected=rejected)
        return Filtered(after, range_m != log.range_m, predicted_m, cause)

    def _judged(self, log: SonarLog) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Return which readings are wrong, and the nearest occupied cell of each cone, metres."""
        from sonarmap.kernels.listed_cones import ListedCones  # numba
        from sonarmap.kernels.pressure import judge, loudest_votes

        limit_m = log.ring.range_max_m
        echo = log.range_m <= limit_m
        reading_m = np.where(echo, log.range_m, limit_m)
        margin_m = 2 * limit_m * math.sin(log.ring.half_angle_rad / 2) + self.cell_m
        grid = grid_over(log, resolution_m=self.cell_m, margin_m=margin_m)
        cones = ListedCones.on(
            grid,
            log.sensor_xy_m,
            log.axis_rad,
            log.ring.half_angle_rad,
            reading_m + np.where(echo, self.thickness_m, 0.0),
        )
        each = np.repeat(np.arange(len(log)), np.diff(cones.first))
        on_arc = echo[each] & (cones.range_m >= reading_m[each] - self.thickness_m)
        halved = on_arc & (reading_m[each] <= self.short_m)
        pressure = sound_pressure(
            np.where(halved, 0.5, 1.0) * cones.range_m, cones.share * log.ring.half_angle_rad
        )
        cells = grid.rows * grid.cols
        occupied = np.zeros(cells, bool)
        listed = (cones.first, cones.cell, cones.range_m)
        loudest_votes(
            np.full(cells, -np.inf),
            occupied,
            *listed,
            pressure,
            reading_m,
            echo,
            self.thickness_m,
        )
        occupied &= ~self._path(log, grid).ravel()
        return judge(occupied, *listed, reading_m, echo, self.thickness_m)  # type: ignore[no-any-return]

    def _path(self, log: SonarLog, grid: GridSpec) -> NDArray[np.bool_]:
        """Return the cells around the robot's places."""
        path = np.zeros(grid.shape, bool)
        rows, cols = grid.cell_of(log.x_m, log.y_m)
        inside = grid.contains(rows, cols)
        path[rows[inside], cols[inside]] = True
        if self.path_cells == 0:
            return path
        size = 2 * self.path_cells + 1
        wide: NDArray[np.bool_] = binary_dilation(path, np.ones((size, size), bool))
        return wide

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "cell_m": Real(0.04, 0.2),
            "thickness_m": Real(0.03, 0.2),
            "short_m": Real(0.0, 1.5),
            "path_cells": Whole(0, 4),
        }


def sound_pressure(
    range_m: NDArray[np.float64], bearing_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the logarithm of the sound pressure at cells, up to a constant.

    Parameters
    ----------
    range_m, bearing_rad : ndarray
        Place of each cell as its sonar sees it, metres and radians; they broadcast.
    """
    degrees = np.degrees(np.abs(bearing_rad))
    away = np.log10(1000 * np.maximum(range_m, _NEAREST_M))
    pressure: NDArray[np.float64] = _SQUARE * degrees**2 + _LINEAR * degrees - away
    return pressure
