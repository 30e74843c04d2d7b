"""What methods have in common that find one point on a reading's arc from where arcs cross."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.cones import Beams, Cells, beams_of
from sonarmap.methods.onepass import ConeMethod, Scene, Votes
from sonarmap.occupancy import OccupancyMap

__all__ = ["PointMethod"]


@dataclass(frozen=True, kw_only=True)
class PointMethod(ConeMethod):
    """A method that places each reading's target at a point of its arc, or leaves it out.

    Parameters
    ----------
    crossing_rad : float
        Least angle under which arcs cross for it to count, in [0, pi/2).
    tolerance_m : float
        A cone is free up to so much before its reading, metres, > 0.
    point_weight : float
        How many passing cones one point outweighs, > 0.
    no_echo, max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    The papers make points, not maps. The map is ours: with h points in a cell and f cones that
    are free there, support is (w h - f) / (w h + f + 1), w = point_weight. A reading whose target
    is not found still frees its cone.
    """

    crossing_rad: float = 0.0
    tolerance_m: float = 0.1
    point_weight: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("tolerance_m", self.tolerance_m)
        positive("point_weight", self.point_weight)

    @abstractmethod
    def bearings_rad(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the bearing of each echo's target off the axis, NaN where it is not found."""

    def fuse(self, log: SonarLog, grid: GridSpec, votes: Votes | None = None) -> OccupancyMap:
        """Return the map of a log on a grid, with a remedy for repeated readings or without."""
        from sonarmap.kernels.layers import add_votes  # numba: loaded when mapping

        scene = self.scene(log.ring, grid)
        beams = beams_of(log, scene.limit_m, self.no_echo)
        target = self._targets(scene, beams)
        reach_m = np.maximum(beams.range_m - np.where(beams.echo, self.tolerance_m, 0.0), 0.0)
        hits, passes = np.zeros(scene.size), np.zeros(scene.size)
        begin = 0
        for part, cone in self.touched(scene, beams, reach_m):
            cells = _with_target(cone, target[begin : begin + len(part)], part.range_m)
            begin += len(part)
            if votes is not None:
                cells = votes.admit(part, cells)
            # No echo ends nowhere, not even in a cell that lies at the very limit.
            ends_m = np.where(part.echo, part.range_m, np.inf)
            add_votes(hits, passes, cells.first, cells.cell, cells.range_m, ends_m)
        weighed = self.point_weight * hits
        support = (weighed - passes) / (weighed + passes + 1)
        return self.from_support(grid, support, (hits > 0) | (passes > 0))

    def _targets(self, scene: Scene, beams: Beams) -> NDArray[np.int64]:
        """Return the flat index of the cell of each beam's target, -1 where there is none."""
        echoes = beams.select(beams.echo)
        axis_rad = echoes.axis_rad + self.bearings_rad(scene, echoes)
        reach_m = echoes.range_m
        x_m = echoes.sensor_xy_m[:, 0] + reach_m * np.cos(axis_rad)
        y_m = echoes.sensor_xy_m[:, 1] + reach_m * np.sin(axis_rad)
        row, col = scene.grid.cell_of(x_m, y_m)
        target = np.full(len(beams), -1)
        target[beams.echo] = np.where(
            scene.grid.contains(row, col), row * scene.grid.cols + col, -1
        )
        return target


def _with_target(cells: Cells, target: NDArray[np.int64], reading_m: NDArray[np.float64]) -> Cells:
    """Return the cells of cones, each with its target's after them, whose range is the reading."""
    there = target >= 0
    ends = cells.first[1:][there]
    first = cells.first + np.concatenate([[0], np.cumsum(there)])
    return Cells(
        first,
        np.insert(cells.cell, ends, target[there]),
        np.insert(cells.range_m, ends, reading_m[there]),
        np.insert(cells.share, ends, 0.0),
    )
