"""The card of a data set: what is in it, in words, tables and pictures."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import PathPatch
from matplotlib.path import Path as Outline

import worlds
from sim.datasets.making import DatasetReport, write_text
from sim.datasets.manifest import CAUSES, DatasetSummary
from sim.datasets.plan import Plan
from sim.datasets.spec import SPLITS
from sim.datasets.values import Drawn, Each, Fixed, Value
from sim.runs.jobs import Store
from sonarbed.reporting.drawing import figure_with, save
from sonarbed.reporting.wording import cause_name
from sonarmap import Cause, read_log
from worlds.colours import CAUSE_COLOURS, WALL_COLOUR

__all__ = ["CARD", "write_card"]

CARD = "README.md"
_ROOMS_DRAWN = 9


def write_card(store: Store, plan: Plan, report: DatasetReport) -> None:
    """Write the card and its pictures beside the logs."""
    if plan.spec.pictures:
        _draw_rooms(store, plan)
        _draw_causes(store, report.summary)
    write_text(store, CARD, _text(plan, report))


def _text(plan: Plan, report: DatasetReport) -> str:
    spec, summary = plan.spec, report.summary
    splits = [split for split in SPLITS if summary.logs[split]]
    lines = [
        f"# {spec.name}",
        "",
        spec.description or "Simulated sonar logs with the truth of every reading.",
        "",
        _size(summary)
        + f" Made by sonarbed {plan.identity['sonarbed']} with seed {spec.seed}; simulated, not "
        "measured.",
        "",
    ]
    if spec.pictures:
        lines += ["![Rooms with a log in each](card/rooms.png)", ""]
        lines += ["![Share of each cause](card/causes.png)", ""]
    lines += ["## Splits", "", "By room: no room is in two of them.", ""]
    lines += _table(
        ["split", "rooms", "logs", "scans", "readings"],
        [
            [
                split,
                *(
                    f"{counts[split]:,}"
                    for counts in (summary.rooms, summary.logs, summary.scans, summary.readings)
                ),
            ]
            for split in splits
        ],
    )
    lines += ["", "## Why readings say what they say", ""]
    names = [cause_name(cause) for cause in Cause]
    lines += _table(["split", *names], [[s, *_shares(summary.causes[s])] for s in splits])
    lines += [""]
    lines += _table(
        ["sonar", "driver", *names],
        [[*group, *_shares(counts)] for group, counts in sorted(summary.groups.items())],
    )
    lines += [
        "",
        "The first three are right, the last three wrong: see `sonarmap.Cause`.",
        "",
        "## How it was made",
        "",
        *_table(["key", "value"], [[f"`{k}`", _words(v)] for k, v in plan.values.items()]),
        "",
        "What was drawn for each log is in the column `settings` of `manifest.parquet`.",
    ]
    if report.failed:
        lines += [
            "",
            f"{report.failed} rooms or logs could not be made"
            + (f", and {report.without_room} logs had no room" if report.without_room else "")
            + ": `failures.jsonl` says why.",
        ]
    lines += ["", *_use(spec.name)]
    about = {
        "licence": spec.license,
        "by": spec.creator,
        "from": spec.url,
        "date": spec.date,
        "cite as": spec.citation,
    }
    lines += [f"- {key}: {value}" for key, value in about.items() if value]
    return "\n".join(lines).rstrip() + "\n"


def _size(summary: DatasetSummary) -> str:
    return (
        f"{sum(summary.logs.values()):,} logs in {sum(summary.rooms.values()):,} rooms: "
        f"{sum(summary.scans.values()):,} scans, {sum(summary.readings.values()):,} readings, "
        f"{summary.duration_s / 3600:,.1f} hours of driving."
    )


def _use(name: str) -> list[str]:
    return [
        "## Use",
        "",
        "```python",
        "import sonarmap as sm",
        "",
        "# For a DataLoader as it is.",
        f'train = sm.SonarDataset("{name}", split="train", window=256)',
        "",
        "import polars",
        "",
        f'polars.scan_parquet("{name}/logs/**/*.parquet", hive_partitioning=True)',
        "```",
        "",
        "`logs/` is one table, a row a reading (columns `truth_*`: what was true; `log`: which",
        "log), `manifest.parquet` has a row a log, `rooms/` the rooms, `croissant.json` says the",
        "same to machines. A file of `logs/` is a log for `sonarmap.read_log` and every command.",
        "",
    ]


def _table(header: list[str], rows: list[list[str]]) -> list[str]:
    return [
        f"| {' | '.join(header)} |",
        f"|{'---|' * len(header)}",
        *(f"| {' | '.join(row)} |" for row in rows),
    ]


def _shares(counts: Counter[str]) -> list[str]:
    total = max(sum(counts.values()), 1)
    return [f"{counts[cause] / total:.1%}" for cause in CAUSES]


def _words(value: Value) -> str:
    match value:
        case Fixed():
            return f"{value.value}"
        case Each():
            return "each of " + _listed(value.values)
        case Drawn(distribution="choice"):
            return "one of " + _listed(value.parameters)
        case Drawn():
            low, high = value.parameters
            within = f" within {value.within[0]:g} and {value.within[1]:g}" if value.within else ""
            return f"{value.distribution.replace('_', ' ')} ({low:g}, {high:g}){within}"
    return json.dumps(dataclasses.asdict(value))  # type: ignore[call-overload]


def _listed(values: tuple[object, ...]) -> str:
    shown = ", ".join(str(value) for value in values[:20])
    return shown if len(values) <= 20 else f"{shown} and {len(values) - 20} more"


def _draw_rooms(store: Store, plan: Plan) -> None:
    """Draw the first rooms, each with the data points of its first log."""
    there = (room for room in plan.rooms() if store.has(room.file))
    rooms = list(islice(there, _ROOMS_DRAWN))
    cols = min(3, len(rooms))
    figure, axes = figure_with(-(-len(rooms) // cols), cols, width=3.4, height=3.0)
    for each in axes:
        each.set_axis_off()
    with TemporaryDirectory(prefix="sonarbed-") as folder:
        for room, each in zip(rooms, axes, strict=False):
            path = Path(folder) / f"{room.name}.toml"
            _copy(store, room.file, path)
            _draw_walls(each, worlds.load(path))
            job = next(plan.logs_of(room))
            if store.has(job.outputs[0]):
                log_path = Path(folder) / "log.parquet"
                _copy(store, job.outputs[0], log_path)
                log = read_log(log_path)
                truth = log.require_truth("a picture")
                points = log.at_true_poses().point_xy_m
                for cause in Cause:
                    chosen = points[(truth.cause == cause) & np.isfinite(points[:, 0])]
                    each.plot(*chosen.T, ".", ms=2, color=CAUSE_COLOURS[cause])
            each.set_title(f"{room.name} ({plan.split_of(room)})", fontsize=8)
    with store.writing("card/rooms.png") as beside:
        save(figure, beside)


def _draw_walls(axes: Axes, world: worlds.World) -> None:
    for solid in world.solids:
        rings = [solid.outline.exterior, *solid.outline.interiors]
        outline = Outline.make_compound_path(
            *(Outline(np.array(ring.coords), closed=True) for ring in rings)
        )
        axes.add_patch(PathPatch(outline, facecolor=WALL_COLOUR, edgecolor=WALL_COLOUR, lw=0.8))
    x_min, y_min, x_max, y_max = world.bounds_m
    axes.set(xlim=(x_min, x_max), ylim=(y_min, y_max), aspect="equal")


def _draw_causes(store: Store, summary: DatasetSummary) -> None:
    splits = [split for split in SPLITS if summary.logs[split]]
    figure, (axes,) = figure_with(width=7.0, height=1.2 + 0.4 * len(splits))
    left = np.zeros(len(splits))
    totals = np.array([max(sum(summary.causes[s].values()), 1) for s in splits])
    for cause, name in zip(Cause, CAUSES, strict=True):
        share = np.array([summary.causes[s][name] for s in splits]) / totals
        colour = CAUSE_COLOURS[cause]
        axes.barh(splits, share, left=left, color=colour, label=cause_name(cause))
        left += share
    axes.invert_yaxis()
    axes.set_xlim(0, 1)
    axes.set_xlabel("share of the readings")
    figure.legend(loc="outside upper center", ncols=6, fontsize=7, frameon=False)
    with store.writing("card/causes.png") as beside:
        save(figure, beside)


def _copy(store: Store, name: str, path: Path) -> None:
    with store.reading(name) as file:
        path.write_bytes(file.read())
