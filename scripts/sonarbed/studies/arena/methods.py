"""Each method three ways: as published, tuned, and tuned with a logistic after it."""

from __future__ import annotations

from collections import Counter
from typing import get_args

import numpy as np

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.studies.arena.entries import NO_FILTER, Entry, Variant
from sonarbed.studies.arena.table import Standing, Table

__all__ = ["COLUMNS", "each_method", "firsts", "method_rows"]

COLUMNS = (
    "method",
    "as published",
    "tuned",
    "tuned, with a logistic",
    "worst room",
    "AP, 1 cell",
    "F1, 10 cm",
    "seconds",
)
_AS_PUBLISHED = "as published"


def each_method(context: StudyContext, table: Table) -> Item:
    """Return the table of methods over all sonars and rooms, and how far the first is ahead."""
    ways = _ways(table)
    finding = _ahead(table, ways)
    rows = [tuple(cell.replace("**", "") for cell in row) for row in method_rows(table)]
    return Item(
        "Each method three ways",
        "which method knows most over all rooms and sonars, at its best?",
        finding,
        (),
        (
            context.table(
                "methods", COLUMNS, rows, "Skill; the last four columns are the best way's"
            ),
        ),
    )


def method_rows(table: Table) -> list[tuple[str, ...]]:
    """Return a row a method without a filter, the best first; its best way is in ``**``."""
    rows = []
    for method, ways in _ways(table).items():
        best = _best(ways)
        skills = [
            _AS_PUBLISHED
            if variant not in ways
            else f"**{ways[variant].skill.text()}**"
            if ways[variant] is best
            else ways[variant].skill.text()
            for variant in get_args(Variant)
        ]
        scores = (best.means[name] for name in ("tolerant_average_precision", "f1_10_cm"))
        rows.append(
            (
                method,
                *skills,
                f"{best.worst:.2f}",
                *(f"{score:.2f}" for score in scores),
                f"{best.means['seconds']:.2f}",
            )
        )
    return rows


def firsts(table: Table) -> dict[tuple[str, str], tuple[dict[str, int], int]]:
    """Return, by sonar and group of rooms, in how many rooms each method is first, and how many.

    A method counts by its best way over all of the table; rooms without a wall do not count.
    """
    entries = [_best(ways).entry for ways in _ways(table).values()]
    found = {}
    for sonar in sorted({row["sonar"] for row in table.rows}):
        for group in sorted({row["group"] for row in table.rows}):
            rows = [
                row
                for row in table.rows
                if (row["sonar"], row["group"]) == (sonar, group) and row["entry"] in entries
            ]
            if not rows:
                continue
            part = Table(rows)
            skills = {entry: part.room_skill(entry) for entry in part.entries}
            # Where no wall was observable there is nothing to be first at.
            judged = np.flatnonzero(np.isfinite(list(skills.values())).all(axis=0))
            first = [max(skills, key=lambda entry: skills[entry][room]) for room in judged]
            found[sonar, group] = (dict(Counter(first)), len(judged))
    return found


def _ways(table: Table) -> dict[str, dict[Variant, Standing]]:
    """Return how each method stands each way, the method first whose best is best."""
    labels = {
        Entry(row["method"], NO_FILTER, variant).label: (row["method"], variant)
        for row in table.rows
        if row["filter"] == NO_FILTER
        for variant in get_args(Variant)
    }
    ways: dict[str, dict[Variant, Standing]] = {}
    for standing in table.standings():
        if standing.entry in labels:
            method, variant = labels[standing.entry]
            ways.setdefault(method, {})[variant] = standing
    return ways


def _best(ways: dict[Variant, Standing]) -> Standing:
    return max(ways.values(), key=lambda each: each.skill.value)


def _ahead(table: Table, ways: dict[str, dict[Variant, Standing]]) -> str:
    best = [_best(each).entry for each in ways.values()]
    told = [
        f"in {counts.get(best[0], 0)} of {rooms} {group} rooms with the sonar {sonar}"
        for (sonar, group), (counts, rooms) in firsts(table).items()
    ]
    text = f"{best[0]} is first {', '.join(told)}."
    if len(best) > 1:
        text += (
            f" Room by room it is ahead of the next, {best[1]}, by "
            f"{table.paired(best[0], best[1]).text()}."
        )
    return text
