"""Figures of the comparison of the two sensor models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.reporting import pictures
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.statistics import Estimate

__all__ = ["Example", "draw_differences", "draw_maps", "draw_truth", "show_map"]

# Free, occupied, hidden; then the same where nothing could be observed.
_TRUTH_COLOURS = ListedColormap(["#FFFFFF", "#000000", "#9A9A9A", "#E8EEF4", "#B8C4D0", "#C8C8C8"])
_MARKERS = ("o", "s", "^", "D")


@dataclass(frozen=True, eq=False)
class Example:
    """A map and what is written above it."""

    title: str
    map: sm.OccupancyMap


def draw_truth(axes: Axes, truth: worlds.TruthGrid, observable: NDArray[np.bool_]) -> None:
    """Draw the truth, lighter where nothing was observable."""
    shown = truth.state.astype(float) + np.where(observable, 0, 3)
    axes.imshow(
        shown,
        cmap=_TRUTH_COLOURS,
        vmin=-0.5,
        vmax=5.5,
        origin="lower",
        extent=truth.grid.extent_m,
        interpolation="nearest",
    )
    axes.set_title("truth", fontsize=10)
    _plan(axes)


def show_map(axes: Axes, example: Example) -> None:
    """Draw a map with its title: white free, black occupied."""
    pictures.show_map(axes, example.map)
    axes.set_title(example.title, fontsize=10)
    _plan(axes)


def draw_maps(
    truth: worlds.TruthGrid, observable: NDArray[np.bool_], examples: Sequence[Example]
) -> Figure:
    """Draw the truth at the left, then rows of two maps."""
    figure, axes = figure_with(len(examples) // 2, 3, width=4.2, height=3.8)
    draw_truth(axes[0], truth, observable)
    for row in range(len(examples) // 2):
        if row:
            axes[3 * row].axis("off")
        show_map(axes[3 * row + 1], examples[2 * row])
        show_map(axes[3 * row + 2], examples[2 * row + 1])
    figure.colorbar(axes[1].images[0], ax=axes, shrink=0.5, label="P(occupied)")
    return figure


def draw_differences(
    scores: Sequence[tuple[str, int]],
    by_score: Sequence[Sequence[Mapping[str, Estimate]]],
    series: Sequence[str],
) -> Figure:
    """Draw differences with intervals: a panel a score, a row a room, a marker a series."""
    figure, panels = figure_with(1, len(scores), width=14.4 / len(scores), height=4.6, sharey=True)
    for axes, (title, better), groups in zip(panels, scores, by_score, strict=True):
        for index, (name, by_room) in enumerate(zip(series, groups, strict=True)):
            shift = 0.26 * (index - (len(series) - 1) / 2)
            value = np.array([e.value for e in by_room.values()])
            low, high = (
                np.nan_to_num([getattr(e, side) - e.value for e in by_room.values()])
                for side in ("low", "high")
            )
            axes.errorbar(
                value,
                np.arange(value.size) + shift,
                xerr=np.abs([low, high]),
                fmt=_MARKERS[index],
                color=COLOURS[index],
                ms=5,
                capsize=3,
                label=name,
            )
        axes.axvline(0, color="#666666", lw=0.8)
        axes.set_yticks(range(len(groups[0])), list(groups[0]))
        axes.set_xlabel(f"difference of {title}")
        axes.grid(axis="x", color="#DDDDDD", lw=0.6)
        if better < 0:
            axes.invert_xaxis()
    panels[0].invert_yaxis()
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(series), frameon=False)
    figure.supxlabel("worse  ←  the parameterised model is  →  better", fontsize=10)
    return figure


def _plan(axes: Axes) -> None:
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
