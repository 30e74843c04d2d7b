"""`RoomFacts`: what is true of a room for tasks: its cells, where a robot can be, and how far."""

from __future__ import annotations

import math
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import GridSpec, InputError
from worlds import FREE, OCCUPIED, Pose, World, truth
from worlds.raycast import clearance

__all__ = ["RoomFacts", "facts_of"]

# A robot that begins in a random place has this much room around it, so that its first move
# cannot be a collision. Assumed.
_ROOM_TO_TURN_M = 0.07
# Random goals lie on a lattice of so many cells, so that the distances to them can be kept.
_GOAL_LATTICE = 4


class RoomFacts:
    """What tasks need to know of a room; made once a room, see `facts_of`.

    Parameters
    ----------
    world : World
        The room.
    resolution_m : float
        Side of a cell, metres.

    Attributes
    ----------
    grid : GridSpec
        The cells.
    sign : ndarray of int8, shape (rows, cols)
        +1 occupied, -1 free, 0 hidden: what a map shall say.
    reachable : ndarray of bool, shape (rows, cols)
        Cells in whose centre the robot fits and to which it can drive from the world's start.
    """

    def __init__(self, world: World, resolution_m: float) -> None:
        self.world = world
        self.grid = GridSpec.covering(*world.bounds_m, resolution_m)
        known = truth(world, self.grid)
        self.sign = np.zeros(self.grid.shape, np.int8)
        self.sign[known.state == OCCUPIED] = 1
        self.sign[known.state == FREE] = -1
        self._room_m = np.where(known.state == FREE, self._clearance_m(), 0.0)
        self.reachable = self._connected(self._room_m >= BODY_RADIUS_M)
        self._distance_m = lru_cache(maxsize=256)(self._distance_from)

    def __reduce__(self) -> tuple[Any, ...]:
        # What follows from the room is made again where it is read, and shared there.
        return facts_of, (self.world, self.grid.resolution_m)

    @property
    def reachable_cells(self) -> int:
        """How many cells are reachable."""
        return int(self.reachable.sum())

    def random_start(self, rng: np.random.Generator) -> Pose:
        """Draw a place with some room around it, and a heading."""
        rows, cols = np.nonzero(self.reachable & (self._room_m >= BODY_RADIUS_M + _ROOM_TO_TURN_M))
        cell = int(rng.integers(rows.size))
        x_m, y_m = self.grid.centre_of(rows[cell], cols[cell])
        return Pose(float(x_m), float(y_m), float(rng.uniform(-math.pi, math.pi)))

    def random_goal(
        self, rng: np.random.Generator, start: Pose, nearest_m: float, farthest_m: float
    ) -> tuple[float, float]:
        """Draw a place that is between `nearest_m` and `farthest_m` of driving from the start.

        If there is none, it is the farthest place within `farthest_m`.
        """
        rows, cols = self._goal_cells
        distance_m = self.distance_m(start.x_m, start.y_m)[rows, cols]
        candidates = np.flatnonzero((distance_m >= nearest_m) & (distance_m <= farthest_m))
        if candidates.size:
            chosen = candidates[rng.integers(candidates.size)]
        else:
            chosen = np.where(distance_m <= farthest_m, distance_m, -1.0).argmax()
        x_m, y_m = self.grid.centre_of(rows[chosen], cols[chosen])
        return float(x_m), float(y_m)

    def distance_m(self, x_m: float, y_m: float) -> NDArray[np.float32]:
        """Return how far the robot has to drive from each cell to a place, inf if it cannot.

        Parameters
        ----------
        x_m, y_m : float
            The place, metres.

        Returns
        -------
        ndarray, shape (rows, cols)
            Metres over the centres of reachable cells, straight or diagonal: too long by 8 % at
            most (Borgefors, "Distance transformations in digital images", 1986).
        """
        distance_m: NDArray[np.float32] = self._distance_m(*self._nearest_reachable(x_m, y_m))
        return distance_m

    def is_reachable(self, x_m: float, y_m: float) -> bool:
        """Return whether the robot can be at a place and get there from the world's start."""
        row, col = (int(index) for index in self.grid.cell_of(x_m, y_m))
        if not self.grid.contains(row, col):
            return False
        around = self.reachable[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
        return bool(around.any()) and self.world.has_room_at(x_m, y_m, radius_m=BODY_RADIUS_M)

    def _clearance_m(self) -> NDArray[np.float64]:
        """Return how far each cell's centre is from the nearest face, up to a metre."""
        rows, cols = np.indices(self.grid.shape)
        x_m, y_m = self.grid.centre_of(rows, cols)
        table = self.world.faces.table
        found = [
            clearance(table, 0, x, y, 1.0)[0] for x, y in zip(x_m.ravel(), y_m.ravel(), strict=True)
        ]
        return np.minimum(found, 1.0).reshape(self.grid.shape)

    def _connected(self, standable: NDArray[np.bool_]) -> NDArray[np.bool_]:
        labels, _ = label(standable)
        rows, cols = np.nonzero(standable)
        if rows.size == 0:
            raise InputError(f"world {self.world.name!r} has no place where the robot fits")
        x_m, y_m = self.grid.centre_of(rows, cols)
        start = self.world.start
        nearest = np.hypot(x_m - start.x_m, y_m - start.y_m).argmin()
        connected: NDArray[np.bool_] = labels == labels[rows[nearest], cols[nearest]]
        return connected

    def _nearest_reachable(self, x_m: float, y_m: float) -> tuple[int, int]:
        row, col = (int(index) for index in self.grid.cell_of(x_m, y_m))
        if self.grid.contains(row, col) and self.reachable[row, col]:
            return row, col
        rows, cols = np.nonzero(self.reachable)
        nearest = ((rows - row) ** 2 + (cols - col) ** 2).argmin()
        return int(rows[nearest]), int(cols[nearest])

    @cached_property
    def _goal_cells(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        lattice = np.zeros(self.grid.shape, bool)
        lattice[::_GOAL_LATTICE, ::_GOAL_LATTICE] = True
        roomy = self.reachable & (self._room_m >= BODY_RADIUS_M + _ROOM_TO_TURN_M)
        rows, cols = np.nonzero(roomy & lattice if (roomy & lattice).any() else roomy)
        return rows, cols

    @cached_property
    def _graph(self) -> Any:
        """Steps between neighbouring reachable cells and their lengths, a sparse matrix."""
        number = np.full(self.grid.shape, -1)
        number[self.reachable] = np.arange(self.reachable_cells)
        begin, end, length = [], [], []
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            here = number[: self.grid.rows - down, max(-right, 0) : self.grid.cols - max(right, 0)]
            there = number[down:, max(right, 0) : self.grid.cols + min(right, 0)]
            both = (here >= 0) & (there >= 0)
            begin.append(here[both])
            end.append(there[both])
            length.append(np.full(both.sum(), math.hypot(down, right) * self.grid.resolution_m))
        cells = self.reachable_cells
        steps = np.concatenate(length), (np.concatenate(begin), np.concatenate(end))
        one_way = coo_array(steps, shape=(cells, cells)).tocsr()
        return one_way + one_way.T

    def _distance_from(self, row: int, col: int) -> NDArray[np.float32]:
        number = int(self.reachable.ravel()[: row * self.grid.cols + col].sum())
        distance_m = np.full(self.grid.shape, np.inf, np.float32)
        distance_m[self.reachable] = dijkstra(self._graph, indices=[number])[0]
        return distance_m


@lru_cache(maxsize=64)
def facts_of(world: World, resolution_m: float) -> RoomFacts:
    """Return the facts of a room, made once."""
    return RoomFacts(world, resolution_m)
