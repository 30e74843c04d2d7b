"""The picture of HSR: data points before and after, on the walls that readings vouch for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

import sonarmap as sm
from sonarbed.pictures import legend_below, plan, save
from sonarmap.hsr import EstimatedWalls, Mark, estimate_variant_walls

__all__ = ["draw_hsr"]

# Okabe and Ito's palette: told apart by colour-blind people too.
_RIGHT, _WRONG, _MENDED, _STILL_WRONG, _UNKNOWN = (
    "#009E73",
    "#D55E00",
    "#0072B2",
    "#CC79A7",
    "#555555",
)
_MARGIN_M = 0.2


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
    judged = ~before.stale
    before, after = before.select(judged), result.log.select(judged)
    updated = result.updated[judged]
    figure = Figure(figsize=(14, 7.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    figure.suptitle(
        f"HSR: {int(updated.sum())} of {len(before)} readings updated in "
        f"{len(result.updates_per_pass)} passes",
        fontsize=13,
    )
    classes_before, classes_after = _classes(before, after, updated)
    for axes, log, title, classes in (
        (left, before, "before", classes_before),
        (right, after, "after", classes_after),
    ):
        _walls(axes, estimate_variant_walls(log, params))
        axes.plot(log.x_m, log.y_m, color="black", lw=0.8, label="path by odometry")
        for name, (rows, colour, size) in classes.items():
            points = log.point_xy_m[rows & np.isfinite(log.range_m)]
            label = f"{name}: {len(points)}"
            axes.plot(*points.T, ".", ms=size, mew=0, color=colour, label=label)
        silent = int(np.isposinf(log.range_m).sum())
        axes.set_title(f"{title} ({silent} readings without echo: not drawn)", fontsize=11)
        plan(axes)
        legend_below(axes)
    points_m = before.point_xy_m
    points_m = points_m[np.isfinite(points_m).all(axis=1)]
    (x_min, y_min), (x_max, y_max) = points_m.min(axis=0), points_m.max(axis=0)
    left.set_xlim(x_min - _MARGIN_M, x_max + _MARGIN_M)
    left.set_ylim(y_min - _MARGIN_M, y_max + _MARGIN_M)
    save(figure, path)


_Classes = dict[str, tuple[NDArray[np.bool_], str, float]]


def _classes(
    before: sm.SonarLog, after: sm.SonarLog, updated: NDArray[np.bool_]
) -> tuple[_Classes, _Classes]:
    """Return rows, colour and size of the points of each legend entry, before and after."""
    if before.truth is None:
        return (
            {"data points": (np.ones_like(updated), _UNKNOWN, 4)},
            {"not updated": (~updated, _UNKNOWN, 4), "updated": (updated, _MENDED, 6)},
        )
    score = sm.score_readings(before, after)
    wrong = score.is_wrong
    now_right = updated & ~score.is_spoiled & (~wrong | score.is_mended)
    return (
        {"right": (~wrong, _RIGHT, 4), "wrong": (wrong, _WRONG, 4)},
        {
            "right, not updated": (~wrong & ~updated, _RIGHT, 4),
            "wrong, not updated": (wrong & ~updated, _WRONG, 4),
            "updated, now wrong": (updated & ~now_right, _STILL_WRONG, 6),
            "updated, now right": (now_right, _MENDED, 6),
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
