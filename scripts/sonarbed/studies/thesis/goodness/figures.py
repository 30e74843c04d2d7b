"""Figures of the search over parameter sets."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

import worlds
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.statistics import Estimate
from sonarbed.studies.thesis.goodness.choices import FirstBar, first_bar
from sonarbed.studies.thesis.goodness.search import MEASURES, TRUTHS, RoomSearch
from sonarbed.studies.thesis.plans import TitledMap, draw_observable_truth, draw_titled_map

__all__ = ["draw_chosen", "draw_histograms", "draw_rankings", "draw_scatter"]


def draw_histograms(searches: Sequence[RoomSearch]) -> Figure:
    """Draw the histogram of VSDNS of every room, its first bar marked."""
    figure, panels = figure_with(1, len(searches), width=3.6, height=3.4)
    for axes, found in zip(panels, searches, strict=True):
        bar: FirstBar = first_bar(found.mean("vsdns"))
        colours = [COLOURS[1]] + [COLOURS[0]] * (bar.counts.size - 1)
        axes.bar(
            bar.edges[:-1],
            bar.counts,
            np.diff(bar.edges),
            align="edge",
            color=colours,
            edgecolor="white",
        )
        axes.set_title(f"{found.room}: {bar.counts[0]} sets in the first bar", fontsize=10)
        axes.set_xlabel("VSDNS")
        axes.set_ylabel("parameter sets")
    return figure


def draw_chosen(
    truth: worlds.TruthGrid, observable: NDArray[np.bool_], examples: Sequence[TitledMap]
) -> Figure:
    """Draw the truth and the maps of the chosen sets."""
    cols = 4
    figure, axes = figure_with(math.ceil((len(examples) + 1) / cols), cols, width=3.9, height=3.8)
    draw_observable_truth(axes[0], truth, observable)
    for panel, example in zip(axes[1:], examples, strict=False):
        draw_titled_map(panel, example, font_size=9)
    for panel in axes[len(examples) + 1 :]:
        panel.axis("off")
    figure.colorbar(axes[1].images[0], ax=axes, shrink=0.5, label="P(occupied)")
    return figure


def draw_scatter(searches: Sequence[RoomSearch]) -> Figure:
    """Draw each measure against the true Map Score: a row a measure, a column a room."""
    measures = MEASURES[:3]
    figure, panels = figure_with(len(measures), len(searches), width=3.5, height=2.7, sharey="col")
    for row, measure in enumerate(measures):
        for col, found in enumerate(searches):
            axes = panels[row * len(searches) + col]
            points = axes.scatter(
                found.mean(measure.name),
                found.mean("map_score"),
                c=np.degrees([m.p5_rad for m in found.sets]),
                cmap="viridis",
                s=5,
                lw=0,
            )
            axes.set_xlabel(measure.title)
            axes.xaxis.set_major_locator(MaxNLocator(4))
            if row == 0:
                axes.set_title(found.room, fontsize=10)
            if col == 0:
                axes.set_ylabel("true Map Score, bit")
            # What the measure calls good is at the right.
            if measure.good < 0:
                axes.invert_xaxis()
    figure.colorbar(points, ax=panels, shrink=0.5, label="P5, degrees")
    return figure


def draw_rankings(
    rooms: Sequence[str], rankings: Mapping[tuple[str, str, str], Estimate]
) -> Figure:
    """Draw the rank correlations with intervals; keys are (room, measure, true score)."""
    figure, panels = figure_with(1, len(TRUTHS), width=6.2, height=4.2, sharey=True)
    markers = ("o", "s", "^", "D")
    for axes, truth in zip(panels, TRUTHS, strict=True):
        for index, measure in enumerate(MEASURES):
            shift = 0.18 * (index - (len(MEASURES) - 1) / 2)
            found = [rankings[room, measure.name, truth.name] for room in rooms]
            value = np.array([e.value for e in found])
            reach = np.nan_to_num([e.high - e.value for e in found])
            axes.errorbar(
                value,
                np.arange(len(rooms)) + shift,
                xerr=reach,
                fmt=markers[index],
                color=COLOURS[index],
                ms=5,
                capsize=3,
                label=measure.title,
            )
        axes.axvline(0, color="#666666", lw=0.8)
        axes.set_xlim(-1.05, 1.05)
        axes.set_yticks(range(len(rooms)), list(rooms))
        axes.set_xlabel(f"rank correlation with the true {truth.title}")
        axes.grid(axis="x", color="#DDDDDD", lw=0.6)
    panels[0].invert_yaxis()
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(MEASURES), frameon=False)
    figure.supxlabel("ranks against the truth  ←      →  ranks as the truth does", fontsize=10)
    return figure
