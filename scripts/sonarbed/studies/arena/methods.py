"""Each method three ways: as published, tuned, and tuned with a logistic after it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import get_args

import numpy as np

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.studies.arena.entries import NO_FILTER, Entry, Variant
from sonarbed.studies.arena.table import Standing, Table

__all__ = ["COLUMNS", "best_of_each", "each_method", "firsts", "method_rows"]

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


def each_method(context: StudyContext, table: Table) -> Iterator[Item]:
    """Yield the table of methods over all rooms and sonars, if any ran without a filter."""
    if not best_of_each(table):
        return
    rows = [tuple(cell.replace("**", "") for cell in row) for row in method_rows(table)]
    yield Item(
        "Each method three ways",
        "which method knows most over all rooms and sonars, at its best?",
        _ahead(table),
        (),
        (
            context.table(
                "methods", COLUMNS, rows, "Skill; the last four columns are the best way's"
            ),
        ),
    )


def best_of_each(table: Table) -> list[Entry]:
    """Return each method without a filter once, as it stands best, the best first."""
    return [Entry(method, NO_FILTER, next(iter(ways))) for method, ways in _ways(table).items()]


def method_rows(table: Table) -> list[tuple[str, ...]]:
    """Return a row a method without a filter, the best first; its best way is in ``**``."""
    rows = []
    for method, ways in _ways(table).items():
        best = next(iter(ways.values()))
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
    entries = [entry.label for entry in best_of_each(table)]
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
    """Return how each method stands each way, best first: the methods, and the ways of each."""
    methods = {str(row["method"]) for row in table.rows if row["filter"] == NO_FILTER}
    labels = {
        Entry(method, NO_FILTER, variant).label: (method, variant)
        for method in methods
        for variant in get_args(Variant)
    }
    ways: dict[str, dict[Variant, Standing]] = {}
    for standing in table.standings():
        if standing.entry in labels:
            method, variant = labels[standing.entry]
            ways.setdefault(method, {})[variant] = standing
    return ways


def _ahead(table: Table) -> str:
    best = [entry.label for entry in best_of_each(table)]
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
