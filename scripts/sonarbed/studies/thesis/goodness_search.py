"""The thesis's search over parameter sets, with the true scores that it could not have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import sonarmap as sm
import worlds
from sonarbed.reporting.drives import usual_drive
from sonarbed.reporting.setting import Setting
from sonarbed.reporting.statistics import Estimate, mean_of, rank_correlation

__all__ = [
    "BINS",
    "COLUMNS",
    "MEASURES",
    "RANGE_LIMIT_M",
    "ROOMS",
    "TRUTHS",
    "Choice",
    "FirstBar",
    "Measure",
    "Run",
    "Search",
    "choices",
    "first_bar",
    "judged",
    "mean_set",
    "parameters",
    "ranking",
    "search",
    "sets_of",
    "tendencies",
    "values_of",
    "within_reach",
]

ROOMS = ("thesis-exp1", "thesis-exp2", "office", "l-shape")
# "Maximum considerable sensor range was 1 meter" (p. 41).
RANGE_LIMIT_M = 1.0
CELL_M = 0.05
# 2 P3 is 3 units at most.
_LARGEST_P3_M = 0.15
BINS = 14


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
class Search:
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


@dataclass(frozen=True, eq=False)
class FirstBar:
    """The histogram of VSDNS and the sets of its lowest bin."""

    counts: NDArray[np.int64]
    edges: NDArray[np.float64]
    members: NDArray[np.int64]


@dataclass(frozen=True)
class Choice:
    """The set that a rule calls the best, and what it is worth.

    Parameters
    ----------
    rule : str
        The rule.
    model : ParameterizedModel
        The set.
    values : mapping of str to ndarray, shape (seeds,)
        Its measures and true scores.
    beaten_by : mapping of str to float
        By true score, the share of all sets that are better, 0 for the best.
    """

    rule: str
    model: sm.ParameterizedModel
    values: Mapping[str, NDArray[np.float64]]
    beaten_by: Mapping[str, float]

    def mean(self, name: str) -> Estimate:
        """Return the mean over the seeds of a measure or true score."""
        return mean_of(self.values[name])


def sets_of(*, quick: bool) -> tuple[sm.ParameterizedModel, ...]:
    """Return the thesis's 1440 sets, or about a quarter of them that span the same ranges."""
    sets = sm.goodness.thesis_parameter_sets()
    if not quick:
        return sets
    angles = sorted({model.p5_rad for model in sets})[::2]
    return tuple(m for m in sets if m.p5_rad in angles and m.p4 in (0.95, 0.98))


def search(setting: Setting) -> list[Search]:
    """Map the drives of every room by every set."""
    sets, seeds = sets_of(quick=setting.quick), setting.seeds
    drives = [(setting.in_worker(), room, seed) for room in ROOMS for seed in seeds]
    runs = setting.map(_drive, drives, f"driving in {len(ROOMS)} rooms")
    by_room = {
        room: tuple(runs[i * len(seeds) : (i + 1) * len(seeds)]) for i, room in enumerate(ROOMS)
    }
    # The sets of one half-angle share the cells of their cones: they belong into one task.
    groups = [
        tuple(m for m in sets if m.p5_rad == angle)
        for angle in dict.fromkeys(m.p5_rad for m in sets)
    ]
    tasks = [(room, by_room[room], group) for room in ROOMS for group in groups]
    parts = setting.map(values_of, tasks, f"searching {len(sets)} sets in {len(ROOMS)} rooms")
    searches = []
    for index, room in enumerate(ROOMS):
        values = np.concatenate(parts[index * len(groups) : (index + 1) * len(groups)])
        columns = {name: values[..., i] for i, name in enumerate(COLUMNS)}
        searches.append(Search(room, tuple(m for g in groups for m in g), columns, by_room[room]))
    return searches


def _drive(task: tuple[Setting, str, int]) -> Run:
    log, truth, observable = usual_drive(*task, resolution_m=CELL_M)
    scored = observable & within_reach(log, truth.grid, RANGE_LIMIT_M + _LARGEST_P3_M)
    return Run(log.replace(truth=None), scored)


