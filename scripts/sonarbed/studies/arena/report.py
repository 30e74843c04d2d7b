"""The page of the arena: leaderboards, what depends on what, maps, and questions answered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.pictures import show_map, show_truth
from sonarbed.reporting.report import write_report
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.arena.contrasts import contrasts, skill_by_scans
from sonarbed.studies.arena.entries import NO_FILTER
from sonarbed.studies.arena.jobs import DriveJob, seen_of
from sonarbed.studies.arena.methods import best_of_each, each_method
from sonarbed.studies.arena.plan import ArenaPlan
from sonarbed.studies.arena.questions import answers
from sonarbed.studies.arena.running import ArenaResult
from sonarbed.studies.arena.table import Interval, Standing, Table

__all__ = ["LEADERBOARD", "leaderboard_rows", "write_arena_report"]

LEADERBOARD = (
    "entry",
    "skill, mean of rooms",
    "pooled",
    "worst room",
    "rank",
    "behind the best",
    "AP",
    "AP, 1 cell",
    "calibration error",
    "recalibrated skill",
    "F1, 10 cm",
    "paths collide",
    "missed",
    "seconds",
)
# A figure shows so many entries. Maps of so many rooms stand side by side, of so many entries.
_DRAWN = 40
_MAP_ROOMS, _MAP_ENTRIES = 3, 24


def write_arena_report(plan: ArenaPlan, result: ArenaResult, folder: Path) -> tuple[Path, Path]:
    """Write ``report.html`` and ``report.md`` into a folder; return their paths."""
    context = StudyContext(folder, report="arena", sonar=plan.sonars[0])
    context.claim()
    table = Table(result.rows)
    made = (
        _leaderboards(context.on_study("leaderboard"), table, plan),
        _questions(context.on_study("questions"), table, plan),
        _dependence(context.on_study("dependence"), table, plan),
        _maps(context.on_study("maps"), table, plan),
    )
    sections = [section for section in made if section.items]
    for section in sections:
        section.save(context.folder / section.study)
    return write_report(
        context,
        sections,
        package="sonarbed.studies.arena",
        values={"about": _about(plan, table, result)},
    )


def leaderboard_rows(standings: Sequence[Standing]) -> list[tuple[str, ...]]:
    """Return the leaderboard as text, a row an entry, see `LEADERBOARD`."""
    return [
        (
            each.entry,
            each.skill.text(),
            _text(each.pooled),
            _text(each.worst),
            _text(each.rank, 1),
            "" if each is standings[0] else _behind(each.behind),
            *(
                _text(each.means[name])
                for name in (
                    "average_precision",
                    "tolerant_average_precision",
                    "calibration_error",
                    "recalibrated_skill",
                    "f1_10_cm",
                    "paths_colliding_share",
                    "paths_missed_share",
                )
            ),
            _text(each.means["seconds"], 3),
        )
        for each in standings
    ]


def _behind(behind: Interval) -> str:
    return behind.text() + ("" if behind.sign else ", not decided")


def _text(value: float, digits: int = 2) -> str:
    return "none" if math.isnan(value) else f"{value:.{digits}f}"


def _about(plan: ArenaPlan, table: Table, result: ArenaResult) -> str:
    failed = f" {result.runs.failed} runs of the last call failed." if result.runs.failed else ""
    return (
        f"{len(table.entries)} entries in {len(plan.rooms)} rooms, sonars "
        f"{' and '.join(plan.sonars)}, {plan.seeds} drives each of {plan.scans} scans, cells of "
        f"{100 * plan.resolution_m:g} cm; {len(table.rows)} runs.{failed} Entries are given logs "
        "without truth and provenance, on a grid that reaches 1.5 to 2 m beyond the room; only the "
        "oracles among the filters know more. Skill is 1 - H(map) / H(sheet), H the log loss and "
        "the sheet a constant map with the room's own share of walls. Intervals are 95 % over "
        "rooms, by bootstrap; seconds are of one processor."
    )


def _leaderboards(context: StudyContext, table: Table, plan: ArenaPlan) -> Section:
    items = list(each_method(context, table))
    for sonar in plan.sonars:
        for group in ("shipped", "generated"):
            rows = [r for r in table.rows if r["sonar"] == sonar and r["group"] == group]
            if rows:
                items.append(_leaderboard(context, Table(rows), f"{sonar}, {group} rooms"))
    return Section("leaderboard", "Leaderboards", tuple(items))


def _leaderboard(context: StudyContext, table: Table, title: str) -> Item:
    standings = table.standings()
    name = title.replace(", ", "-").replace(" ", "-")
    shown = standings[:_DRAWN][::-1]
    figure, (axes,) = figure_with(width=7.5, height=1.2 + 0.24 * len(shown))
    place = np.arange(len(shown))
    skill = np.array([[each.skill.value, each.skill.low, each.skill.high] for each in shown])
    # Far below the sheet it does not matter how far.
    least = max(float(np.nanmin(skill[:, 1])), -2.0) - 0.1
    value = np.clip(skill[:, 0], least, None)
    axes.barh(place, value - least, left=least, color="#DDDDDD")
    axes.hlines(
        place, np.clip(skill[:, 1], least, None), np.clip(skill[:, 2], least, None), color="k"
    )
    axes.plot(value, place, "o", ms=4, color=COLOURS[0])
    axes.axvline(0, color=COLOURS[1], lw=1, label="the blank sheet")
    axes.set(xlim=(least, 1), xlabel="skill, mean of the rooms", title=title, ylim=(-1, len(shown)))
    axes.set_yticks(place, [each.entry for each in shown], fontsize=8)
    axes.legend(loc="lower right", fontsize=8)
    best, above = standings[0], [each for each in standings if each.skill.low > 0]
    finding = (
        f"First is {best.entry} with a skill of {best.skill.text()}. "
        f"{len(above)} of {len(standings)} entries are above the sheet for certain."
    )
    return Item(
        title,
        "which entry knows most, in how many rooms, and can a robot use its map?",
        finding,
        (
            context.figure(
                name,
                figure,
                f"Skill with 95 % over rooms, {_DRAWN} at most; below the axis it goes on",
            ),
        ),
        (context.table(name, LEADERBOARD, leaderboard_rows(standings), f"The table, {title}"),),
    )


def _questions(context: StudyContext, table: Table, plan: ArenaPlan) -> Section:
    items = (*answers(context, table), *contrasts(context, table, plan))
    return Section("questions", "Questions", items)


def _dependence(context: StudyContext, table: Table, plan: ArenaPlan) -> Section:
    # Filters have rows of their own; where nothing ran without one they are all there is.
    plain = Table([row for row in table.rows if row["filter"] == NO_FILTER] or table.rows)
    standings = [each for each in plain.standings() if math.isfinite(each.skill.value)]
    shown = [each.entry for each in standings[:6]]
    figure, (axes,) = figure_with(width=7.5, height=4.4)
    for entry, colour in zip(shown, COLOURS, strict=False):
        rows = [r for r in plain.rows if r["entry"] == entry and r["skill"] is not None]
        axes.plot(
            [r["wrong_share"] for r in rows],
            np.clip([r["skill"] for r in rows], -2, 1),
            ".", ms=4, color=colour, label=entry,
        )  # fmt: skip
    axes.axhline(0, color="#888888", lw=1)
    axes.set(xlabel="share of wrong readings in the drive", ylabel="skill (cut at -2)")
    axes.legend(fontsize=8, loc="lower left")
    rooms = plain.rooms
    matrix = np.array([plain.room_skill(entry) for entry in (e.entry for e in standings)])
    grid, (cells,) = figure_with(width=3 + 0.28 * len(rooms), height=1.8 + 0.26 * len(standings))
    image = cells.imshow(np.clip(matrix, -1, 1), cmap="RdBu", vmin=-1, vmax=1, aspect="auto")
    cells.set_xticks(range(len(rooms)), rooms, rotation=90, fontsize=7)
    cells.set_yticks(range(len(standings)), [e.entry for e in standings], fontsize=8)
    grid.colorbar(image, ax=cells, label="skill, cut at -1")
    best = standings[0].entry
    rows = [r for r in plain.rows if r["entry"] == best and r["skill"] is not None]
    slope = _slope([r["wrong_share"] for r in rows], [r["skill"] for r in rows])
    items = (
        Item(
            "Skill and wrong readings",
            "how much does it cost that readings are wrong?",
            f"Of {best}, 10 points more of wrong readings go with a skill {abs(slope) / 10:.2f} "
            f"{'lower' if slope < 0 else 'higher'}.",
            (context.figure("wrong", figure, "Each point is a drive; the six best methods"),),
        ),
        Item(
            "Rooms",
            "which rooms are hard, and for whom?",
            f"The hardest for {best} is {rooms[int(np.nanargmin(matrix[0]))]}, the easiest "
            f"{rooms[int(np.nanargmax(matrix[0]))]}.",
            (context.figure("rooms", grid, "Skill by room; blue is above the blank sheet"),),
        ),
    )
    lengths = skill_by_scans(context, plain, plan)
    return Section("dependence", "What depends on what", (*items, *lengths))


def _slope(x: Sequence[float], y: Sequence[float]) -> float:
    return float(np.polyfit(x, y, 1)[0]) if len(set(x)) > 1 else 0.0


def _maps(context: StudyContext, table: Table, plan: ArenaPlan) -> Section:
    methods = best_of_each(table)[:_MAP_ENTRIES]
    items = []
    # Without a method of its own there is nothing to show beside the truth.
    rooms = plan.rooms if methods else ()
    for room in rooms[:: max(1, len(plan.rooms) // _MAP_ROOMS)][:_MAP_ROOMS]:
        drive = DriveJob(room, plan.sonars[0], 0, plan.scans, plan.resolution_m)
        seen = seen_of(drive, context.folder.parent)
        cols = 5
        rows = math.ceil((len(methods) + 1) / cols)
        figure, panels = figure_with(rows, cols, width=2.3, height=2.4)
        show_truth(panels[0], seen.truth, seen.observable)
        panels[0].set_title("the truth", fontsize=8)
        for axes, entry in zip(panels[1:], methods, strict=False):
            _, method = entry.made()
            show_map(axes, method.map(seen.blind, seen.truth.grid))
            axes.set_title(entry.label, fontsize=8)
        for axes in panels:
            axes.set(xlabel="", ylabel="", xticks=[], yticks=[])
        for axes in panels[len(methods) + 1 :]:
            axes.axis("off")
        caption = f"{drive.label}: P(occupied), black is a wall; the best by skill first"
        items.append(
            Item(
                f"Maps of {room.name}",
                "what do the maps look like, side by side?",
                f"{len(methods)} methods on the same {plan.scans} scans.",
                (context.figure(room.name, figure, caption),),
            )
        )
    return Section("maps", "Maps", tuple(items))
