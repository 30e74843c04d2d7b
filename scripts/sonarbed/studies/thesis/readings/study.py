"""Question 2: which readings HSR mends, which it spoils, and where."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

import sonarmap as sm
import worlds
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.parallel import in_parts
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import mean_of
from sonarbed.reporting.wording import cause_name
from sonarbed.studies.thesis.experiments import EXPERIMENTS, Experiment
from sonarbed.studies.thesis.free_space import FreeSpace
from sonarbed.studies.thesis.plans import draw_outline, draw_points
from sonarbed.studies.thesis.questions import Answer, ThesisSection
from sonarbed.studies.thesis.readings.mending import (
    Counts,
    Mending,
    MendingTask,
    mended,
    share_over_drives,
)
from sonarbed.studies.thesis.readings.places import Place

__all__ = ["run"]

_GREEN, _VERMILION = COLOURS[2], COLOURS[1]
_AROUND_M = 0.6


@dataclass(frozen=True)
class _Case:
    """A room, and the experiment whose parameters fit it."""

    room: str
    like: Experiment

    def params(self, ring: sm.SonarRing) -> sm.HsrParams:
        return self.like.params(self.like.thesis, ring)


_CLOSED, _OPEN = EXPERIMENTS
_CASES = (
    _Case(_CLOSED.room, _CLOSED),
    _Case(_OPEN.room, _OPEN),
    # Rooms the thesis does not have; both have openings.
    _Case("office", _OPEN),
    _Case("corridor", _OPEN),
)


def run(context: StudyContext) -> ThesisSection:
    """Run HSR at the thesis's parameters in four rooms and judge every reading."""
    tasks = [
        MendingTask(worlds.load(case.room), log, case.params(log.ring))
        for case in _CASES
        for log in context.logs(context.specs(case.room))
    ]
    found = context.map(mended, tasks, "readings mended and spoiled")
    rooms = in_parts(found, [case.room for case in _CASES])
    items = (_shares(context, rooms), _places(context, rooms), _errors(context, rooms))
    answers = tuple(Answer(2, _sentence(room, drives)) for room, drives in rooms.items())
    return ThesisSection("readings", "HSR: readings mended and spoiled", items, answers)


def _shares(context: StudyContext, rooms: Mapping[str, Sequence[Mending]]) -> Item:
    rows = []
    for room, drives in rooms.items():
        kinds = {"all": [drive.all for drive in drives]}
        for cause in sm.Cause:
            kinds[cause_name(cause)] = [d.by_cause[cause] for d in drives]
        kinds["all, if nothing were heard off the axis"] = [drive.on_axis for drive in drives]
        rows += [(room, kind, *_cells(counts)) for kind, counts in kinds.items()]
    return Item(
        "Chapter 6: which readings are mended",
        "HSR detects specularly reflected readings and updates them, with or without openings; "
        "the thesis shows it in maps, not reading by reading.",
        " ".join(_sentence(room, drives) for room, drives in rooms.items()),
        tables=(context.table("causes", ("room", "cause", *_HEADER), rows, _CAPTION),),
    )


_HEADER = ("wrong readings", "mended", "right readings", "spoiled")
_CAPTION = (
    "Readings of all drives; the shares are means over drives. Mended: a wrong reading that was "
    "updated to within 0.1 m of a truth (cone or axis). Spoiled: a right one that was updated to "
    "farther than that from both"
)


def _cells(counts: Sequence[Counts]) -> tuple[str, ...]:
    wrong, right = (sum(getattr(each, name) for each in counts) for name in ("wrong", "right"))
    shares = [
        share_over_drives(counts, part, whole).text(1, "%", factor=100) if number else ""
        for part, whole, number in (("mended", "wrong", wrong), ("spoiled", "right", right))
    ]
    return str(wrong), shares[0], str(right), shares[1]


def _sentence(room: str, drives: Sequence[Mending]) -> str:
    counts = [drive.all for drive in drives]
    mended_share = share_over_drives(counts, "mended", "wrong").text(1, "%", factor=100)
    spoiled_share = share_over_drives(counts, "spoiled", "right").text(1, "%", factor=100)
    on_axis = share_over_drives([drive.on_axis for drive in drives], "spoiled", "right")
    spoiled = {place: sum(d.by_place[place].spoiled for d in drives) for place in Place}
    total = sum(spoiled.values())
    where = ""
    if total:
        shares = (
            f"{place.label} {count / total:.0%}"
            for place, count in sorted(spoiled.items(), key=lambda each: -each[1])
            if count
        )
        where = f" ({', '.join(shares)} of these)"
    return (
        f"{room}: mends {mended_share} of the wrong readings, spoils {spoiled_share} of the right "
        f"ones{where}; if nothing were heard off the axis, {on_axis.text(1, '%', factor=100)}."
    )


