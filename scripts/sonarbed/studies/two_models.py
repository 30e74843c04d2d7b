"""Figure 5.8 and question 5: the standard and the parameterised model with the same parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import sonarmap as sm
import worlds
from sonarbed.studies.drives import usual_drive
from sonarbed.studies.section import Answer, Item, Section
from sonarbed.studies.setting import Setting
from sonarbed.studies.statistics import Estimate, mean_of
from sonarbed.studies.two_models_figures import Example, draw_differences, draw_maps
from sonarmap.models import probability
from sonarmap.scores import CLAMP

__all__ = [
    "PAIRS",
    "SCORES",
    "Judged",
    "Pair",
    "Score",
    "contradictions",
    "judge",
    "run",
    "verdicts",
]

_EXAMPLE_ROOM = "thesis-exp1"
# Free cells this near to a wall, P3 and the width of a cell, are what a thick arc reaches.
_NEAR_WALL_M = 0.15
# The parts of the Map Score in `Judged`.
_PARTS = {
    "bits_wall": "wall cells",
    "bits_near": f"free cells within {_NEAR_WALL_M:g} m of a wall",
    "bits_open": "other free cells",
}


@dataclass(frozen=True)
class Pair:
    """The two models with the same parameters."""

    tolerance_m: float
    standard: sm.StandardModel
    parameterized: sm.ParameterizedModel

    @classmethod
    def of(cls, tolerance_m: float) -> Pair:
        """Return the setting of figure 5.8 with another tolerance (P3)."""
        return cls(
            tolerance_m,
            replace(sm.StandardModel.thesis(), tolerance_m=tolerance_m),
            replace(sm.ParameterizedModel.thesis(), p3_m=tolerance_m),
        )


# Figure 5.8's own tolerance, and the smallest of the thesis's search (2 P3 = 0.5 units).
PAIRS = (Pair.of(sm.StandardModel.thesis().tolerance_m), Pair.of(0.025))


@dataclass(frozen=True, slots=True)
class Score:
    """A score of maps: its name in `Judged`, what people call it, and whether more is better."""

    name: str
    title: str
    unit: str
    better: int


SCORES = (
    Score("map_score", "Map Score", "bit", 1),
    Score("brier", "Brier score", "", -1),
    Score("correlation", "correlation", "", 1),
    Score("f1", "F1 at 10 cm", "", 1),
)


@dataclass(frozen=True, slots=True)
class Judged:
    """What the truth says of a map, over observable cells.

    Parameters
    ----------
    map_score, brier, correlation, f1 : float
        As `sonarmap.MapScore` has them, F1 at 10 cm.
    phantom_m2, false_free_m2 : float
        Free area mapped as occupied, occupied area mapped as free.
    bits_wall, bits_near, bits_open : float
        Parts of the Map Score, bits per scored cell, that add up to it: of occupied cells, of
        free cells within 0.15 m of a wall, and of the other free cells.
    """

    map_score: float
    brier: float
    correlation: float
    f1: float
    phantom_m2: float
    false_free_m2: float
    bits_wall: float
    bits_near: float
    bits_open: float


# Seed by seed, pair by pair: the standard and the parameterised model's map.
Judgements = Sequence[Sequence[tuple[Judged, Judged]]]


def run(setting: Setting) -> Section:
    """Map every room with both models, and let the truth compare them."""
    rooms = worlds.names()
    tasks = [(setting.in_worker(), room, seed) for room in rooms for seed in setting.seeds]
    results = setting.map(_judge_drive, tasks, "mapping every room with two models")
    n = len(setting.seeds)
    found = {room: results[i * n : (i + 1) * n] for i, room in enumerate(rooms)}
    return Section(
        "two_models",
        "The two sensor models compared (figure 5.8)",
        (_maps(setting, found), _rooms(setting, found), _why(setting, found)),
        (_answer(found),),
    )


def judge(m: sm.OccupancyMap, truth: worlds.TruthGrid, observable: NDArray[np.bool_]) -> Judged:
    """Return what the truth says of a map."""
    score = sm.score_map(m, truth, observable=observable)
    wall = truth.state == worlds.OCCUPIED
    away_m = distance_transform_edt(~wall) * truth.grid.resolution_m
    p = m.probability.clip(CLAMP, 1 - CLAMP)
    bits = np.where(observable, 1 + np.log2(np.where(wall, p, 1 - p)), 0)
    near = ~wall & (away_m <= _NEAR_WALL_M + 1e-9)
    parts = (float(bits[cells].sum()) / score.cells for cells in (wall, near, ~wall & ~near))
    return Judged(
        score.map_score,
        score.brier,
        score.correlation,
        score.f1(1),
        score.phantom_m2,
        score.false_free_m2,
        *parts,
    )


def _judge_drive(task: tuple[Setting, str, int]) -> list[tuple[Judged, Judged]]:
    log, truth, observable = usual_drive(*task)
    return [
        (
            judge(sm.build_map(log, pair.standard, truth.grid), truth, observable),
            judge(sm.build_map(log, pair.parameterized, truth.grid), truth, observable),
        )
        for pair in PAIRS
    ]


def differences(judged: Judgements, pair: int, name: str) -> Estimate:
    """Return parameterised less standard of a score, paired by seed."""
    return mean_of(
        [getattr(drive[pair][1], name) - getattr(drive[pair][0], name) for drive in judged]
    )


def mean(judged: Judgements, pair: int, model: int, name: str) -> Estimate:
    """Return the mean of a score over the seeds; model 0 is the standard one."""
    return mean_of([getattr(drive[pair][model], name) for drive in judged])


def verdicts(by_room: Mapping[str, Estimate], better: int, digits: int = 3) -> str:
    """Return in which rooms a difference is better, worse or undecided, as a clause.

    `better` is 1 if a positive difference is the better one, else -1.
    """
    clauses = []
    for word, wanted in (("better", 1), ("worse", -1), ("undecided", 0)):
        rooms = [
            f"{room} {estimate.value:+.{digits}f}"
            for room, estimate in by_room.items()
            if estimate.sign * better == wanted
        ]
        if rooms:
            clauses.append(f"{word} in {len(rooms)} of {len(by_room)} ({', '.join(rooms)})")
    return ", ".join(clauses)


def _maps(setting: Setting, found: Mapping[str, Judgements]) -> Item:
    log, truth, observable = usual_drive(setting.in_worker(), _EXAMPLE_ROOM, setting.seeds[0])
    examples = []
    for pair in PAIRS:
        for name, model in (("standard", pair.standard), ("parameterised", pair.parameterized)):
            built = sm.build_map(log, model, truth.grid)
            score = sm.score_map(built, truth, observable=observable)
            title = (
                f"{name}, P3 = {pair.tolerance_m:g} m\n"
                f"{score.map_score:.2f} bit, r = {score.correlation:.2f}, F1 = {score.f1(1):.2f}"
            )
            examples.append(Example(title, built))
    figure = draw_maps(truth, observable, examples)
    judged = found[_EXAMPLE_ROOM]
    told = []
    for score_ in SCORES:
        difference = differences(judged, 0, score_.name)
        word = {1: "better", -1: "worse", 0: "undecided"}[difference.sign * score_.better]
        told.append(f"{word} by {score_.title} ({difference.text(3, score_.unit)})")
    return Item(
        "Figure 5.8",
        "Maps of one room by the standard model (beta 15 degrees, tolerance 1 unit, maximum 0.98) "
        "and by the parameterised model (0.02, 0.15, 1 unit, 0.98, 15 degrees): the second is "
        "said to be better.",
        f"In {_EXAMPLE_ROOM} the parameterised model is {', '.join(told)}: the paired difference "
        "to the standard model, with its interval over the seeds.",
        (
            setting.figure(
                "maps",
                figure,
                f"{_EXAMPLE_ROOM}, seed {setting.seeds[0]}: the truth (light: not observable) and "
                "the maps of both models, above with the tolerance of figure 5.8, below with "
                "0.025 m",
            ),
        ),
    )


def _rooms(setting: Setting, found: Mapping[str, Judgements]) -> Item:
    tables = []
    for index, pair in enumerate(PAIRS):
        rows = []
        for room, judged in found.items():
            for score in SCORES:
                difference = differences(judged, index, score.name)
                rows.append(
                    (
                        room,
                        f"{score.title}, {score.unit}".rstrip(", "),
                        mean(judged, index, 0, score.name).text(),
                        mean(judged, index, 1, score.name).text(),
                        difference.text(),
                        {1: "better", -1: "worse", 0: "undecided"}[difference.sign * score.better],
                    )
                )
        tables.append(
            setting.table(
                f"rooms-{pair.tolerance_m * 1000:.0f}-mm",
                ("room", "score", "standard", "parameterised", "difference", "parameterised is"),
                rows,
                f"Both models in every room, tolerance P3 = {pair.tolerance_m:g} m, observable "
                "cells; differences are paired by seed",
            )
        )
    by_score = {
        score.title: [
            {room: differences(judged, index, score.name) for room, judged in found.items()}
            for index in range(len(PAIRS))
        ]
        for score in SCORES
    }
    figure = draw_differences(
        [(f"{s.title}, {s.unit}".rstrip(", "), s.better) for s in SCORES],
        list(by_score.values()),
        [f"P3 = {pair.tolerance_m:g} m" for pair in PAIRS],
    )
    counts, finer = (
        [
            f"{sum(e.sign == score.better for e in by_score[score.title][index].values())} by "
            f"{score.title}"
            for score in SCORES
        ]
        for index in range(len(PAIRS))
    )
    return Item(
        "Figure 5.8 in every room",
        "The proposed model gives better results than the standard one with the same parameters, "
        "whether they are optimal or not.",
        f"With the parameters of figure 5.8 the parameterised model is better in {len(found)} "
        f"rooms so often: {', '.join(counts)}; with P3 = {PAIRS[1].tolerance_m:g} m, {', '.join(finer)}.",
        (
            setting.figure(
                "differences",
                figure,
                "Parameterised less standard model, mean over the seeds with 95 % intervals; the "
                "axis of the Brier score is turned, so that right is better everywhere",
            ),
        ),
        tuple(tables),
    )


def _why(setting: Setting, found: Mapping[str, Judgements]) -> Item:
    parts = [
        {
            title: {room: differences(judged, index, name) for room, judged in found.items()}
            for name, title in _PARTS.items()
        }
        for index in range(len(PAIRS))
    ]
    rows = []
    for room, judged in found.items():
        for index, pair in enumerate(PAIRS):
            areas = [
                mean(judged, index, model, name).text(2)
                for name in ("phantom_m2", "false_free_m2")
                for model in (0, 1)
            ]
            bits = [by_room[room].text() for by_room in parts[index].values()]
            rows.append((room, f"{pair.tolerance_m:g}", *areas, *bits))
    table = setting.table(
        "areas",
        (
            "room",
            "P3, m",
            "phantom, standard, m²",
            "phantom, parameterised, m²",
            "false-free, standard, m²",
            "false-free, parameterised, m²",
            *(f"bits, {title}" for title in _PARTS.values()),
        ),
        rows,
        "Area mapped wrongly, and where the difference of the Map Score comes from: parameterised "
        "less standard, bits per observable cell, the three add up",
    )
    figure = setting.figure(
        "parts",
        draw_differences(
            [(f"Map Score, bit, P3 = {pair.tolerance_m:g} m", 1) for pair in PAIRS],
            [list(by_title.values()) for by_title in parts],
            list(_PARTS.values()),
        ),
        "Where the difference of the Map Score (parameterised less standard) comes from: three "
        "kinds of cells that add up to it, with 95 % intervals",
    )
    told = [f"on {title} it is {verdicts(by_room, 1, 2)}" for title, by_room in parts[0].items()]
    return Item(
        "Why one model wins: three kinds of cells",
        "The proposed model has no spikes that say the opposite of what they should; the thesis "
        "gives no number.",
        f"{_of_the_models()} The Map Score's difference with P3 = {PAIRS[0].tolerance_m:g} m, in "
        f"bits per observable cell: {'; '.join(told)}. {_example_areas(found[_EXAMPLE_ROOM])}",
        (figure,),
        (table,),
    )


def _of_the_models() -> str:
    """Return what the models themselves say before their hills and in them, in numbers."""
    pair, told = PAIRS[0], []
    for reading_m in (1.0, 2.0):
        (standard_before, standard_hill), (ours_before, ours_hill) = (
            contradictions(model, reading_m, pair.tolerance_m)
            for model in (pair.standard, pair.parameterized)
        )
        told.append(
            f"of a reading of {reading_m:g} m the standard model calls {standard_before:.0%} of "
            f"the cone before its hill rather occupied and {standard_hill:.0%} of the hill rather "
            f"free (parameterised: {ours_before:.0%} and {ours_hill:.0%})"
        )
    return f"By the equations alone, {'; '.join(told)}."


def contradictions(
    model: sm.SensorModel, reading_m: float, tolerance_m: float
) -> tuple[float, float]:
    """Return the share of a cone's area before its hill above 0.5, and of the hill below 0.5."""
    range_m, bearing = np.meshgrid(
        np.linspace(0.0005, reading_m + tolerance_m, 801),
        np.linspace(-model.half_angle_rad, model.half_angle_rad, 401),
    )
    p = probability(model, range_m, bearing, reading_m)
    hill = range_m >= reading_m - tolerance_m
    # A ring of the cone has an area that grows with its range.
    before = float((range_m * (p > 0.5 + 1e-9))[~hill].sum() / range_m[~hill].sum())
    return before, float((range_m * (p < 0.5 - 1e-9))[hill].sum() / range_m[hill].sum())


