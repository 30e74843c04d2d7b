"""The thesis's search over parameter sets, with the true scores that it could not have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import sonarmap as sm
import worlds
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drives import DriveSpec, DriveStore
from sonarbed.reporting.parallel import in_parts

__all__ = [
    "CELL_M",
    "COLUMNS",
    "MEASURES",
    "RANGE_LIMIT_M",
    "ROOMS",
    "TRUTHS",
    "Measure",
    "RoomSearch",
    "Run",
    "search",
    "sets_of",
    "values_of",
    "within_reach",
]

ROOMS = ("thesis-exp1", "thesis-exp2", "office", "l-shape")
# "Maximum considerable sensor range was 1 meter" (p. 41).
RANGE_LIMIT_M = 1.0
CELL_M = 0.05
# 2 P3 is 3 units at most.
_LARGEST_P3_M = 0.15


@dataclass(frozen=True, slots=True)
class Measure:
    """A measure of maps.

    Parameters
    ----------
    name : str
        Its column in the results of a search.
    title : str
        For people.
    good : int
        1 if a higher value is to be the better map, -1 if a lower one.
    runs : int
        From how many runs it is computed.
    """

    name: str
    title: str
    good: int
    runs: int = 1


MEASURES = (
    Measure("vsdns", "VSDNS", -1),
    Measure("derivative", "derivative", -1),
    Measure("agreement", "two runs, share that agrees", 1, 2),
    Measure("surplus", "two runs, positive less negative", 1, 2),
)
TRUTHS = (Measure("map_score", "Map Score", 1), Measure("f1", "F1 at 10 cm", 1))
COLUMNS = tuple(measure.name for measure in (*MEASURES, *TRUTHS))


@dataclass(frozen=True, eq=False)
class Run:
    """A drive: its log (without the truth, which mapping does not need) and the cells to score."""

    log: sm.SonarLog
    scored: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class RoomSearch:
    """The measures and true scores of every parameter set in a room.

    Parameters
    ----------
    room : str
        The room.
    sets : tuple of ParameterizedModel
        The parameter sets.
    values : mapping of str to ndarray, shape (sets, seeds)
        By the names of `COLUMNS`. Those of two runs are of a seed and the next one.
    runs : tuple of Run
        The drives, one a seed.
    """

    room: str
    sets: tuple[sm.ParameterizedModel, ...]
    values: Mapping[str, NDArray[np.float64]]
    runs: tuple[Run, ...] = ()

    def mean(self, name: str) -> NDArray[np.float64]:
        """Return the mean over the seeds of a column, one a set."""
        mean: NDArray[np.float64] = self.values[name].mean(axis=1)
        return mean


def sets_of(*, quick: bool) -> tuple[sm.ParameterizedModel, ...]:
    """Return the thesis's 1440 sets, or about a quarter of them that span the same ranges."""
    sets = sm.goodness.thesis_parameter_sets()
    if not quick:
        return sets
    angles = sorted({model.p5_rad for model in sets})[::2]
    return tuple(m for m in sets if m.p5_rad in angles and m.p4 in (0.95, 0.98))


def search(context: StudyContext) -> list[RoomSearch]:
    """Map the drives of every room by every set."""
    sets, runs = sets_of(quick=context.quick), _runs(context)
    # The sets of one half-angle share the cells of their cones: they belong into one task.
    groups = [
        tuple(m for m in sets if m.p5_rad == angle)
        for angle in dict.fromkeys(m.p5_rad for m in sets)
    ]
    tasks = [(room, runs[room], group) for room in ROOMS for group in groups]
    values = context.map(values_of, tasks, f"searching {len(sets)} sets in {len(ROOMS)} rooms")
    searched = tuple(m for group in groups for m in group)
    return [
        RoomSearch(room, searched, _columns(np.concatenate(of_room)), runs[room])
        for room, of_room in in_parts(values, ROOMS).items()
    ]


def _runs(context: StudyContext) -> dict[str, tuple[Run, ...]]:
    """Return the drives of every room, one a seed."""
    specs = [spec for room in ROOMS for spec in context.specs(room)]
    context.simulate_missing(specs, f"driving in {len(ROOMS)} rooms")
    tasks = [(context.drives, spec) for spec in specs]
    runs = context.map(_run_of, tasks, "looking for the cells to score")
    return {room: tuple(of_room) for room, of_room in in_parts(runs, ROOMS).items()}


def _columns(values: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    return {name: values[..., index] for index, name in enumerate(COLUMNS)}


def _run_of(task: tuple[DriveStore, DriveSpec]) -> Run:
    store, spec = task
    drive = store.scorable(spec, resolution_m=CELL_M)
    reach_m = RANGE_LIMIT_M + _LARGEST_P3_M
    scored = drive.observable & within_reach(drive.log, drive.truth.grid, reach_m)
    return Run(drive.log.replace(truth=None), scored)


def within_reach(log: sm.SonarLog, grid: sm.GridSpec, reach_m: float) -> NDArray[np.bool_]:
    """Return which cells have a sonar's true place within a distance of their centres.

    Beyond the reach of every set nothing distinguishes the sets: such cells would only
    dilute the scores.
    """
    there = np.ones(grid.shape, bool)
    there[grid.cell_of(*log.at_true_poses().sensor_xy_m.T)] = False
    near: NDArray[np.bool_] = distance_transform_edt(there) * grid.resolution_m <= reach_m + 1e-9
    return near


def values_of(
    task: tuple[str, tuple[Run, ...], tuple[sm.ParameterizedModel, ...]],
) -> NDArray[np.float64]:
    """Return the `COLUMNS` of every set and run of a room, shape (sets, runs, columns)."""
    room, runs, sets = task
    truth = worlds.truth(worlds.load(room), resolution_m=CELL_M)
    walks = [
        sm.goodness.map_and_spread(run.log, sets, truth.grid, max_range_m=RANGE_LIMIT_M)
        for run in runs
    ]
    values = np.full((len(sets), len(runs), len(COLUMNS)), math.nan)
    for row, made in enumerate(zip(*walks, strict=True)):
        for seed, (built, spread) in enumerate(made):
            agreement = surplus = math.nan
            if len(runs) > 1:
                # The last seed's other run is the first one.
                both = sm.goodness.compare_runs(built, made[(seed + 1) % len(runs)][0])
                agreement, surplus = both.agreement, both.positive - both.negative
            score = sm.score_map(built, truth, observable=runs[seed].scored)
            values[row, seed] = (
                spread.vsdns,
                sm.goodness.map_derivative(built, updated=spread.updated),
                agreement,
                surplus,
                score.map_score,
                score.f1(1),
            )
    return values
