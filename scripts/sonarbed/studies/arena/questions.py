"""The questions that people ask of the arena, answered by its rows."""

from __future__ import annotations

import math
from collections.abc import Iterator

import sonarmap as sm
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.studies.arena.entries import FILTERED_METHODS, NO_FILTER, Entry
from sonarbed.studies.arena.standing import REPEATS, standing_robot
from sonarbed.studies.arena.table import Table

__all__ = ["answers"]

_PAIR = ("against", "skill gained", "decided")
# More than half of the readings wrong: the mirror corridor.
_MOST_WRONG = 0.5
# A cell that moves less has not moved.
_STILL = 0.02


def answers(context: StudyContext, table: Table) -> Iterator[Item]:
    """Yield the questions that the table can answer, each with its numbers."""
    yield _sheet(table)
    if any(row["filter"] == "hsr" for row in table.rows):
        yield _filter(context, table, "hsr", "Does HSR help any of them?")
    if any(row["filter"].startswith("oracle-") for row in table.rows):
        yield _filter(context, table, "oracle-drop", "What would it help to know the wrong ones?")
    yield _hard(table)
    if "nav2-range" in table.entries:
        yield _nav2(table)
    yield _readings(context, table)
    yield _repeats(context, table)


def _sheet(table: Table) -> Item:
    standings = table.standings()
    above = [each for each in standings if each.skill.low > 0]
    below = [each for each in standings if each.skill.high < 0]
    return Item(
        "Does any method beat the blank sheet?",
        "a sheet that knows only the room's share of walls has skill 0; who is above it?",
        f"{len(above)} of {len(standings)} entries are for certain"
        + (f" ({', '.join(each.entry for each in above[:6])})" if above else "")
        + f", {len(below)} are for certain below it, the others are not decided.",
    )


def _filter(context: StudyContext, table: Table, name: str, question: str) -> Item:
    rows, helped, hurt = [], 0, 0
    for method in FILTERED_METHODS:
        entry = Entry(method, name).label
        if entry not in table.entries or method not in table.entries:
            continue
        gained = table.paired(entry, method)
        helped, hurt = helped + (gained.sign > 0), hurt + (gained.sign < 0)
        rows.append((method, gained.text(), "yes" if gained.sign else "no"))
    return Item(
        question,
        f"{name} before {', '.join(FILTERED_METHODS)}, room by room, against the same without it",
        f"It raises the skill of {helped} of {len(rows)} methods, and lowers that of {hurt}.",
        (),
        (context.table(name, _PAIR, rows, f"Skill with {name} less skill without"),)
        if rows
        else (),
    )


def _hard(table: Table) -> Item:
    hard = [row for row in table.rows if row["wrong_share"] > _MOST_WRONG]
    if not hard:
        worst = max(row["wrong_share"] for row in table.rows)
        return Item(
            "Who survives when most readings are wrong?",
            "drives with more than half of their readings wrong",
            f"There is no such drive here; the worst has {worst:.0%} wrong readings.",
        )
    standings = Table(hard).standings()
    above = [each for each in standings if each.skill.value > 0]
    rooms = ", ".join(sorted({row["room"] for row in hard})[:6])
    return Item(
        "Who survives when most readings are wrong?",
        f"drives with more than half of their readings wrong ({rooms})",
        f"{standings[0].entry} is first with a skill of {standings[0].skill.text()}; "
        f"{len(above)} of {len(standings)} entries stay above the sheet.",
    )


def _nav2(table: Table) -> Item:
    standing = next(each for each in table.standings() if each.entry == "nav2-range")
    return Item(
        "What does the nav2 default do?",
        "the range layer that ROS 2 robots have, with its own numbers",
        f"Skill {standing.skill.text()}, rank {standing.rank:.1f} of {len(table.entries)}; of its "
        f"planned paths {_percent(standing.means['paths_colliding_share'])} collide and "
        f"{_percent(standing.means['paths_missed_share'])} of the pairs are missed.",
    )


def _readings(context: StudyContext, table: Table) -> Item:
    rows = []
    for name in sm.filters():
        if name == NO_FILTER:
            continue
        entry = next((e for e in table.entries if e.startswith(f"{name} + ")), None)
        if entry is None:
            continue
        rows.append(
            (
                name,
                *(
                    _percent(table.mean(entry, f"readings_{score}"))
                    for score in ("caught_share", "lost_share", "mended_share", "spoiled_share")
                ),
                _number(table.mean(entry, "readings_roc_auc")),
            )
        )
    header = ("filter", "wrong caught", "right lost", "wrong mended", "right spoiled", "ROC area")
    return Item(
        "What do the filters do to readings?",
        "of the wrong readings, how many are rejected or mended; of the right ones, how many lost",
        f"{len(rows)} filters, means over the drives." if rows else "No filter was entered.",
        (),
        (context.table("readings", header, rows, "Readings, by filter"),) if rows else (),
    )


def _repeats(context: StudyContext, table: Table) -> Item:
    told = [standing_robot(name) for name in sm.methods() if name in table.entries]
    names = list(told[0].remedied) if told else []
    rows = [
        (each.method, f"{each.moved:.3f}", *(_moved(each.remedied[name]) for name in names))
        for each in sorted(told, key=lambda each: -each.moved)
    ]
    still = [each for each in told if each.moved <= _STILL]
    return Item(
        "How much do repeats cost?",
        f"a robot stands and reads one range {REPEATS} times: how far does a cell's P move beyond "
        "what one reading says?",
        f"{len(told) - len(still)} of {len(told)} methods take repeats for news; of "
        f"{', '.join(each.method for each in still) or 'none'} no cell moves by more than "
        f"{_STILL:g}.",
        (),
        (
            context.table(
                "standing", ("method", "moved", *names), rows, "Largest change of P, by method"
            ),
        )
        if rows
        else (),
    )


def _moved(value: float | None) -> str:
    return "takes none" if value is None else f"{value:.3f}"


def _percent(value: float) -> str:
    return "none" if math.isnan(value) else f"{value:.1%}"


def _number(value: float) -> str:
    return "none" if math.isnan(value) else f"{value:.3f}"