def _example_areas(judged: Judgements) -> str:
    told = []
    for index, pair in enumerate(PAIRS):
        phantom, missed = (
            [mean(judged, index, model, name).value for model in (0, 1)]
            for name in ("phantom_m2", "false_free_m2")
        )
        whole = differences(judged, index, "map_score")
        told.append(
            f"with P3 = {pair.tolerance_m:g} m a phantom area of {phantom[1]:.2f} against "
            f"{phantom[0]:.2f} m², walls mapped as free {missed[1]:.2f} against {missed[0]:.2f} m², "
            f"Map Score {whole.text(2, 'bit')}"
        )
    return f"{_EXAMPLE_ROOM}, parameterised against standard: {'; '.join(told)}."


def _answer(found: Mapping[str, Judgements]) -> Answer:
    by_score = [
        {
            score: {room: differences(judged, index, score.name) for room, judged in found.items()}
            for score in SCORES
        }
        for index in range(len(PAIRS))
    ]
    everywhere = [
        score.title
        for score, by_room in by_score[0].items()
        if all(estimate.sign == score.better for estimate in by_room.values())
    ]
    lead = (
        f"Better in every room by {' and '.join(everywhere)}"
        if everywhere
        else "Not in every room by any of the four scores"
    )
    told = [
        f"by {score.title} {verdicts(by_room, score.better, 2)}"
        for score, by_room in by_score[0].items()
    ]
    finer = [
        f"{sum(e.sign == score.better for e in by_room.values())} by {score.title}"
        for score, by_room in by_score[1].items()
    ]
    return Answer(
        5,
        f"{lead}. With the parameters of figure 5.8 (P3 = {PAIRS[0].tolerance_m:g} m) the "
        f"parameterised model is, {'; '.join(told)} (differences to the standard model). With "
        f"P3 = {PAIRS[1].tolerance_m:g} m for both it is better in so many of {len(found)} rooms: "
        f"{', '.join(finer)}.",
    )
