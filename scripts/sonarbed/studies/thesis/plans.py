"""Rooms, maps and data points seen from above, for the figures of studies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.reporting.drawing import COLOURS
from sonarbed.reporting.pictures import plan, show_map, show_truth
from sonarbed.studies.thesis.free_space import FreeSpace

__all__ = [
    "TitledMap",
    "draw_cells",
    "draw_observable_truth",
    "draw_outline",
    "draw_points",
    "draw_titled_map",
]


@dataclass(frozen=True, eq=False)
class TitledMap:
    """A map and what is written above it."""

    title: str
    map: sm.OccupancyMap


def draw_titled_map(axes: Axes, example: TitledMap, *, font_size: int = 10) -> None:
    """Draw a map with its title: white free, black occupied."""
    show_map(axes, example.map)
    axes.set_title(example.title, fontsize=font_size)


def draw_observable_truth(
    axes: Axes, truth: worlds.TruthGrid, observable: NDArray[np.bool_]
) -> None:
    """Draw the truth with a title: lighter where nothing was observable."""
    show_truth(axes, truth, observable)
    axes.set_title("truth", fontsize=10)


def draw_outline(
    axes: Axes,
    space: FreeSpace,
    bounds_m: tuple[float, float, float, float],
    *,
    colour: str = COLOURS[1],
) -> None:
    """Draw the surfaces of a room, and show the part of the plane within the bounds."""
    for ring in (space.polygon.exterior, *space.polygon.interiors):
        axes.plot(*np.array(ring.coords).T, color=colour, lw=0.8)
    x_min, y_min, x_max, y_max = bounds_m
    axes.set_xlim(x_min, x_max)
    axes.set_ylim(y_min, y_max)
    plan(axes)


def draw_cells(axes: Axes, truth: worlds.TruthGrid) -> None:
    """Draw the true cells: free white, occupied black, hidden grey."""
    axes.imshow(
        truth.state,
        cmap=ListedColormap(["#FFFFFF", "#000000", "#B0B0B0"]),
        vmin=0,
        vmax=2,
        origin="lower",
        extent=truth.grid.extent_m,
        interpolation="nearest",
    )


def draw_points(
    axes: Axes, points_m: NDArray[np.float64], *, colour: str = "#000000", label: str | None = None
) -> None:
    """Draw data points as dots."""
    axes.plot(*points_m.T, ".", ms=1.5, color=colour, label=label, rasterized=True)
