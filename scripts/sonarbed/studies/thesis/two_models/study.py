"""Figure 5.8 and question 5: the standard and the parameterized model with the same parameters."""

from __future__ import annotations

from collections.abc import Mapping

import sonarmap as sm
import worlds
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.parallel import in_parts
from sonarbed.reporting.section import Item
from sonarbed.reporting.wording import verdicts, word
from sonarbed.studies.thesis.contradictions import contradictions
from sonarbed.studies.thesis.plans import TitledMap
from sonarbed.studies.thesis.questions import Answer, ThesisSection
from sonarbed.studies.thesis.two_models.comparison import (
    PAIRS,
    PARTS,
    SCORES,
    ScoredPairs,
    differences,
    mean,
    score_drive,
)
from sonarbed.studies.thesis.two_models.figures import draw_differences, draw_maps

__all__ = ["run"]

_EXAMPLE_ROOM = "thesis-exp1"


def run(context: StudyContext) -> ThesisSection:
    """Map every room with both models, and let the truth compare them."""
    rooms = _rooms_compared()
    specs = [spec for room in rooms for spec in context.specs(room)]
    context.simulate_missing(specs, "driving in every room")
    tasks = [(context.drives, spec) for spec in specs]
    results = context.map(score_drive, tasks, "mapping every room with two models")
    found = in_parts(results, rooms)
    return ThesisSection(
        "two_models",
        "The two sensor models compared (figure 5.8)",
        (_maps(context, found), _rooms(context, found), _why(context, found)),
        (_answer(found),),
    )


def _rooms_compared() -> tuple[str, ...]:
    return tuple(worlds.names())


def _maps(context: StudyContext, found: Mapping[str, ScoredPairs]) -> Item:
    (spec,) = context.specs(_EXAMPLE_ROOM, seeds=context.seeds[:1])
    context.simulate_missing([spec])
    drive = context.drives.scorable(spec)
    examples = []
    for pair in PAIRS:
        for name, model in (("standard", pair.standard), ("parameterized", pair.parameterized)):
            built = sm.build_map(drive.log, model, drive.truth.grid)
            score = sm.score_map(built, drive.truth, observable=drive.observable)
            title = (
                f"{name}, P3 = {pair.tolerance_m:g} m\n"
                f"{score.map_score:.2f} bit, r = {score.correlation:.2f}, F1 = {score.f1(1):.2f}"
            )
            examples.append(TitledMap(title, built))
    figure = draw_maps(drive.truth, drive.observable, examples)
    scored = found[_EXAMPLE_ROOM]
    clauses = []
    for score_ in SCORES:
        difference = differences(scored, 0, score_.name)
        clauses.append(
            f"{word(difference, score_.better)} by {score_.title} "
            f"({difference.text(3, score_.unit)})"
        )
    return Item(
        "Figure 5.8",
        "Maps of one room by the standard model (beta 15 degrees, tolerance 1 unit, maximum 0.98) "
        "and by the parameterized model (0.02, 0.15, 1 unit, 0.98, 15 degrees): the second is "
        "said to be better.",
        f"In {_EXAMPLE_ROOM} the parameterized model is {', '.join(clauses)}: the paired "
        "difference to the standard model, with its interval over the seeds.",
        (
            context.figure(
                "maps",
                figure,
                f"{_EXAMPLE_ROOM}, seed {context.seeds[0]}: the truth (light: not observable) and "
                "the maps of both models, above with the tolerance of figure 5.8, below with "
                "0.025 m",
            ),
        ),
    )


