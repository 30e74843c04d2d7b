"""Odometry's free space: where the robot's body has been there is no wall."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.sheet import SHARE, proper_share
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["FreeSpace"]


@dataclass(frozen=True)
class FreeSpace:
    """The blank sheet with the cells that the robot drove over: a map without any sonar.

    Parameters
    ----------
    radius_m : float
        Radius of the robot's body, metres, > 0. The default is the AmigoBot's as ARIA plans with
        it (RobotRadius 180).
    driven : float
        P(occupied) of a cell whose centre the body covered at some firing, in (0, share].
    share : float
        P(occupied) of all others, in (0, 1).
    """

    name: ClassVar[str] = "free-space"
    source: ClassVar[str] = "Ours: what odometry alone tells."

    radius_m: float = 0.18
    driven: float = 0.01
    share: float = SHARE

    def __post_init__(self) -> None:
        positive("radius_m", self.radius_m)
        proper_share("share", self.share)
        if proper_share("driven", self.driven) > self.share:
            raise InputError(f"driven must be <= share {self.share!r}, got {self.driven!r}")

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map; the driven cells are the observed ones."""
        driven = _covered(log, grid, self.radius_m)
        return OccupancyMap.from_probability(
            grid, np.where(driven, self.driven, self.share), driven
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {"radius_m": Real(0.1, 0.25), "share": Real(0.02, 0.3)}


def _covered(log: SonarLog, grid: GridSpec, radius_m: float) -> NDArray[np.bool_]:
    """Return which cells' centres the body covered at a usable reading, shape (rows, cols)."""
    used = log.usable
    # The readings of a scan may share their pose.
    poses = np.unique(np.column_stack([log.x_m, log.y_m])[used], axis=0)
    at_row, at_col = grid.cell_of(poses[:, 0], poses[:, 1])
    covered = np.zeros(grid.shape, bool)
    cells = int(radius_m / grid.resolution_m) + 1
    for row in range(-cells, cells + 1):
        for col in range(-cells, cells + 1):
            x_m, y_m = grid.centre_of(at_row + row, at_col + col)
            near = np.hypot(x_m - poses[:, 0], y_m - poses[:, 1]) <= radius_m
            near &= grid.contains(at_row + row, at_col + col)
            covered[at_row[near] + row, at_col[near] + col] = True
    return covered