def within_reach(log: sm.SonarLog, grid: sm.GridSpec, reach_m: float) -> NDArray[np.bool_]:
    """Return which cells have a sonar's true place within a distance of their centres.

    Beyond the reach of every set there is nothing to tell the sets apart: such cells would only
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


def first_bar(vsdns: NDArray[np.float64], bins: int = BINS) -> FirstBar:
    """Return the histogram of VSDNS, and the sets of its lowest bin with the lowest first."""
    counts, edges = np.histogram(vsdns, bins=bins)
    order = np.argsort(vsdns, kind="stable")
    return FirstBar(counts, edges, order[: counts[0]])


def mean_set(sets: Sequence[sm.ParameterizedModel]) -> sm.ParameterizedModel:
    """Return the mean of each parameter, P1 = 1 - P4 as in all sets (table 5.1, column 4)."""
    p4 = float(np.mean([m.p4 for m in sets]))
    return sm.ParameterizedModel(
        p1=1 - p4,
        p2=float(np.mean([m.p2 for m in sets])),
        p3_m=float(np.mean([m.p3_m for m in sets])),
        p4=p4,
        p5_rad=float(np.mean([m.p5_rad for m in sets])),
    )


def parameters(model: sm.ParameterizedModel) -> tuple[float, float, float, float, float]:
    """Return P1, P2, 2 P3 in units of 0.1 m, P4 and P5 in degrees, as the thesis prints them."""
    return model.p1, model.p2, 2 * model.p3_m / 0.1, model.p4, math.degrees(model.p5_rad)


def choices(found: Search) -> list[Choice]:
    """Return the sets that the thesis's rules and the true scores call the best in a room."""
    vsdns = found.mean("vsdns")
    average = mean_set([found.sets[i] for i in first_bar(vsdns).members])
    chosen = [judged(found, "VSDNS, mean of the first bar", average)]
    for rule, index in (
        ("VSDNS, lowest", np.argmin(vsdns)),
        ("VSDNS, nearest to the mean", np.argmin(np.abs(vsdns - vsdns.mean()))),
        ("derivative, lowest", np.argmin(found.mean("derivative"))),
        ("two runs, positive less negative", np.argmax(found.mean("surplus"))),
        ("true Map Score", np.argmax(found.mean("map_score"))),
        ("true F1 at 10 cm", np.argmax(found.mean("f1"))),
    ):
        values = np.stack([found.values[name][index] for name in COLUMNS], axis=-1)
        chosen.append(_choice(found, rule, found.sets[index], values))
    return chosen


def judged(found: Search, rule: str, model: sm.ParameterizedModel) -> Choice:
    """Return what any set is worth in a searched room, also one that was not searched."""
    return _choice(found, rule, model, values_of((found.room, found.runs, (model,)))[0])


def _choice(
    found: Search, rule: str, model: sm.ParameterizedModel, values: NDArray[np.float64]
) -> Choice:
    columns = dict(zip(COLUMNS, values.T, strict=True))
    beaten_by = {
        true.name: float((found.mean(true.name) > columns[true.name].mean()).mean())
        for true in TRUTHS
    }
    return Choice(rule, model, columns, beaten_by)


def ranking(found: Search, measure: Measure, truth: Measure) -> Estimate:
    """Return the rank correlation over the sets of a measure with a true score, over the seeds.

    It is 1 for a measure that ranks the sets as the truth does, -1 for one that ranks them the
    other way round.
    """
    of_seed = [
        rank_correlation(measure.good * a, truth.good * b)
        for a, b in zip(found.values[measure.name].T, found.values[truth.name].T, strict=True)
    ]
    estimate = mean_of(of_seed)
    if measure.runs == 1:
        return estimate
    # Neighbouring pairs of seeds share a run. Values that share one of two independent runs
    # correlate with 0.5 at most, each with two others: that at most doubles the mean's variance.
    half = math.sqrt(2) * (estimate.high - estimate.value)
    low, high = estimate.value - half, estimate.value + half
    # No correlation lies beyond 1.
    return Estimate(estimate.value, *np.clip([low, high], -1, 1).tolist())


def tendencies(found: Search) -> dict[str, dict[str, Estimate]]:
    """Return the rank correlation of each parameter with each column, over the seeds."""
    of_set = dict(
        zip(("P1", "P2", "P3", "P4", "P5"), np.array([*map(parameters, found.sets)]).T, strict=True)
    )
    return {
        name: {
            column: mean_of([rank_correlation(values, of_seed) for of_seed in table.T])
            for column, table in found.values.items()
        }
        for name, values in of_set.items()
    }
