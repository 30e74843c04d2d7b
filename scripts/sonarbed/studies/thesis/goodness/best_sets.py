"""Tables 5.1 and 5.2 and figures 5.10 to 5.12: the sets that each measure calls the best."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import sonarmap as sm
import worlds
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.reporting.wording import verdicts
from sonarbed.studies.thesis.goodness.choices import (
    Choice,
    choice_of,
    first_bar,
    parameters,
    tendencies,
)
from sonarbed.studies.thesis.goodness.figures import draw_chosen
from sonarbed.studies.thesis.goodness.search import CELL_M, RANGE_LIMIT_M, TRUTHS, RoomSearch
from sonarbed.studies.thesis.plans import TitledMap
from sonarmap.methods.bayes.models import THESIS_UNIT_M

__all__ = [
    "TABLE_5_2",
    "first_bar_item",
    "optimal_sets_item",
    "other_measures_item",
    "thesis_choices",
]

# Table 5.2: (P5, 2 P3, P2), each with the four values of P4.
TABLE_5_2 = frozenset(
    {
        (6, 0.5, 0.2),
        (6, 0.5, 0.15),
        (6, 0.5, 0.1),
        (6, 1.0, 0.2),
        (6, 1.0, 0.15),
        (6, 1.5, 0.2),
        (7, 0.5, 0.2),
    }
)
# P2, 2 P3, P4, P5 as table 5.1 and figures 5.11 and 5.12 print them. For figure 5.11 the text has
# 0.5 (as "P3"), its caption 2 P3 = 1.0; for the first bar's mean the sets of table 5.2 give P4.
_THESIS = (
    ("5.10 d, first bar's mean", 0.171, 0.786, 0.965, 6.14),
    ("5.10 e, lowest VSDNS", 0.2, 0.5, 0.98, 6),
    ("5.10 f, mean VSDNS", 0.05, 2.0, 0.98, 14),
    ("5.11, derivative", 0.2, 1.0, 0.95, 40),
    ("5.12, two runs", 0.05, 3.0, 0.98, 35),
)
_NAMES = ("P1", "P2", "2 P3, 0.1 m", "P4", "P5, degrees")
_WORTH = (
    "VSDNS",
    "true Map Score, bit",
    "sets that are better",
    "true F1 at 10 cm",
    "sets that are better by F1",
)

Choices = Mapping[str, Sequence[Choice]]
"""What each rule chose, by room; in the order of `goodness_search.choices`."""


def thesis_choices(found: RoomSearch) -> list[Choice]:
    """Return what the sets that the thesis printed are worth in a room."""
    return [
        choice_of(
            found,
            rule,
            sm.ParameterizedModel(
                p1=round(1 - p4, 3),
                p2=p2,
                p3_m=twice_p3 / 2 * THESIS_UNIT_M,
                p4=p4,
                p5_rad=math.radians(p5),
            ),
        )
        for rule, p2, twice_p3, p4, p5 in _THESIS
    ]


def optimal_sets_item(
    context: StudyContext, searches: Sequence[RoomSearch], chosen: Choices, printed: Choices
) -> Item:
    """Return figure 5.10 and table 5.1."""
    tables = (
        context.table(
            "optimal-sets",
            ("room", "best by", *_NAMES, *_WORTH),
            _rows(chosen),
            "The sets that each rule calls the best here (table 5.1, figures 5.10 to 5.12), and "
            "what they are worth: observable cells that a reading up to the limit can reach, mean "
            "over the seeds",
        ),
        context.table(
            "thesis-sets",
            ("room", "the thesis's figure", *_NAMES, *_WORTH),
            _rows(printed),
            "The sets that the thesis printed, and what they are worth in these rooms",
        ),
    )
    clauses = [
        f"{whose} against {what}: {verdicts(_gains(choices, 2, before), 1)}"
        for whose, choices in (("ours", chosen), ("the thesis's own sets", printed))
        for before, what in ((0, "d"), (1, "e"))
    ]
    return Item(
        "Figure 5.10 and table 5.1",
        "Three optimal sets by VSDNS: the mean of the first bar (5.10 d: 0.03, 0.171, 0.786, 0.97, "
        "6.14), the lowest VSDNS (e: 0.02, 0.2, 0.5, 0.98, 6), and the set at the mean VSDNS (f: "
        "0.02, 0.05, 2, 0.98, 14), 'remarkably better' than the other two.",
        f"Is f better, by true Map Score in bit? {'; '.join(clauses)}. Sets with a better true Map "
        f"Score than d, e and f (ours): {'; '.join(_beaten(chosen, (0, 1, 2)))}.",
        tuple(_maps(context, found, chosen[found.room]) for found in searches),
        tables,
    )


def other_measures_item(chosen: Choices, printed: Choices) -> Item:
    """Return figures 5.11 and 5.12."""
    clauses = [
        f"{name} chooses (P1, P2, 2 P3, P4, P5) "
        + "; ".join(
            f"{room} {', '.join(_printed(of_room[index].model))} with "
            f"{of_room[index].mean('map_score').text(2, 'bit')}"
            for room, of_room in chosen.items()
        )
        for name, index in (
            ("The lowest derivative", 3),
            ("The positive less the negative score of two runs", 4),
        )
    ]
    best = [
        f"{room} {of_room[5].mean('map_score').text(2, 'bit')}" for room, of_room in chosen.items()
    ]
    return Item(
        "Figures 5.11 and 5.12",
        "The derivative calls 0.05, 0.2, 0.5 (in the figure 1.0), 0.95, 40 optimal, 'worse than "
        "most of the maps of figure 5.10'; two runs call 0.02, 0.05, 3, 0.98, 35 optimal, 'better "
        "than several sets but not the best one'.",
        f"{'. '.join(clauses)}. The best by truth: {'; '.join(best)}. Sets with a better true Map "
        f"Score than the choice by derivative and by two runs: {'; '.join(_beaten(chosen, (3, 4)))}"
        f"; than the thesis's own two: {'; '.join(_beaten(printed, (3, 4)))}. The two runs have "
        "the same start and the same driver, but their odometry errs differently, as a robot's "
        "does: the measure includes that. The maps are in the figures above.",
    )


def first_bar_item(context: StudyContext, searches: Sequence[RoomSearch]) -> Item:
    """Return table 5.2."""
    found = searches[0]
    vsdns, score = found.mean("vsdns"), found.mean("map_score")
    members = first_bar(vsdns).members
    rows = []
    for index in members:
        _, p2, twice_p3, p4, p5 = parameters(found.sets[index])
        rows.append(
            (
                f"{p5:.0f}",
                f"{p4:.2f}",
                f"{twice_p3:.1f}",
                f"{p2:.2f}",
                f"{vsdns[index]:.6f}",
                f"{score[index]:.3f}",
                f"{(score > score[index]).mean():.1%}",
                "yes" if _in_table_5_2(found.sets[index]) else "no",
            )
        )
    header = ("P5", "P4", "2 P3, 0.1 m", "P2", "VSDNS", "true Map Score, bit", _WORTH[2])
    leaning = {searched.room: tendencies(searched) for searched in searches}
    names = ("P2", "P3", "P4", "P5")
    tables = (
        context.table(
            "first-bar",
            (*header, "in table 5.2"),
            rows,
            f"The sets of the first bar in {found.room}, mean over the seeds",
        ),
        context.table(
            "tendencies",
            ("room", "parameter", "with VSDNS", *(f"with {truth.title}" for truth in TRUTHS)),
            [
                (room, name, *(by_name[name][c].text(2) for c in ("vsdns", "map_score", "f1")))
                for room, by_name in leaning.items()
                for name in names
            ],
            "Rank correlation over the sets of each parameter with VSDNS and with the true scores "
            "(P1 = 1 - P4 ranks as P4 turned round)",
        ),
    )
    clauses = [
        f"{name} {verdicts({r: by[name]['vsdns'] for r, by in leaning.items()}, 1, words=words)}"
        for name in names
        for words in [("more VSDNS", "less VSDNS", "no tendency")]
    ]
    true = [f"{name} {leaning[found.room][name]['map_score'].text(2)}" for name in names]
    searched = sum(map(_in_table_5_2, found.sets))
    shared = sum(_in_table_5_2(found.sets[index]) for index in members)
    return Item(
        "Table 5.2",
        "The 28 sets of the first bar: lower P3 and P5 and higher P2 give less VSDNS, P1 and P4 "
        "show no pattern.",
        f"In {found.room} the first bar has {len(members)} sets, {shared} of them among the "
        f"{searched} of table 5.2 that were searched. Higher values of a parameter give, as rank "
        f"correlations: {'; '.join(clauses)}. With the true Map Score in {found.room}: "
        f"{', '.join(true)}.",
        tables=tables,
    )


def _rows(choices: Choices) -> list[tuple[str, ...]]:
    return [
        (
            room,
            choice.rule,
            *_printed(choice.model),
            choice.mean("vsdns").text(4),
            choice.mean("map_score").text(),
            f"{choice.beaten_by['map_score']:.1%}",
            choice.mean("f1").text(),
            f"{choice.beaten_by['f1']:.1%}",
        )
        for room, of_room in choices.items()
        for choice in of_room
    ]


def _gains(choices: Choices, index: int, before: int) -> dict[str, Estimate]:
    """Return the Map Score of a choice less that of another, paired by seed, by room."""
    return {
        room: mean_of(of_room[index].values["map_score"] - of_room[before].values["map_score"])
        for room, of_room in choices.items()
    }


def _beaten(choices: Choices, indices: Sequence[int]) -> list[str]:
    """Return the shares of sets that are truly better than some choices, room by room."""
    return [
        f"{room} " + ", ".join(f"{of_room[i].beaten_by['map_score']:.0%}" for i in indices)
        for room, of_room in choices.items()
    ]


def _printed(model: sm.ParameterizedModel) -> list[str]:
    return [f"{value:.3g}" for value in parameters(model)]


def _in_table_5_2(model: sm.ParameterizedModel) -> bool:
    _, p2, twice_p3, _, p5 = parameters(model)
    return (round(p5), round(twice_p3, 2), round(p2, 2)) in TABLE_5_2


def _maps(context: StudyContext, found: RoomSearch, chosen: Sequence[Choice]) -> tuple[str, str]:
    truth = worlds.truth(worlds.load(found.room), resolution_m=CELL_M)
    drive = found.runs[0]
    examples = []
    for letter, choice in zip(
        ("d: ", "e: ", "f: ", "5.11: ", "5.12: ", "", ""), chosen, strict=True
    ):
        built = sm.build_map(drive.log, choice.model, truth.grid, max_range_m=RANGE_LIMIT_M)
        score = sm.score_map(built, truth, observable=drive.scored)
        title = (
            f"{letter}{choice.rule}\n{', '.join(_printed(choice.model))}\n"
            f"{score.map_score:.2f} bit, F1 = {score.f1(1):.2f}"
        )
        examples.append(TitledMap(title, built))
    return context.figure(
        f"chosen-{found.room}",
        draw_chosen(truth, drive.scored, examples),
        f"{found.room}, seed {context.seeds[0]}: the truth (light: not scored) and the maps of "
        "the sets that each rule calls the best; below the rule P1, P2, 2 P3, P4, P5 and the true "
        "scores of this map",
    )
