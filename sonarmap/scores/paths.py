"""Whether a robot can use a map: paths planned in it, driven in the truth; `score_paths`."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, label
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import dijkstra

from sonarmap.errors import InputError, positive, whole
from sonarmap.occupancy import OccupancyMap
from sonarmap.scores.maps import GridTruth

__all__ = ["PathScore", "score_paths"]

_FREE = 0
# Goals for each start: one run of the planner finds the paths to all of them.
_GOALS_A_START = 5
# Ways to four of the eight neighbours; the others are these the other way round.
_STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))
_Cells = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class PathScore:
    """Paths between places that are connected in truth; scores of several maps add up.

    Parameters
    ----------
    pairs : int
        Starts and goals, connected in truth.
    planned : int
        Of these, how many the map connects.
    colliding : int
        Of the planned paths, how many meet something in truth.
    """

    pairs: int
    planned: int
    colliding: int

    def __add__(self, other: PathScore) -> PathScore:
        return PathScore(
            self.pairs + other.pairs,
            self.planned + other.planned,
            self.colliding + other.colliding,
        )

    @property
    def colliding_share(self) -> float:
        """Share of the paths planned in the map that collide in truth; NaN if none was planned."""
        return self.colliding / self.planned if self.planned else math.nan

    @property
    def missed_share(self) -> float:
        """Share of the pairs that truth connects and the map does not; NaN without pairs."""
        return 1 - self.planned / self.pairs if self.pairs else math.nan

    @property
    def usable_share(self) -> float:
        """Share of the pairs whose path was planned and does not collide; NaN without pairs."""
        return (self.planned - self.colliding) / self.pairs if self.pairs else math.nan

    def to_dict(self) -> dict[str, Any]:
        """Return counts and shares as JSON-able values; None for a share that is not defined."""
        shares = {
            name: getattr(self, name)
            for name in ("colliding_share", "missed_share", "usable_share")
        }
        return {
            **asdict(self),
            **{name: None if math.isnan(value) else value for name, value in shares.items()},
        }


def score_paths(
    m: OccupancyMap,
    truth: GridTruth,
    *,
    radius_m: float = 0.18,
    pairs: int = 50,
    seed: int = 0,
    observable: _Cells | None = None,
) -> PathScore:
    """Plan paths in a map and drive them in the truth (Collins, Collins and Ryan 2007).

    Parameters
    ----------
    m : OccupancyMap
        The map, or anything with ``.grid`` and ``.probability``, see `OccupancyMap.of`. What it
        calls free can be driven through, the rest cannot.
    truth : GridTruth
        The truth on the same grid.
    radius_m : float
        The robot's radius, metres, > 0; by default the AmigoBot's.
    pairs : int
        Starts and goals, >= 1, drawn among the cells in which the robot fits in truth; both of a
        pair in one connected part.
    seed : int
        Of what is drawn, >= 0. The same truth, radius and seed give the same pairs for every map.
    observable : ndarray of bool, shape (rows, cols), optional
        Starts and goals are drawn here only, as ``truth.observable(log)`` tells.

    Raises
    ------
    InputError
        If it is no map, the grids differ, or nowhere in the truth two places are connected.

    Notes
    -----
    Paths are shortest ones over the eight neighbours of a cell (Dijkstra). A path collides if it
    comes nearer to something than the radius less the diagonal of a cell, which is what cells can
    tell.
    """
    m = OccupancyMap.of(m)
    if m.grid != truth.grid:
        raise InputError(f"map and truth must have the same grid, got {m.grid} and {truth.grid}")
    radius_m = positive("radius_m", radius_m)
    pairs, seed = whole("pairs", pairs, least=1), whole("seed", seed, least=0)
    size = m.grid.resolution_m
    room_m = _room_m(truth.state == _FREE, size)
    starts, goals = _drawn(room_m >= radius_m, observable, pairs, np.random.default_rng(seed))
    fits = _room_m(m.free, size) >= radius_m
    collides = room_m <= max(radius_m - math.sqrt(2) * size, 0.0)
    planned = colliding = 0
    graph = _graph(fits)
    for start in np.unique(starts):
        wanted = goals[starts == start]
        if not fits.flat[start]:
            continue
        far, before = dijkstra(graph, indices=start, return_predecessors=True)
        for goal in wanted:
            if not np.isfinite(far[goal]):
                continue
            planned += 1
            colliding += bool(collides.flat[_path(before, start, goal)].any())
    return PathScore(len(starts), planned, colliding)


def _room_m(free: _Cells, size_m: float) -> NDArray[np.float64]:
    """Return how far each cell's centre is from the nearest cell that is not free, metres.

    What lies beyond the grid is not free.
    """
    framed = np.pad(free, 1)
    room: NDArray[np.float64] = (distance_transform_edt(framed) * size_m)[1:-1, 1:-1]
    return room


def _drawn(
    fits: _Cells, observable: _Cells | None, pairs: int, rng: np.random.Generator
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the numbers of the cells of starts and goals."""
    part, _ = label(fits, np.ones((3, 3)))
    part = np.where(fits if observable is None else fits & observable, part, 0).ravel()
    sizes = np.bincount(part)
    sizes[0] = 0
    cells = np.flatnonzero(sizes[part] > 1)
    if not cells.size:
        raise InputError("truth must connect two places in which the robot fits, it has none")
    starts: list[int] = []
    goals: list[int] = []
    while len(starts) < pairs:
        start = int(rng.choice(cells))
        others = cells[(part[cells] == part[start]) & (cells != start)]
        for goal in rng.choice(others, min(_GOALS_A_START, pairs - len(starts))):
            starts.append(start)
            goals.append(int(goal))
    return np.array(starts), np.array(goals)


def _graph(fits: _Cells) -> csr_array:
    """Return the ways between neighbouring cells in which the robot fits."""
    number = np.arange(fits.size).reshape(fits.shape)
    ends, lengths = [], []
    rows, cols = fits.shape
    for down, across in _STEPS:
        here = (slice(0, rows - down), slice(max(-across, 0), cols - max(across, 0)))
        there = (slice(down, rows), slice(max(across, 0), cols - max(-across, 0)))
        both = fits[here] & fits[there]
        ends.append(np.stack([number[here][both], number[there][both]]))
        lengths.append(np.full(int(both.sum()), math.hypot(down, across)))
    one, other = np.concatenate(ends, axis=1)
    length = np.concatenate(lengths)
    graph = coo_array(
        (np.tile(length, 2), (np.concatenate([one, other]), np.concatenate([other, one]))),
        shape=(fits.size, fits.size),
    ).tocsr()
    # SciPy before 1.15 takes no other indices for paths, and the array made longer ones.
    graph.indices, graph.indptr = (each.astype(np.int32) for each in (graph.indices, graph.indptr))
    return graph


def _path(before: NDArray[np.int32], start: int, goal: int) -> NDArray[np.intp]:
    """Return the cells of a path, ends included."""
    cells = [int(goal)]
    while cells[-1] != start:
        cells.append(int(before[cells[-1]]))
    return np.array(cells)
