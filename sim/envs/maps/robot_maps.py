"""`RobotMaps`: the occupancy maps that robots build as they drive."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim.envs.facts import RoomFacts
from sim.envs.maps.grids import MapGrids
from sim.envs.maps.kernel import Cones, Readings, add_fresh, fresh_echoes
from sim.envs.threads import PARTS, in_parts
from sonarmap import ParameterizedModel, SonarRing
from sonarmap.kernels.fusion import bearing_polynomial, cone_room
from sonarmap.methods.bayes.models import SensorModel

__all__ = ["MAP_MODEL", "RobotMaps"]

MAP_MODEL = ParameterizedModel(p1=0.4, p2=0.02, p3_m=0.05, p4=0.6, p5_rad=math.radians(15))
"""What the environments' maps make of a reading. Ten readings a second repeat one another, and the
thesis's model, which takes each for news, makes a map worse the longer a robot drives: -0.41 to
0.07 bit a cell after 50 s in four rooms. This one trusts a reading less: 0.06 to 0.53 bit."""


class RobotMaps(MapGrids):
    """Occupancy maps of robots, as `sonarmap.build_map` makes them, in a few compiled calls.

    No echo is ignored.

    Parameters
    ----------
    robots : int
        How many.
    ring : SonarRing
        The sonars of every robot.
    model : SensorModel
        What a reading says of the cells in its cone.
    max_range_m : float
        Longer readings are ignored, as by `sonarmap.build_map`; > 0.
    threads : int
        How many threads map them.
    """

    def __init__(
        self,
        robots: int,
        ring: SonarRing,
        model: SensorModel,
        max_range_m: float = math.inf,
        threads: int = 1,
    ) -> None:
        super().__init__(robots, threads)
        self._model = model
        self._cones = Cones(
            np.column_stack([ring.x_m, ring.y_m, ring.heading_rad]),
            model.half_angle_rad,
            bearing_polynomial(model.half_angle_rad),
        )
        self._limit_m = min(ring.range_max_m, model.range_limit_m, max_range_m)
        self._cells = tuple(np.empty((PARTS, 1)) for _ in range(6))
        self._runs = np.empty((PARTS, 2, 1), np.int64)

    def begin(self, row: int, facts: RoomFacts) -> None:
        """Begin an empty map of a room."""
        super().begin(row, facts)
        grid = facts.grid
        reach_m = self._model.regions(np.array([self._limit_m])).reach_m
        self._need(cone_room(*grid.shape, grid.resolution_m, reach_m), grid.rows)

    def add(self, states: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        """Add the readings of the last control step, see `MapGrids.add`."""
        self._maps.gains[rows, :2] = 0.0
        range_m, number = fresh_echoes(states, self._limit_m)
        regions = self._model.regions(range_m)
        readings = Readings(number, regions.border_m, regions.axis, regions.edge)
        fields = tuple(self._maps), tuple(self._cones), tuple(readings)

        def some(begin: int, end: int, part: int) -> None:
            cells = tuple(memory[part] for memory in self._cells)
            add_fresh(states, rows[begin:end], *fields, cells, self._runs[part])

        in_parts(some, rows.size, self._threads_for(rows.size))

    def _need(self, room: int, rows: int) -> None:
        """Hold working memory for cones of so many cells and rows, a row of it for each part.

        It is kept: to get it anew at every step would cost as much as the work.
        """
        had_room, had_rows = self._cells[0].shape[1], self._runs.shape[2]
        if room > had_room or rows > had_rows:
            self._cells = tuple(np.empty((PARTS, max(room, had_room))) for _ in range(6))
            self._runs = np.empty((PARTS, 2, max(rows, had_rows)), np.int64)
