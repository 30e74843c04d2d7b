"""`RobotMaps`: the occupancy maps that robots build as they drive."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager

import numpy as np
from numpy.typing import NDArray

from sim.envs.facts import RoomFacts
from sim.envs.maps.kernel import (
    FREE,
    HIDDEN,
    OCCUPIED,
    REACHABLE,
    Cones,
    Maps,
    Readings,
    add_fresh,
    add_fresh_together,
    fresh_echoes,
    see_patches,
    see_patches_together,
)
from sim.envs.threads import numba_threads
from sonarmap import OccupancyMap, ParameterizedModel, SonarRing
from sonarmap.kernels.fusion import bearing_polynomial, cone_room
from sonarmap.methods.bayes.models import SensorModel

__all__ = ["MAP_MODEL", "RobotMaps"]

MAP_MODEL = ParameterizedModel(p1=0.4, p2=0.02, p3_m=0.05, p4=0.6, p5_rad=math.radians(15))
"""What the environments' maps make of a reading. Ten readings a second repeat one another, and the
thesis's model, which takes each for news, makes a map worse the longer a robot drives: -0.41 to
0.07 bit a cell after 50 s in four rooms. This one trusts a reading less: 0.06 to 0.53 bit."""

# Few robots are mapped by one thread: to start the others would cost more.
_FEW = 4
# Many are mapped in so many parts, each with memory of its own.
_JOBS = 16


class RobotMaps:
    """Occupancy maps of robots, as `sonarmap.build_map` makes them, reading by reading.

    Readings count where they were fired by odometry; no echo is ignored.

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
        self._model, self._threads = model, threads
        self._cones = Cones(
            np.column_stack([ring.x_m, ring.y_m, ring.heading_rad]),
            model.half_angle_rad,
            bearing_polynomial(model.half_angle_rad),
        )
        self._limit_m = min(ring.range_max_m, model.range_limit_m, max_range_m)
        self._facts: list[RoomFacts | None] = [None] * robots
        self._maps = Maps(
            log_odds=np.zeros((robots, 1, 1)),
            kind=np.zeros((robots, 1, 1), np.int8),
            gains=np.zeros((robots, 3)),
            shapes=np.ones((robots, 2), np.int64),
            grids=np.ones((robots, 3)),
        )
        self._cells = tuple(np.empty((_JOBS, 1)) for _ in range(6))
        self._runs = np.empty((_JOBS, 2, 1), np.int64)

    def begin(self, row: int, facts: RoomFacts) -> None:
        """Begin an empty map of a room."""
        grid = facts.grid
        self._facts[row] = facts
        self._grow(*grid.shape)
        maps = self._maps
        maps.log_odds[row] = 0.0
        maps.kind[row] = HIDDEN
        kind = maps.kind[row, : grid.rows, : grid.cols]
        kind[facts.sign == 1] = OCCUPIED
        kind[facts.sign == -1] = FREE
        kind[facts.reachable] = REACHABLE
        maps.shapes[row] = grid.shape
        maps.grids[row] = *grid.origin_xy_m, grid.resolution_m
        maps.gains[row] = 0.0
        reach_m = self._model.regions(np.array([self._limit_m])).reach_m
        self._need(cone_room(*grid.shape, grid.resolution_m, reach_m), grid.rows)

    def add(self, states: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        """Add the readings of the last control step to the maps of some robots.

        `bits_gained` and `new_cells` are then those of this call.
        """
        self._maps.gains[rows, :2] = 0.0
        range_m, number = fresh_echoes(states, self._limit_m)
        regions = self._model.regions(range_m)
        readings = Readings(number, regions.border_m, regions.axis, regions.edge)
        work = states, rows, tuple(self._maps), tuple(self._cones), tuple(readings)
        with self._threads_for(rows.size) as several:
            if several:
                add_fresh_together(*work, self._cells, self._runs)
            else:
                add_fresh(*work, tuple(part[0] for part in self._cells), self._runs[0])

    @property
    def bits_gained(self) -> NDArray[np.float64]:
        """Bits of the map score, summed over the cells, that the last readings gained."""
        return self._maps.gains[:, 0].copy()

    @property
    def new_cells(self) -> NDArray[np.float64]:
        """Cells, free or occupied in truth, of which the last readings were the first to speak."""
        return self._maps.gains[:, 1].copy()

    @property
    def mapped_cells(self) -> NDArray[np.float64]:
        """Reachable cells that each map calls free."""
        return self._maps.gains[:, 2].copy()

    def patches(self, states: NDArray[np.void], size: int, cell_m: float) -> NDArray[np.uint8]:
        """Return the maps around the robots, see `sim.envs.maps.kernel.see_patches`."""
        patches = np.empty((len(states), 1, size, size), np.uint8)
        with self._threads_for(len(states)) as several:
            see = see_patches_together if several else see_patches
            see(patches, states, tuple(self._maps), cell_m)
        return patches

    def map_of(self, row: int) -> OccupancyMap:
        """Return a copy of one robot's map."""
        facts = self._facts[row]
        assert facts is not None, "asked before begin"
        return OccupancyMap(
            facts.grid, self._maps.log_odds[row, : facts.grid.rows, : facts.grid.cols]
        )

    def _threads_for(self, robots: int) -> AbstractContextManager[bool]:
        return numba_threads(1 if robots < _FEW else self._threads)

    def _need(self, room: int, rows: int) -> None:
        """Hold working memory for cones of so many cells and rows, a row of it for each job.

        It is kept: to get it anew at every step would cost as much as the work.
        """
        had_room, had_rows = self._cells[0].shape[1], self._runs.shape[2]
        if room > had_room or rows > had_rows:
            self._cells = tuple(np.empty((_JOBS, max(room, had_room))) for _ in range(6))
            self._runs = np.empty((_JOBS, 2, max(rows, had_rows)), np.int64)

    def _grow(self, rows: int, cols: int) -> None:
        robots, had_rows, had_cols = self._maps.log_odds.shape
        shape = robots, max(rows, had_rows), max(cols, had_cols)
        if shape == self._maps.log_odds.shape:
            return
        grown = {}
        for name in ("log_odds", "kind"):
            old = getattr(self._maps, name)
            grown[name] = np.zeros(shape, old.dtype)
            grown[name][:, :had_rows, :had_cols] = old
        self._maps = self._maps._replace(**grown)
