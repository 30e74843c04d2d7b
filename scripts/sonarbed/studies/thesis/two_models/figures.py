"""Figures of the comparison of the two sensor models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

import worlds
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.statistics import Estimate
from sonarbed.studies.thesis.plans import TitledMap, draw_observable_truth, draw_titled_map

__all__ = ["draw_differences", "draw_maps"]

_MARKERS = ("o", "s", "^", "D")


def draw_maps(
    truth: worlds.TruthGrid, observable: NDArray[np.bool_], examples: Sequence[TitledMap]
) -> Figure:
    """Draw the truth at the left, then rows of two maps."""
    figure, axes = figure_with(len(examples) // 2, 3, width=4.2, height=3.8)
    draw_observable_truth(axes[0], truth, observable)
    for row in range(len(examples) // 2):
        if row:
            axes[3 * row].axis("off")
        draw_titled_map(axes[3 * row + 1], examples[2 * row])
        draw_titled_map(axes[3 * row + 2], examples[2 * row + 1])
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
    figure.supxlabel("worse  ←  the parameterized model is  →  better", fontsize=10)
    return figure
