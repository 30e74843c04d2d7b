"""The picture of HSR: data points before and after, on the walls that readings vouch for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

import sonarmap as sm
from sonarbed.reporting.drawing import COLOURS, save
from sonarbed.reporting.pictures import plan
from sonarmap.filters.hsr import EstimatedWalls, Mark, estimate_variant_walls

__all__ = ["draw_hsr"]

_MENDED, _WRONG, _RIGHT, _STILL_WRONG = COLOURS[:4]
_UNKNOWN = "#555555"
_MARGIN_M = 0.2
_POINT = 4
# Inches: the width of a plan, and the height of titles, axis label and legend.
_PANEL_IN, _TEXT_IN = 6.5, 1.5


def draw_hsr(before: sm.SonarLog, result: sm.HsrResult, params: sm.HsrParams, path: Path) -> None:
    """Draw the data points before and after HSR, at the poses of odometry.

    With truth, points are coloured by whether they are right; without, by whether HSR updated
    them. Behind them are the estimated walls of the log that is drawn.

    Parameters
    ----------
    before : SonarLog
        The log that HSR was given.
    result : HsrResult
        What it made of it.
    params : HsrParams
        Its parameters.
    path : Path
        The file to write.
    """
    walls = [estimate_variant_walls(log, params) for log in (before, result.log)]
    judged = before.usable
    before, after = before.select(judged), result.log.select(judged)
    updated = result.updated[judged]
    (x_min, y_min), (x_max, y_max) = _extent_m(before)
    # As high as the plan asks: axes of equal scale would leave a gap, or cover the titles.
    height = _PANEL_IN * np.clip((y_max - y_min) / (x_max - x_min), 0.25, 1.5) + _TEXT_IN
    figure = Figure(figsize=(2 * _PANEL_IN + 1, height), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    figure.suptitle(
        f"HSR: {int(updated.sum())} of {len(before)} readings updated in "
        f"{len(result.updates_per_pass)} passes (grey: estimated walls)",
        fontsize=13,
    )
    classes_before, classes_after = _classes(before, after, updated)
    for axes, log, title, classes, es in (
        (left, before, "before", classes_before, walls[0]),
        (right, after, "after", classes_after, walls[1]),
    ):
        _walls(axes, es)
        axes.plot(log.x_m, log.y_m, color="black", lw=0.8, label="path by odometry")
        for name, (rows, colour) in classes.items():
            points = log.point_xy_m[rows & np.isfinite(log.range_m)]
            label = f"{name}: {len(points)}"
            axes.plot(*points.T, ".", ms=_POINT, mew=0, color=colour, label=label)
        silent = int(np.isposinf(log.range_m).sum())
        axes.set_title(f"{title} ({silent} readings without echo: not drawn)", fontsize=11)
        plan(axes)
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(
            handles,
            labels,
            loc="outside lower left" if axes is left else "outside lower right",
            ncols=3,
            fontsize=9,
            markerscale=2.5,
            frameon=False,
        )
    left.set_xlim(x_min, x_max)
    left.set_ylim(y_min, y_max)
    save(figure, path)


_Classes = dict[str, tuple[NDArray[np.bool_], str]]


def _extent_m(log: sm.SonarLog) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the lower left and upper right corner of what is drawn."""
    places_m = np.concatenate([log.point_xy_m, np.column_stack([log.x_m, log.y_m])])
    places_m = places_m[np.isfinite(places_m).all(axis=1)]
    return places_m.min(axis=0) - _MARGIN_M, places_m.max(axis=0) + _MARGIN_M


def _classes(
    before: sm.SonarLog, after: sm.SonarLog, updated: NDArray[np.bool_]
) -> tuple[_Classes, _Classes]:
    """Return rows and colour of the points of each legend entry, before and after."""
    if before.truth is None:
        return (
            {"data points": (np.ones_like(updated), _UNKNOWN)},
            {"not updated": (~updated, _UNKNOWN), "updated": (updated, _MENDED)},
        )
    score = sm.score_readings(before, after)
    wrong = score.is_wrong
    now_right = updated & ~score.is_spoiled & (~wrong | score.is_mended)
    return (
        {"right": (~wrong, _RIGHT), "wrong": (wrong, _WRONG)},
        {
            "right, not updated": (~wrong & ~updated, _RIGHT),
            "wrong, not updated": (wrong & ~updated, _WRONG),
            "updated, now right": (now_right, _MENDED),
            "updated, now wrong": (updated & ~now_right, _STILL_WRONG),
        },
    )


def _walls(axes: Axes, es: EstimatedWalls) -> None:
    shown = (es.marks == Mark.WALL) | (es.marks == Mark.READING)
    axes.imshow(
        shown,
        cmap=ListedColormap(["#FFFFFF", "#DCDCDC"]),
        vmin=0,
        vmax=1,
        origin="lower",
        extent=es.grid.extent_m,
        interpolation="nearest",
    )
