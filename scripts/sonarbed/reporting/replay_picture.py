"""The picture of a log beside its simulation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import worlds
from sim.runs.replay import CLOSE_M, Replay
from sonarbed.reporting.drawing import COLOURS, save
from sonarbed.reporting.pictures import draw_solids, plan
from worlds.colours import PATH_COLOUR

__all__ = ["draw_replay"]

_ALIKE_M = CLOSE_M[-1]
_REAL_COLOUR, _OUR_COLOUR = "#9A9A9A", COLOURS[0]
# Of a hundred thousand points nobody sees more than of these.
_MOST_POINTS = 4000


def draw_replay(world: worlds.World, told: Replay, path: Path) -> None:
    """Draw where readings agree, silence by sonar, and the ranges against one another."""
    figure = Figure(figsize=(13, 8.5), layout="constrained")
    room, silence, ranges = figure.subplot_mosaic(
        [["room", "silence"], ["room", "ranges"]], width_ratios=[1.5, 1]
    ).values()
    poses = "odometry" if told.poses == "odometry" else "the truth"
    figure.suptitle(
        f"A log in {world.name} beside its simulation from the same poses, by {poses}:\n"
        f"echo or silence agrees in {told.agreement:.0%}, "
        f"ranges within {100 * _ALIKE_M:.0f} cm in {told.within(_ALIKE_M):.0%}",
        fontsize=12,
    )
    _readings(room, world, told)
    _silence(silence, told)
    _ranges(ranges, told)
    save(figure, path)


def _readings(axes: Axes, world: worlds.World, told: Replay) -> None:
    draw_solids(axes, world)
    log = told.log.at_true_poses() if told.poses == "true" else told.log
    axes.plot(log.x_m, log.y_m, color=PATH_COLOUR, lw=1)
    points, (real, simulated) = log.point_xy_m, told.silent
    alike = told.both_measured.copy()
    alike[alike] = np.abs(told.log.range_m[alike] - told.simulated.range_m[alike]) <= _ALIKE_M
    kinds = (
        ("alike", alike, COLOURS[2], "."),
        ("echo in both, ranges differ", told.both_measured & ~alike, COLOURS[1], "x"),
        ("echo, simulated silent", ~real & simulated, COLOURS[3], "+"),
    )
    for name, rows, colour, mark in kinds:
        label = f"{name} {rows.mean():.0%}"
        axes.plot(*points[_some(rows)].T, mark, ms=4, mew=0.8, color=colour, label=label)
    # A silent reading has no point: where the simulated echo of it comes from.
    lost = log.replace(range_m=told.simulated.range_m)
    rows = real & ~simulated
    axes.plot(
        *lost.point_xy_m[_some(rows)].T, "o", ms=3.5, mfc="none", mew=0.7, color=COLOURS[4],
        label=f"silent, simulated echo {rows.mean():.0%}",
    )  # fmt: skip
    plan(axes)
    axes.legend(
        loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=2, fontsize=9, frameon=False
    )  # fmt: skip


def _silence(axes: Axes, told: Replay) -> None:
    real, simulated = told.silence_by_sonar()
    place = np.arange(len(real))
    axes.bar(place - 0.2, real, 0.38, color=_REAL_COLOUR, label="log")
    axes.bar(place + 0.2, simulated, 0.38, color=_OUR_COLOUR, label="simulated")
    axes.set(title="no echo, by sonar", xlabel="sonar", ylabel="share of its readings", ylim=(0, 1))
    axes.set_xticks(place)
    axes.legend(fontsize=9, frameon=False)


def _ranges(axes: Axes, told: Replay) -> None:
    rows = _some(told.both_measured)
    far_m = told.log.ring.range_max_m
    axes.plot([0, far_m], [0, far_m], color="#888888", lw=1, zorder=0)
    axes.plot(
        told.simulated.range_m[rows],
        told.log.range_m[rows],
        ".",
        ms=3,
        color=_OUR_COLOUR,
        alpha=0.5,
    )
    axes.set(
        title="ranges", xlabel="simulated, m", ylabel="log, m", xlim=(0, far_m), ylim=(0, far_m)
    )
    axes.set_aspect("equal")


def _some(rows: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Return the numbers of rows, at most as many as can be seen."""
    chosen = np.flatnonzero(rows)
    return chosen[:: max(1, -(-chosen.size // _MOST_POINTS))]
