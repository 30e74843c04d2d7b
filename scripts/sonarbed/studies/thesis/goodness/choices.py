"""What a search says: the first bar of VSDNS, the sets that rules choose, and who ranks well."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
from sonarbed.reporting.statistics import Estimate, mean_of, rank_correlation
from sonarbed.studies.thesis.goodness.search import COLUMNS, TRUTHS, Measure, RoomSearch, values_of

__all__ = [
    "BINS",
    "Choice",
    "FirstBar",
    "choice_of",
    "choices",
    "first_bar",
    "mean_set",
    "parameters",
    "ranking",
    "tendencies",
]

BINS = 14


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


def choices(found: RoomSearch) -> list[Choice]:
    """Return the sets that the thesis's rules and the true scores call the best in a room."""
    vsdns = found.mean("vsdns")
    average = mean_set([found.sets[i] for i in first_bar(vsdns).members])
    chosen = [choice_of(found, "VSDNS, mean of the first bar", average)]
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


def choice_of(found: RoomSearch, rule: str, model: sm.ParameterizedModel) -> Choice:
    """Return what any set is worth in a searched room, also one that was not searched."""
    return _choice(found, rule, model, values_of((found.room, found.runs, (model,)))[0])


def _choice(
    found: RoomSearch, rule: str, model: sm.ParameterizedModel, values: NDArray[np.float64]
) -> Choice:
    columns = dict(zip(COLUMNS, values.T, strict=True))
    beaten_by = {
        true.name: float((found.mean(true.name) > columns[true.name].mean()).mean())
        for true in TRUTHS
    }
    return Choice(rule, model, columns, beaten_by)


def ranking(found: RoomSearch, measure: Measure, truth: Measure) -> Estimate:
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
    # No correlation lies beyond 1.
    low, high = np.clip([estimate.value - half, estimate.value + half], -1, 1).tolist()
    return replace(estimate, low=low, high=high)


def tendencies(found: RoomSearch) -> dict[str, dict[str, Estimate]]:
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