def _places(context: StudyContext, rooms: Mapping[str, Sequence[Mending]]) -> Item:
    rows = [
        (room, place.label, *_cells([drive.by_place[place] for drive in drives]))
        for room, drives in rooms.items()
        for place in Place
    ]
    return Item(
        "Chapter 6: where readings are mended and spoiled",
        "Cross-talk and the situation of the target distance are said to be common at corners; "
        "openings get noise with large walls (section 6.4.2).",
        " ".join(_extremes(room, drives) for room, drives in rooms.items()),
        (
            context.figure(
                "where",
                _picture(rooms),
                "Data points after HSR of one drive, at the true poses",
            ),
        ),
        (
            context.table(
                "places",
                ("room", "place", *_HEADER),
                rows,
                f"{_CAPTION}. Opening: nothing in range on the axis, or the axis passes an edge to "
                "what is 0.3 m farther; corner: within 0.3 m of one; oblique: more than 30 degrees "
                "off the normal",
            ),
        ),
    )


def _extremes(room: str, drives: Sequence[Mending]) -> str:
    """Return where the share mended is least and the share spoiled is largest."""
    shares: dict[str, dict[Place, float]] = {"mended": {}, "spoiled": {}}
    for place in Place:
        counts = [drive.by_place[place] for drive in drives]
        for part, whole in (("mended", "wrong"), ("spoiled", "right")):
            # A handful of readings is no place to speak of.
            if sum(getattr(each, whole) for each in counts) >= 10 * len(drives):
                shares[part][place] = share_over_drives(counts, part, whole).value
    if not shares["mended"] or not shares["spoiled"]:
        return f"{room}: too few readings of a kind."
    least = min(shares["mended"], key=lambda place: shares["mended"][place])
    most = max(shares["mended"], key=lambda place: shares["mended"][place])
    worst = max(shares["spoiled"], key=lambda place: shares["spoiled"][place])
    return (
        f"{room}: the share mended is largest at the {most.label} ({shares['mended'][most]:.0%}) "
        f"and least at the {least.label} ({shares['mended'][least]:.0%}); most is spoiled at the "
        f"{worst.label} ({shares['spoiled'][worst]:.1%})."
    )


def _picture(rooms: Mapping[str, Sequence[Mending]]) -> Figure:
    figure, axes = figure_with(2, (len(rooms) + 1) // 2, width=7.0, height=5.2)
    for panel, (room, drives) in zip(axes, rooms.items(), strict=False):
        world, drive = worlds.load(room), drives[0]
        low, high = np.reshape(world.bounds_m, (2, 2))
        if len(drive.points_m):
            # Only where something changed: a room may be much wider than the drive.
            low = np.maximum(low, drive.points_m.min(axis=0) - _AROUND_M)
            high = np.minimum(high, drive.points_m.max(axis=0) + _AROUND_M)
        draw_outline(panel, FreeSpace.of(world), (*low, *high), colour="#444444")
        for colour, is_kind, name in (
            (_GREEN, drive.is_mended, "mended"),
            (_VERMILION, ~drive.is_mended, "spoiled"),
        ):
            label = f"{name}: {is_kind.sum()}"
            draw_points(panel, drive.points_m[is_kind], colour=colour, label=label)
        # Above the room, where no label of the axes comes in its way whatever its shape.
        panel.legend(
            title=room,
            fontsize=8,
            markerscale=5,
            frameon=False,
            ncols=2,
            loc="lower center",
            bbox_to_anchor=(0.5, 1.0),
        )
    return figure


_ERRORS = (
    "median, m",
    "95 %, m",
    "too long by 0.1 m",
    "too short by 0.1 m",
    "too long by 0.3 m",
    "too short by 0.3 m",
)


def _errors(context: StudyContext, rooms: Mapping[str, Sequence[Mending]]) -> Item:
    rows, sentences = [], []
    for room, drives in rooms.items():
        for key in drives[0].errors:
            values = np.array([drive.errors[key] for drive in drives])
            rows.append((room, *reversed(key.split()), *(mean_of(v).text() for v in values.T)))
        before, after = (
            np.array([drive.errors[f"{when} cone"] for drive in drives]).mean(axis=0)
            for when in ("before", "after")
        )
        sentences.append(
            f"{room}: {before[2]:.0%} too long by 0.1 m against the cone become {after[2]:.0%}, "
            f"{before[3]:.0%} too short become {after[3]:.0%}."
        )
    return Item(
        "Chapter 6: range errors",
        "An updated reading is to be nearer to the true distance.",
        " ".join(sentences),
        tables=(
            context.table(
                "errors",
                ("room", "truth", "when", *_ERRORS),
                rows,
                "Error of all readings against the nearest surface in the cone and the first on "
                "the axis, before and after HSR; no echo counts as the maximum range",
            ),
        ),
    )
