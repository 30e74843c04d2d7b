"""Rooms, maps and data points seen from above, for the figures of studies."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from numpy.typing import NDArray

import worlds
from sonarbed.reporting.drawing import COLOURS
from sonarbed.studies.thesis.free_space import FreeSpace

__all__ = ["draw_cells", "draw_outline", "draw_points"]


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
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")


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
