"""What a choice does to the methods that have it: the same maps with one thing changed."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import sonarmap as sm
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item
from sonarbed.studies.arena.entries import FILTERED_METHODS
from sonarbed.studies.arena.jobs import Seen, seen_of
from sonarbed.studies.arena.plan import ArenaPlan
from sonarbed.studies.arena.table import Table

__all__ = ["contrasts", "skill_by_scans"]

# As good as an axis alone.
_DOT_RAD = float(np.deg2rad(1.0))
# Shares of a drive's scans that are mapped.
_SHARES = (1 / 8, 1 / 4, 1 / 2, 1.0)
_LENGTH_METHODS = 4

Way = Callable[[sm.SonarLog, Any], tuple[sm.SonarLog, Any]]


@dataclass(frozen=True)
class _Contrast:
    """A question of two ways, the usual one first, and the methods that can go both."""

    name: str
    title: str
    asked: str
    methods: tuple[str, ...]
    ways: Mapping[str, Way]


def contrasts(context: StudyContext, table: Table, plan: ArenaPlan) -> Iterator[Item]:
    """Yield what becomes of the methods' skill where one choice is made the other way."""
    for contrast in _asked(table.entries):
        if contrast.methods:
            yield _answered(context, contrast, _first_drives(plan, context.folder.parent))


def skill_by_scans(context: StudyContext, table: Table, plan: ArenaPlan) -> Iterator[Item]:
    """Yield how the best published methods' skill grows with the length of the drive, if any."""
    best = [each.entry for each in table.standings() if each.entry in sm.methods()][
        :_LENGTH_METHODS
    ]
    if not best:
        return
    scans = sorted({max(1, round(share * plan.scans)) for share in _SHARES})
    rows = [
        _row(room, seen, sm.method(name), _beginning(seen.blind, count), f"{name} {count}")
        for room, seen in _first_drives(plan, context.folder.parent)
        for name in best
        for count in scans
    ]
    lengths = Table(rows)
    figure, (axes,) = figure_with(width=6.4, height=4.0)
    told = []
    for name, colour in zip(best, COLOURS, strict=False):
        means = [float(np.nanmean(lengths.room_skill(f"{name} {count}"))) for count in scans]
        axes.plot(scans, means, "o-", color=colour, label=name)
        told.append((name, *(f"{mean:.2f}" for mean in means)))
    axes.axhline(0, color="#888888", lw=1)
    axes.set(xlabel="scans mapped", ylabel="skill, mean of the rooms", ylim=(-1, 1))
    axes.legend(fontsize=8)
    first = told[0]
    yield Item(
        "Skill and the length of a drive",
        "how much of a drive does a map need?",
        f"{first[0]} has a skill of {first[1]} after {scans[0]} scans and {first[-1]} after "
        f"{scans[-1]}, over the cells that the whole drive could observe.",
        (context.figure("scans", figure, "The best methods; below -1 the axis is cut"),),
        (context.table("scans", ("method", *map(str, scans)), told, "Skill by scans mapped"),),
    )


def _beginning(log: sm.SonarLog, scans: int) -> sm.SonarLog:
    return log.select(log.scan - log.scan[:1].sum() < scans)


def _asked(entries: Iterable[str]) -> tuple[_Contrast, ...]:
    known = set(entries)
    present = [name for name in sm.methods() if name in known]
    return (
        _Contrast(
            "arc-dot",
            "Arc or dot?",
            "the same methods told that the cone is 2 degrees wide: an echo marks its axis alone",
            tuple(name for name in FILTERED_METHODS if name in present),
            {"arc": lambda log, method: (log, method), "dot": _dot},
        ),
        _Contrast(
            "no-echo",
            "Ignore or clear at no echo?",
            "the methods that have the choice: a reading without an echo says nothing, or says "
            "that its cone is empty",
            tuple(name for name in present if hasattr(sm.method(name), "no_echo")),
            {way: _no_echo(way) for way in ("ignore", "clear")},
        ),
    )


def _dot(log: sm.SonarLog, method: Any) -> tuple[sm.SonarLog, Any]:
    return log.replace(ring=dataclasses.replace(log.ring, half_angle_rad=_DOT_RAD)), method


def _no_echo(way: str) -> Way:
    return lambda log, method: (log, dataclasses.replace(method, no_echo=way))


def _answered(
    context: StudyContext, contrast: _Contrast, drives: Iterable[tuple[str, Seen]]
) -> Item:
    rows = []
    for room, seen in drives:
        for name in contrast.methods:
            for way, change in contrast.ways.items():
                log, method = change(seen.blind, sm.method(name))
                rows.append(_row(room, seen, method, log, f"{name}, {way}"))
    table, told = Table(rows), []
    usual, other = contrast.ways
    gained: list[str] = []
    lost: list[str] = []
    for name in contrast.methods:
        entries = [f"{name}, {way}" for way in contrast.ways]
        difference = table.paired(entries[1], entries[0])
        (gained if difference.sign > 0 else lost if difference.sign < 0 else []).append(name)
        means = (np.nanmean(table.room_skill(entry)) for entry in entries)
        decided = "yes" if difference.sign else "no"
        told.append((name, *(f"{mean:.2f}" for mean in means), difference.text(), decided))
    header = ("method", usual, other, f"gained by {other}", "decided")
    return Item(
        contrast.title,
        contrast.asked,
        f"Of {len(contrast.methods)} methods {len(gained)} gain by {other} "
        f"({', '.join(gained) or 'none'}) and {len(lost)} lose ({', '.join(lost) or 'none'}).",
        (),
        (context.table(contrast.name, header, told, "Skill, mean of the rooms"),),
    )


def _first_drives(plan: ArenaPlan, folder: Path) -> Iterator[tuple[str, Seen]]:
    """Yield each room's name and its first drive by the first sonar."""
    for drive in plan.drives():
        if drive.seed == 0 and drive.sonar == plan.sonars[0]:
            yield drive.room.name, seen_of(drive, folder)


def _row(
    room: str, seen: Seen, method: sm.MappingMethod, log: sm.SonarLog, entry: str
) -> dict[str, Any]:
    built = method.map(log, seen.truth.grid)
    score = sm.score_map(built, seen.truth, observable=seen.observable)
    return {
        "entry": entry,
        "room": room,
        "skill": score.skill if score.truth_occupied else None,
        "loss_bits": score.loss_bits,
        "sheet_loss_bits": score.sheet_loss_bits,
    }
