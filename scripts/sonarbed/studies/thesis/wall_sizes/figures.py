"""Figures of the sweep over wall sizes: heat maps, maps beside the truth, openings."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import sonarmap as sm
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.pictures import show_map
from sonarbed.reporting.statistics import mean_of
from sonarbed.studies.thesis.experiments import Experiment
from sonarbed.studies.thesis.free_space import plotted_points
from sonarbed.studies.thesis.plans import draw_cells, draw_outline, draw_points
from sonarbed.studies.thesis.wall_sizes.findings import SCORE
from sonarbed.studies.thesis.wall_sizes.pairs import in_table_6_1, pair_name
from sonarbed.studies.thesis.wall_sizes.sweep import Room, Sweep

__all__ = ["heat_maps", "maps", "openings"]

# What the heat maps show: measure, title, and the factor and unit of its change.
_SHOWN = (
    ("map_score ignore", "Map Score, no echo ignored", 1.0, "bit a cell"),
    ("map_score clear", "Map Score, no echo clears", 1.0, "bit a cell"),
    ("f1 clear", "F1 within 10 cm, no echo clears", 100.0, "percentage points"),
    ("points f1", "plotted data points, F1 within 10 cm", 100.0, "percentage points"),
)
# How far around the drive the pictures reach: a little more than both rooms do.
_AROUND_M = 1.1


def heat_maps(sweeps: Mapping[str, Sweep]) -> Figure:
    """Draw the change of three measures over the pairs, a column for each sweep."""
    figure, axes = figure_with(len(_SHOWN), len(sweeps), width=7.2, height=2.9)
    for row, (measure, title, factor, unit) in enumerate(_SHOWN):
        for col, (name, sweep) in enumerate(sweeps.items()):
            on = axes[row * len(sweeps) + col]
            _heat_map(on, sweep, measure, factor, unit)
            on.set_title(f"{title}: {name}", fontsize=9)
    return figure


def _heat_map(axes: Axes, sweep: Sweep, measure: str, factor: float, unit: str) -> None:
    lows = sorted({low for low, _ in sweep.pairs})
    highs = sorted({high for _, high in sweep.pairs})
    where = [(lows.index(low), highs.index(high)) for low, high in sweep.pairs]
    shape = (len(lows), len(highs))
    values, inside = np.full(shape, np.nan), np.zeros(shape, bool)
    changes = sweep.changes(measure)
    for cell, change, within in zip(where, changes, in_table_6_1(sweep.pairs), strict=True):
        values[cell] = change.value * factor
        inside[cell] = within
    most = max(float(np.nanmax(np.abs(values))), 1e-12)
    image = axes.imshow(values, cmap="RdBu", vmin=-most, vmax=most, origin="lower", aspect="auto")
    decided = np.array([cell for cell, change in zip(where, changes, strict=True) if change.sign])
    if decided.size:
        axes.plot(decided[:, 1], decided[:, 0], ".", color="black", ms=2)
    row, col = where[sweep.best(measure)]
    axes.plot(col, row, "*", color=COLOURS[4], mec="black", mew=0.7, ms=13)
    _border(axes, inside)
    axes.set_xticks(range(len(highs)), [str(high) for high in highs], rotation=90, fontsize=7)
    axes.set_yticks(range(len(lows)), [str(low) for low in lows], fontsize=7)
    axes.set_xlabel("max wall, mm", fontsize=8)
    axes.set_ylabel("min wall, mm", fontsize=8)
    colours = axes.figure.colorbar(image, ax=axes, pad=0.01)
    colours.set_label(f"change, {unit}", fontsize=8)
    colours.ax.tick_params(labelsize=7)


def _border(axes: Axes, inside: NDArray[np.bool_]) -> None:
    """Draw the line between the cells inside of a region and the others."""
    padded = np.pad(inside, 1)
    for row, col in np.argwhere(padded[:, 1:] != padded[:, :-1]):
        axes.plot([col - 0.5] * 2, [row - 1.5, row - 0.5], color="black", lw=2)
    for row, col in np.argwhere(padded[1:] != padded[:-1]):
        axes.plot([col - 1.5, col - 0.5], [row - 0.5] * 2, color="black", lw=2)


def maps(experiment: Experiment, room: Room, log: sm.SonarLog, sweep: Sweep) -> Figure:
    """Draw the truth, the map without HSR, and maps after HSR with several pairs.

    The upper half shows maps (no echo clears), the lower one the data points as plotted.
    """
    best = sweep.pairs[sweep.best(SCORE)]
    largest = sweep.pairs[-1]
    chosen = {
        experiment.thesis: "the thesis's",
        **dict.fromkeys(experiment.shown, "also the thesis's"),
        best: "the sweep's best",
        largest: "too large",
    }
    logs = {"without HSR": log}
    for pair, why in sorted(chosen.items()):
        repaired = sm.hsr(log, experiment.params(pair, log.ring)).log
        logs[f"{pair_name(pair)}, {why}"] = repaired
    cols = (len(logs) + 2) // 2
    figure, axes = figure_with(4, cols, width=3.4, height=3.0)
    _panels(axes[: 2 * cols], room, log, logs, _draw_map)
    _panels(axes[2 * cols :], room, log, logs, _draw_plot)
    return figure


def _panels(
    axes: list[Axes],
    room: Room,
    log: sm.SonarLog,
    logs: Mapping[str, sm.SonarLog],
    draw: Callable[[Axes, Room, sm.SonarLog], None],
) -> None:
    x_min, y_min = log.sensor_xy_m.min(axis=0) - _AROUND_M
    x_max, y_max = log.sensor_xy_m.max(axis=0) + _AROUND_M
    draw_cells(axes[0], room.truth)
    axes[0].set_title("truth", fontsize=9)
    for panel, (name, shown) in zip(axes[1:], logs.items(), strict=False):
        draw(panel, room, shown)
        panel.set_title(name, fontsize=9)
    for panel in axes[: len(logs) + 1]:
        draw_outline(panel, room.space, (x_min, y_min, x_max, y_max))
    for panel in axes[len(logs) + 1 :]:
        panel.axis("off")


def _draw_map(axes: Axes, room: Room, log: sm.SonarLog) -> None:
    show_map(axes, room.map_of(log, "clear"))


def _draw_plot(axes: Axes, room: Room, log: sm.SonarLog) -> None:
    draw_points(axes, plotted_points(log))


def openings(experiment: Experiment, sweep: Sweep) -> Figure:
    """Draw what becomes of the openings and the glass over the largest wall size."""
    figure, (left, right) = figure_with(1, 2, width=6.2)
    highs = sorted({high for _, high in sweep.pairs})
    for colour, opening in zip(COLOURS, experiment.openings, strict=False):
        _over_largest(left, sweep, f"{opening.name} occupied clear", highs, colour, opening.name)
    left.set_ylabel("share of the opening's cells mapped occupied, %")
    if experiment.glass is not None:
        _over_largest(right, sweep, "glass clear", highs, COLOURS[0], "glass wall found")
    _over_largest(right, sweep, "mended", highs, COLOURS[2], "wrong readings mended")
    _over_largest(right, sweep, "spoiled", highs, COLOURS[1], "right readings spoiled")
    right.set_ylabel("share, %")
    for axes in (left, right):
        axes.set_xlabel("max wall, mm (dotted: without HSR)")
        axes.set_ylim(-2, 102)
        axes.legend(
            fontsize=8, frameon=False, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0)
        )
    return figure


def _over_largest(
    axes: Axes, sweep: Sweep, measure: str, highs: list[int], colour: str, label: str
) -> None:
    largest = np.array([high for _, high in sweep.pairs])
    found = [sweep.mean_over(measure, largest == high) for high in highs]
    axes.plot(highs, [100 * f.value for f in found], color=colour, label=label)
    axes.fill_between(
        highs, [100 * f.low for f in found], [100 * f.high for f in found], color=colour, alpha=0.2
    )
    before = mean_of(sweep.before[measure])
    if np.isfinite(before.value):
        axes.axhline(100 * before.value, color=colour, ls=":", lw=1.2)
