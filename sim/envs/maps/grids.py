"""`MapGrids`: the grids of the maps that robots make, and how they look from a robot."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from sim.envs.facts import RoomFacts
from sim.envs.maps.kernel import (
    FREE,
    HIDDEN,
    OCCUPIED,
    REACHABLE,
    Maps,
    see_patches,
)
from sim.envs.threads import in_parts
from sonarmap import OccupancyMap

__all__ = ["MapGrids"]

# Few robots are mapped by one thread: to start the others would cost more.
_FEW = 4


class MapGrids(ABC):
    """Occupancy maps of robots, a row a robot, and what the last readings gained.

    Readings count where they were fired by odometry.

    Parameters
    ----------
    robots : int
        How many.
    threads : int
        How many threads map them, where the mapping is compiled.
    """

    def __init__(self, robots: int, threads: int = 1) -> None:
        self._threads = threads
        self._facts: list[RoomFacts | None] = [None] * robots
        self._maps = Maps(
            log_odds=np.zeros((robots, 1, 1)),
            kind=np.zeros((robots, 1, 1), np.int8),
            gains=np.zeros((robots, 3)),
            shapes=np.ones((robots, 2), np.int64),
            grids=np.ones((robots, 3)),
        )

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

    @abstractmethod
    def add(self, states: NDArray[np.void], rows: NDArray[np.int64]) -> None:
        """Add the readings of the last control step to the maps of some robots.

        `bits_gained` and `new_cells` are then those of this call.
        """

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

        def some(begin: int, end: int, _: int) -> None:
            rows = slice(begin, end)
            maps = tuple(part[rows] for part in self._maps)
            see_patches(patches[rows], states[rows], maps, cell_m)

        in_parts(some, len(states), self._threads_for(len(states)))
        return patches

    def map_of(self, row: int) -> OccupancyMap:
        """Return a copy of one robot's map."""
        facts = self._facts_of(row)
        return OccupancyMap(
            facts.grid, self._maps.log_odds[row, : facts.grid.rows, : facts.grid.cols]
        )

    def _facts_of(self, row: int) -> RoomFacts:
        facts = self._facts[row]
        assert facts is not None, "asked before begin"
        return facts

    def _threads_for(self, robots: int) -> int:
        return 1 if robots < _FEW else self._threads

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
