"""In the style of Lee and Chung: the loudest reading of a cell decides, and judges the others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative, positive, whole
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.cones import Beams, NoEcho, beams_of
from sonarmap.methods.onepass import ConeMethod, Votes
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["ConflictEvaluation"]

# Of the sound pressure over the bearing in degrees, see the class.
_SQUARE, _SLOPE = -0.00102, 0.00241


@dataclass(frozen=True, kw_only=True)
class ConflictEvaluation(ConeMethod):
    """Conflict evaluation with sound pressure, and the map of what survives and is mended.

    Parameters
    ----------
    thickness_m : float
        beta, half of the thickness of an arc, metres, > 0.
    short_m : float
        Readings up to it count on their arcs as if half as far, metres, >= 0.
    path_cells : int
        Cells within so many rows and columns of the robot's path are free, >= 0.
    no_echo
        "clear" by default: the whole cone is free, and judged like the others.
    max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    1. The sound pressure of a reading at a cell at range r and bearing t (degrees) is
       SP = -0.00102 t^2 + 0.00241 t - log10(r), and log10(2) more on the arc of a short reading.
    2. A reading R votes "occupied" where |r - R| <= beta, "free" where r < R - beta; without an
       echo free in its whole cone.
    3. Each cell keeps the vote with the largest SP (of equal ones "occupied"); the robot's path is
       free.
    4. A reading is wrong if an occupied cell lies in its cone before R - beta, right if not and one
       lies on its arc; without an echo right if none lies in its cone. All others are wrong.
    5. Right readings mark their arcs occupied, then all readings their sectors free, the wrong ones
       up to beta before the nearest occupied cell in their cone if that is nearer than R. The
       path is free.

    Support is the mark: 1, -1, and 0 where there is none; nothing in between, so that P(occupied)
    is 1, 0 or 1/2.

    The rules and numbers are those of a public implementation of the idea (for a cleaning robot
    with cones of 40 degrees, cells of 120 mm and a range of 2.9 m); the papers themselves could
    not be had. Ours: one map for all sonars, the ring's own cone and range, and metres in SP.
    """

    name: ClassVar[str] = "conflict-evaluation-style"
    source: ClassVar[str] = (
        "After Lee and Chung, Conflict Evaluation Method for Grid Maps Using Sonar Sensors, 2008 "
        "to 2009, and US patent 8,018,792, by a public implementation."
    )

    thickness_m: float = 0.07
    short_m: float = 0.4
    path_cells: int = 2
    no_echo: NoEcho = "clear"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("thickness_m", self.thickness_m)
        non_negative("short_m", self.short_m)
        whole("path_cells", self.path_cells, least=0)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "thickness_m": Real(0.025, 0.2),
            "short_m": Real(0.0, 1.0),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def fuse(self, log: SonarLog, grid: GridSpec, votes: Votes | None = None) -> OccupancyMap:
        """Return the map of a log on a grid, with a remedy for repeated readings or without."""
        from sonarmap.kernels.layers import (  # numba: loaded when mapping
            judge_beams,
            mark_arcs,
            mark_free,
            strongest_votes,
        )

        scene = self.scene(log.ring, grid)
        beams = beams_of(log, scene.limit_m, self.no_echo)
        reach_m = beams.range_m + np.where(beams.echo, self.thickness_m, 0.0)
        pressure, occupied = np.full(scene.size, -np.inf), np.zeros(scene.size, bool)
        cones = []
        for part, cells in self.touched(scene, beams, reach_m, votes):
            strongest_votes(
                pressure,
                occupied,
                cells.first,
                cells.cell,
                cells.range_m,
                cells.share,
                part.range_m,
                part.echo,
                math.degrees(scene.half_angle_rad),
                _SQUARE,
                _SLOPE,
                self.thickness_m,
                self.short_m,
            )
            # Kept for two more passes: half the memory.
            cell = cells.cell.astype(np.int32)
            cones.append((part, (cells.first, cell, cells.range_m)))
        path = self._path(beams, grid)
        occupied[path] = False
        state, borders_m = np.zeros(scene.size), []
        for part, listed in cones:
            right, mended_m = judge_beams(
                occupied, *listed, part.range_m, part.echo, self.thickness_m
            )
            mark_arcs(state, *listed, part.range_m, right & part.echo, self.thickness_m)
            whole_cone = right & ~part.echo
            # The cells at the very limit belong to a cone without an echo.
            borders_m.append(np.where(whole_cone, np.inf, mended_m - self.thickness_m))
        for (_, listed), border_m in zip(cones, borders_m, strict=True):
            mark_free(state, *listed, border_m)
        state[path] = -1
        return self.from_support(grid, state, state != 0)

    def _path(self, beams: Beams, grid: GridSpec) -> NDArray[np.int64]:
        """Return the flat indices of the cells on and beside the robot's path."""
        at = np.unique(np.column_stack(grid.cell_of(*beams.robot_xy_m.T)), axis=0)
        beside = np.arange(-self.path_cells, self.path_cells + 1)
        row = at[:, 0, None, None] + beside[:, None] + 0 * beside
        col = at[:, 1, None, None] + beside + 0 * beside[:, None]
        inside = grid.contains(row, col)
        cells: NDArray[np.int64] = (row * grid.cols + col)[inside]
        return cells
