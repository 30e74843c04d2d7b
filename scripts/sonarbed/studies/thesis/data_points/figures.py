"""Figures of data points and estimated walls."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

import sonarmap as sm
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.studies.thesis.experiments import TARGET_DISTANCE_M
from sonarbed.studies.thesis.free_space import FreeSpace, plotted_points
from sonarbed.studies.thesis.plans import draw_outline, draw_points
from sonarmap.filters.hsr import EstimatedWalls, Mark, estimate_variant_walls

__all__ = ["SONAR", "es_picture", "estimated_walls", "plot", "scan_picture"]

# Figure 6.6: minWallSize 40 mm, maxWallSize 150 mm, Rth = Rmax.
_MIN_WALL_M, _MAX_WALL_M = 0.04, 0.15
# One sonar and every fifth scan: more would hide one wall behind the next.
SONAR, _EVERY = 1, 5
_PATH, _SONAR_COLOUR, _READING, _WALL = COLOURS[0], COLOURS[5], COLOURS[1], COLOURS[4]


def estimated_walls(log: sm.SonarLog) -> EstimatedWalls:
    """Return ES of a log at the parameters of figure 6.6."""
    params = sm.HsrParams(_MIN_WALL_M, _MAX_WALL_M, log.ring.range_max_m, TARGET_DISTANCE_M)
    return estimate_variant_walls(log, params)


def scan_picture(scan: sm.SonarLog, points_m: NDArray[np.float64], space: FreeSpace) -> Figure:
    """Draw one scan: robot, sonars and data points."""
    figure, (axes,) = figure_with(width=6.2, height=5.2)
    for sensor_m, point_m in zip(scan.sensor_xy_m[scan.range_m != -np.inf], points_m, strict=True):
        axes.plot(*np.transpose([sensor_m, point_m]), color="#999999", lw=0.8)
    axes.plot(*points_m.T, "o", color=_READING, ms=5, label="data point")
    axes.plot(*scan.sensor_xy_m.T, "s", color=_SONAR_COLOUR, ms=4, label="sonar")
    axes.plot(scan.x_m, scan.y_m, "^", color=_PATH, ms=7, label="robot")
    draw_outline(axes, space, _bounds(space), colour="#444444")
    _legend(axes)
    return figure


def plot(log: sm.SonarLog, space: FreeSpace) -> Figure:
    """Draw S: all data points with the trajectory, whole and close."""
    figure, panels = figure_with(1, 2, width=5.8, height=5.4)
    points_m = plotted_points(log)
    around = (*(points_m.min(axis=0) - 0.2), *(points_m.max(axis=0) + 0.2))
    for axes, bounds_m in zip(panels, (around, _bounds(space)), strict=True):
        draw_points(axes, points_m, colour=_READING, label="data points")
        axes.plot(log.x_m, log.y_m, color=_PATH, lw=1.2, label="robot's trajectory")
        draw_outline(axes, space, bounds_m, colour="#000000")
        _legend(axes)
    return figure


def es_picture(log: sm.SonarLog, space: FreeSpace) -> Figure:
    """Draw ES of one sonar, whole and close."""
    chosen = log.select((log.sonar == SONAR) & (log.scan % _EVERY == 0))
    es = estimated_walls(chosen)
    layers = (
        (_WALL, "estimated wall", _cells_with(es, Mark.WALL)),
        (_READING, "reading", _cells_with(es, Mark.READING)),
        (_SONAR_COLOUR, "sonar", chosen.sensor_xy_m),
        (_PATH, "robot", np.column_stack([chosen.x_m, chosen.y_m])),
    )
    # The part to look at closely is about the middle one of the readings with an echo.
    heard_m = chosen.point_xy_m[np.isfinite(chosen.range_m)]
    x_m, y_m = heard_m[len(heard_m) // 2]
    close = (x_m - 0.3, y_m - 0.3, x_m + 0.3, y_m + 0.3)
    figure, panels = figure_with(1, 2, width=5.8, height=5.4)
    for axes, bounds_m, size in zip(panels, (_bounds(space), close), (2.0, 7.0), strict=True):
        for colour, label, xy_m in layers:
            axes.plot(*xy_m.T, "s", ms=size, color=colour, label=label, mew=0, rasterized=True)
        draw_outline(axes, space, bounds_m, colour="#000000")
        _legend(axes)
    panels[0].add_patch(
        Rectangle((x_m - 0.3, y_m - 0.3), 0.6, 0.6, fill=False, color="#000000", ls=":")
    )
    return figure


def _cells_with(es: EstimatedWalls, mark: Mark) -> NDArray[np.float64]:
    return np.column_stack(es.grid.centre_of(*np.nonzero(es.marks == mark)))


def _bounds(space: FreeSpace) -> tuple[float, float, float, float]:
    x_min, y_min, x_max, y_max = space.polygon.bounds
    return x_min - 0.3, y_min - 0.3, x_max + 0.3, y_max + 0.3


def _legend(axes: Axes) -> None:
    axes.legend(
        fontsize=8,
        frameon=False,
        ncols=4,
        loc="lower center",
        bbox_to_anchor=(0.5, 1.0),
        markerscale=1.5,
    )
