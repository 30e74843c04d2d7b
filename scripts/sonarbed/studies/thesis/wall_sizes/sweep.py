"""What a sweep over wall sizes measures of each pair: maps, data points, openings, readings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import sonarmap as sm
import worlds
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.thesis.experiments import Experiment, Opening, WallPair
from sonarbed.studies.thesis.free_space import NEAR_M, FreeSpace, plotted_points, score_points
from sonarmap.methods.bayes.updating import NoEcho
from sonarmap.occupancy import FREE_UP_TO, OCCUPIED_FROM

__all__ = ["MODEL", "POLICIES", "Room", "Sweep", "SweepTask", "opening_shares", "swept"]

MODEL = sm.ParameterizedModel.thesis()
POLICIES: tuple[NoEcho, ...] = ("ignore", "clear")


@dataclass(frozen=True)
class Room:
    """A room as the maps of a drive see it.

    Parameters
    ----------
    world : World
        The room.
    truth : TruthGrid
        Its cells of 5 cm.
    space : FreeSpace
        Its free space.
    observable : ndarray of bool
        Cells that the drive could have observed.
    """

    world: worlds.World
    truth: worlds.TruthGrid
    space: FreeSpace
    observable: NDArray[np.bool_]

    @classmethod
    def of(cls, name: str, log: sm.SonarLog) -> Room:
        """Return the room called `name` as a drive in it could see it."""
        world = worlds.load(name)
        truth = worlds.truth(world)
        return cls(world, truth, FreeSpace.of(world), truth.observable(log))

    @property
    def surface_cells_m(self) -> NDArray[np.float64]:
        """Centres of the observable occupied cells, metres, shape (n, 2)."""
        row, col = np.nonzero(self.observable & (self.truth.state == worlds.OCCUPIED))
        return np.column_stack(self.truth.grid.centre_of(row, col))

    def map_of(self, log: sm.SonarLog, no_echo: NoEcho) -> sm.OccupancyMap:
        """Return the map of a log of this drive."""
        return sm.build_map(log, MODEL, self.truth.grid, no_echo=no_echo)


@dataclass(frozen=True)
class SweepTask:
    """The work of one drive: all pairs of an experiment."""

    experiment: Experiment
    log: sm.SonarLog
    pairs: tuple[WallPair, ...]


@dataclass(frozen=True)
class Sweep:
    """What the drives of an experiment measured.

    Parameters
    ----------
    pairs : tuple of Pair
        The pairs tried.
    before : mapping of str to ndarray, shape (drives,)
        Each measure without HSR.
    after : mapping of str to ndarray, shape (drives, pairs)
        Each measure after HSR.
    """

    pairs: tuple[WallPair, ...]
    before: Mapping[str, NDArray[np.float64]]
    after: Mapping[str, NDArray[np.float64]]

    @classmethod
    def of(
        cls,
        pairs: tuple[WallPair, ...],
        drives: list[tuple[dict[str, float], list[dict[str, float]]]],
    ) -> Sweep:
        """Return the sweep of drives as `swept` returns them."""
        names = drives[0][0]
        return cls(
            pairs,
            {name: np.array([before[name] for before, _ in drives]) for name in names},
            {
                name: np.array([[pair[name] for pair in after] for _, after in drives])
                for name in names
            },
        )

    def changes(self, measure: str) -> list[Estimate]:
        """Return the mean change of a measure by HSR, one estimate a pair."""
        change = self.after[measure] - self.before[measure][:, None]
        return [mean_of(column) for column in change.T]

    def change(self, measure: str, pair: WallPair) -> Estimate:
        """Return the mean change of a measure by HSR with one pair."""
        index = self.pairs.index(pair)
        return mean_of(self.after[measure][:, index] - self.before[measure])

    def mean_over(self, measure: str, chosen: NDArray[np.bool_]) -> Estimate:
        """Return the mean of a measure over the chosen pairs, with the interval over drives."""
        return mean_of(self.after[measure][:, chosen].mean(axis=1))

    def best(self, measure: str) -> int:
        """Return the index of the pair with the highest mean of a measure."""
        return int(np.nanargmax(self.after[measure].mean(axis=0)))

    def as_good_as_best(self, measure: str) -> NDArray[np.bool_]:
        """Return the pairs whose difference from the best one the drives do not decide."""
        values = self.after[measure]
        less = values - values[:, [self.best(measure)]]
        return np.array([mean_of(column).sign >= 0 for column in less.T])


def swept(task: SweepTask) -> tuple[dict[str, float], list[dict[str, float]]]:
    """Return the measures of one drive without HSR, and after HSR with each pair."""
    room = Room.of(task.experiment.room, task.log)
    before = _measures(task.experiment, room, task.log, task.log)
    after = []
    for pair in task.pairs:
        repaired = sm.hsr(task.log, task.experiment.params(pair, task.log.ring)).log
        after.append(_measures(task.experiment, room, task.log, repaired))
    return before, after


def opening_shares(
    probability: NDArray[np.float64], grid: sm.GridSpec, opening: Opening
) -> tuple[float, float, float]:
    """Return the shares of an opening's cells mapped free and occupied, and its gap in metres.

    The gap is the widest run of the opening's width without an occupied cell in its depth.
    """
    x_min, y_min, x_max, y_max = opening.box_m
    x_m, _ = grid.centre_of(0, np.arange(grid.cols))
    _, y_m = grid.centre_of(np.arange(grid.rows), 0)
    rows, cols = (y_m > y_min) & (y_m < y_max), (x_m > x_min) & (x_m < x_max)
    p = probability[np.ix_(rows, cols)]
    occupied = p >= OCCUPIED_FROM
    blocked = occupied.any(axis=0 if opening.runs_along_x else 1)
    # Lengths of the runs between blocked places, the ends included.
    borders = np.flatnonzero(np.concatenate([[True], blocked, [True]]))
    widest = int(np.diff(borders).max()) - 1
    return float((p <= FREE_UP_TO).mean()), float(occupied.mean()), widest * grid.resolution_m


def _measures(
    experiment: Experiment, room: Room, log: sm.SonarLog, repaired: sm.SonarLog
) -> dict[str, float]:
    measures: dict[str, float] = {}
    for policy in POLICIES:
        built = room.map_of(repaired, policy)
        score = sm.score_map(built, room.truth, observable=room.observable)
        measures |= {
            f"skill {policy}": score.skill,
            f"map_score {policy}": score.map_score,
            f"f1 {policy}": score.f1(1),
            f"brier {policy}": score.brier,
            f"phantom_m2 {policy}": score.phantom_m2,
            f"false_free_m2 {policy}": score.false_free_m2,
        }
        for opening in experiment.openings:
            free, occupied, gap_m = opening_shares(built.probability, built.grid, opening)
            measures |= {
                f"{opening.name} free {policy}": free,
                f"{opening.name} occupied {policy}": occupied,
                f"{opening.name} gap_m {policy}": gap_m,
            }
        if experiment.glass is not None:
            measures[f"glass {policy}"] = _recall(built.probability, room, experiment.glass)
    shares = score_points(plotted_points(repaired), room.space, room.surface_cells_m)
    readings = sm.score_readings(log, repaired)
    return measures | {
        "points near": shares.near,
        "points beyond": shares.beyond,
        "points shown": shares.shown,
        "points f1": shares.f1,
        "mended": readings.mended_share,
        "spoiled": readings.spoiled_share,
    }


def _recall(probability: NDArray[np.float64], room: Room, name: str) -> float:
    """Return the share of a wall's observable cells with an occupied cell of the map near."""
    outline = next(solid.outline for solid in room.world.solids if solid.name == name)
    x_min, y_min, x_max, y_max = outline.bounds
    x_m, y_m = room.truth.grid.centre_of(*np.indices(room.truth.grid.shape))
    wanted = room.observable & (room.truth.state == worlds.OCCUPIED)
    wanted &= (x_m > x_min) & (x_m < x_max) & (y_m > y_min) & (y_m < y_max)
    occupied = probability >= OCCUPIED_FROM
    if not occupied.any():
        return 0.0
    away_m = distance_transform_edt(~occupied) * room.truth.grid.resolution_m
    # The slack forgives the rounding of a distance that equals the tolerance.
    return float((away_m[wanted] <= NEAR_M + 1e-9).mean())