def _rooms(context: StudyContext, found: Mapping[str, ScoredPairs]) -> Item:
    tables = []
    for index, pair in enumerate(PAIRS):
        rows = []
        for room, scored in found.items():
            for score in SCORES:
                difference = differences(scored, index, score.name)
                rows.append(
                    (
                        room,
                        f"{score.title}, {score.unit}".rstrip(", "),
                        mean(scored, index, 0, score.name).text(),
                        mean(scored, index, 1, score.name).text(),
                        difference.text(),
                        word(difference, score.better),
                    )
                )
            sheet = mean(scored, index, 0, "sheet").text()
            rows.append((room, "Map Score of the blank sheet, bit", sheet, sheet, "", ""))
        tables.append(
            context.table(
                f"rooms-{pair.tolerance_m * 1000:.0f}-mm",
                ("room", "score", "standard", "parameterized", "difference", "parameterized is"),
                rows,
                f"Both models in every room, tolerance P3 = {pair.tolerance_m:g} m, observable "
                "cells; differences are paired by seed. The skill of the blank sheet is 0",
            )
        )
    by_score = {
        score.title: [
            {room: differences(scored, index, score.name) for room, scored in found.items()}
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
        f"Of {len(found)} rooms the parameterized model is better, with the parameters of figure "
        f"5.8, in {', '.join(counts)}; with P3 = {PAIRS[1].tolerance_m:g} m, "
        f"in {', '.join(finer)}.",
        (
            context.figure(
                "differences",
                figure,
                "Parameterized less standard model, mean over the seeds with 95 % intervals; the "
                "axis of the Brier score is turned, so that right is better everywhere",
            ),
        ),
        tuple(tables),
    )


def _why(context: StudyContext, found: Mapping[str, ScoredPairs]) -> Item:
    parts = [
        {
            title: {room: differences(scored, index, name) for room, scored in found.items()}
            for name, title in PARTS.items()
        }
        for index in range(len(PAIRS))
    ]
    rows = []
    for room, scored in found.items():
        for index, pair in enumerate(PAIRS):
            areas = [
                mean(scored, index, model, name).text(2)
                for name in ("phantom_m2", "false_free_m2")
                for model in (0, 1)
            ]
            bits = [by_room[room].text() for by_room in parts[index].values()]
            rows.append((room, f"{pair.tolerance_m:g}", *areas, *bits))
    table = context.table(
        "areas",
        (
            "room",
            "P3, m",
            "phantom, standard, m²",
            "phantom, parameterized, m²",
            "false-free, standard, m²",
            "false-free, parameterized, m²",
            *(f"bits, {title}" for title in PARTS.values()),
        ),
        rows,
        "Area mapped wrongly, and where the difference of the Map Score comes from: parameterized "
        "less standard, bits per observable cell, the three add up",
    )
    figure = context.figure(
        "parts",
        draw_differences(
            [(f"Map Score, bit, P3 = {pair.tolerance_m:g} m", 1) for pair in PAIRS],
            [list(by_title.values()) for by_title in parts],
            list(PARTS.values()),
        ),
        "Where the difference of the Map Score (parameterized less standard) comes from: three "
        "kinds of cells that add up to it, with 95 % intervals",
    )
    clauses = [f"on {title} it is {verdicts(by_room, 1, 2)}" for title, by_room in parts[0].items()]
    return Item(
        "Why one model wins: three kinds of cells",
        "The proposed model has no spikes that say the opposite of what they should; the thesis "
        "gives no number.",
        f"{_of_the_models()} The Map Score's difference with P3 = {PAIRS[0].tolerance_m:g} m, in "
        f"bits per observable cell: {'; '.join(clauses)}. {_example_areas(found[_EXAMPLE_ROOM])}",
        (figure,),
        (table,),
    )


def _of_the_models() -> str:
    """Return what the models themselves say before their hills and in them, in numbers."""
    pair, clauses = PAIRS[0], []
    for reading_m in (1.0, 2.0):
        (standard_before, standard_hill), (ours_before, ours_hill) = (
            contradictions(model, reading_m, pair.tolerance_m)
            for model in (pair.standard, pair.parameterized)
        )
        clauses.append(
            f"of a reading of {reading_m:g} m the standard model calls {standard_before:.0%} of "
            f"the cone before its hill rather occupied and {standard_hill:.0%} of the hill rather "
            f"free (parameterized: {ours_before:.0%} and {ours_hill:.0%})"
        )
    return f"By the equations alone, {'; '.join(clauses)}."


def _example_areas(scored: ScoredPairs) -> str:
    clauses = []
    for index, pair in enumerate(PAIRS):
        phantom, missed = (
            [mean(scored, index, model, name).value for model in (0, 1)]
            for name in ("phantom_m2", "false_free_m2")
        )
        whole = differences(scored, index, "map_score")
        clauses.append(
            f"with P3 = {pair.tolerance_m:g} m a phantom area of {phantom[1]:.2f} against "
            f"{phantom[0]:.2f} m², walls mapped as free {missed[1]:.2f} against "
            f"{missed[0]:.2f} m², Map Score {whole.text(2, 'bit')}"
        )
    return f"{_EXAMPLE_ROOM}, parameterized against standard: {'; '.join(clauses)}."


def _answer(found: Mapping[str, ScoredPairs]) -> Answer:
    by_score = [
        {
            score: {room: differences(scored, index, score.name) for room, scored in found.items()}
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
        else f"Not in every room by any of the {len(SCORES)} scores"
    )
    clauses = [
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
        f"parameterized model is, {'; '.join(clauses)} (differences to the standard model). With "
        f"P3 = {PAIRS[1].tolerance_m:g} m for both it is better, of {len(found)} rooms, in "
        f"{', '.join(finer)}. {_beside_the_sheet(found)}",
    )


def _beside_the_sheet(found: Mapping[str, ScoredPairs]) -> str:
    """Return in how many rooms the maps know more than the room's share of walls."""
    standard, ours = (
        sum(mean(scored, 0, model, "skill").value > 0 for scored in found.values())
        for model in (0, 1)
    )
    return (
        "More than a blank sheet that knows only the share of walls (skill above 0) the standard "
        f"model knows in {standard} of {len(found)} rooms, the parameterized one in {ours}."
    )
