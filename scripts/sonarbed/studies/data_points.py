"""Figures 6.2, 6.4 and 6.6: readings as data points, the plot S, and the estimated walls ES."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.studies.drawing import COLOURS, figure_with
from sonarbed.studies.free_space import NEAR_M, FreeSpace, plotted_points
from sonarbed.studies.plans import draw_outline, draw_points
from sonarbed.studies.section import Item, Section
from sonarbed.studies.setting import Setting
from sonarbed.studies.statistics import mean_of
from sonarbed.studies.wall_pairs import TARGET_DISTANCE_M
from sonarmap.hsr import NO_ECHO_M, EstimatedWalls, Mark, estimate_variant_walls

__all__ = ["Shares", "run", "shares_near"]

_ROOM = "thesis-exp1"
# Figure 6.6: minWallSize 40 mm, maxWallSize 150 mm, Rth = Rmax.
_MIN_WALL_M, _MAX_WALL_M = 0.04, 0.15
# One sonar and every fifth scan: more would hide one wall behind the next.
_SONAR, _EVERY = 1, 5
_PATH, _SONAR_COLOUR, _READING, _WALL = COLOURS[0], COLOURS[5], COLOURS[1], COLOURS[4]


@dataclass(frozen=True, slots=True)
class Shares:
    """Shares of a drive's points and cells within 0.1 m of a surface.

    Parameters
    ----------
    points, echoes : float
        Of all data points, and of those of an echo.
    by_cause : dict
        Of the data points of each `Cause` that occurs.
    walls : float
        Of the cells of ES that hold an estimated wall.
    """

    points: float
    echoes: float
    by_cause: dict[sm.Cause, float]
    walls: float


def run(setting: Setting) -> Section:
    """Plot the readings of drives in the first room and the walls HSR estimates from them."""
    logs = setting.logs(_ROOM)
    space = FreeSpace.of(worlds.load(_ROOM))
    shares = [shares_near(log, space, _walls(log)) for log in logs]
    items = (
        _one_scan(setting, logs[0], space),
        _all_points(setting, logs[0], space, shares),
        _estimated_walls(setting, logs[0], space, shares),
    )
    return Section("data_points", "HSR: data points and estimated walls (section 6.1)", items)


def shares_near(log: sm.SonarLog, space: FreeSpace, es: EstimatedWalls) -> Shares:
    """Return which shares of a log's data points and of its estimated walls are near a surface."""
    judged = log.select(~np.isneginf(log.range_m))
    near = space.distance_m(plotted_points(judged)) <= NEAR_M
    cause = judged.require_truth("the study of data points").cause
    cells_m = np.column_stack(es.grid.centre_of(*np.nonzero(es.marks == Mark.WALL)))
    return Shares(
        points=_share(near),
        echoes=_share(near[np.isfinite(judged.range_m)]),
        by_cause={kind: _share(near[cause == kind]) for kind in sm.Cause if (cause == kind).any()},
        walls=_share(space.distance_m(cells_m) <= NEAR_M),
    )


def _share(those: NDArray[np.bool_]) -> float:
    return float(those.mean()) if those.size else float("nan")


def _walls(log: sm.SonarLog) -> EstimatedWalls:
    params = sm.HsrParams(_MIN_WALL_M, _MAX_WALL_M, log.ring.range_max_m, TARGET_DISTANCE_M)
    return estimate_variant_walls(log, params)


def _one_scan(setting: Setting, log: sm.SonarLog, space: FreeSpace) -> Item:
    scan = log.select(log.scan == log.scan[len(log) // 3])
    points_m = plotted_points(scan)
    away_m = space.distance_m(points_m)
    heard = scan.range_m != -np.inf
    rows, row = [], 0
    for index in range(len(scan)):
        reading, place = "too close", ("", "", "")
        if heard[index]:
            reach_m = min(scan.range_m[index], NO_ECHO_M)
            x_m, y_m = points_m[row]
            reading = f"{1000 * reach_m:.0f}"
            place = (f"{1000 * x_m:.0f}", f"{1000 * y_m:.0f}", f"{1000 * away_m[row]:.0f}")
            row += 1
        axis_deg = np.degrees(log.ring.heading_rad[scan.sonar[index]])
        rows.append((scan.sonar[index], f"{axis_deg:.0f}", reading, *place))
    heading_deg = np.degrees(np.angle(np.exp(1j * scan.heading_rad[0])))
    odometry = (
        f"x {1000 * scan.x_m[0]:.0f} mm, y {1000 * scan.y_m[0]:.0f} mm, heading {heading_deg:.1f} "
        "degrees"
    )
    return Item(
        "Figure 6.2",
        "One scan with its odometry, and its readings as points about the origin (500, 500).",
        f"{(away_m <= NEAR_M).sum()} of the {len(away_m)} data points of this scan lie within "
        "0.1 m of a surface.",
        (
            setting.figure(
                "scan",
                _scan_picture(scan, points_m, space),
                "One scan at its odometry; no echo would be drawn at 5.000 m, out of the picture",
            ),
        ),
        (
            setting.table(
                "scan",
                (
                    "sonar",
                    "axis, degrees",
                    "reading, mm",
                    "x, mm",
                    "y, mm",
                    "to the nearest surface, mm",
                ),
                rows,
                f"Odometry: {odometry}. No echo reads 5000 mm",
            ),
        ),
    )


def _scan_picture(scan: sm.SonarLog, points_m: NDArray[np.float64], space: FreeSpace) -> Figure:
    figure, (axes,) = figure_with(width=6.2, height=5.2)
    for sensor_m, point_m in zip(scan.sensor_xy_m[scan.range_m != -np.inf], points_m, strict=True):
        axes.plot(*np.transpose([sensor_m, point_m]), color="#999999", lw=0.8)
    axes.plot(*points_m.T, "o", color=_READING, ms=5, label="data point")
    axes.plot(*scan.sensor_xy_m.T, "s", color=_SONAR_COLOUR, ms=4, label="sonar")
    axes.plot(scan.x_m, scan.y_m, "^", color=_PATH, ms=7, label="robot")
    draw_outline(axes, space, _bounds(space), colour="#444444")
    _legend(axes)
    return figure


def _all_points(setting: Setting, log: sm.SonarLog, space: FreeSpace, shares: list[Shares]) -> Item:
    points = mean_of([share.points for share in shares])
    echoes = mean_of([share.echoes for share in shares])
    rows = [
        ("all", points.text(1, factor=100)),
        ("with an echo", echoes.text(1, factor=100)),
        *(
            (
                cause.name.lower().replace("_", " "),
                mean_of([s.by_cause[cause] for s in shares if cause in s.by_cause]).text(
                    1, factor=100
                ),
            )
            for cause in sm.Cause
            if any(cause in share.by_cause for share in shares)
        ),
    ]
    return Item(
        "Figure 6.4",
        "Map S, all data points with the trajectory: the four walls, and many points beyond them.",
        f"{points.text(1, '%', factor=100)} of the data points lie within 0.1 m of a surface; of "
        f"those of an echo {echoes.text(1, '%', factor=100)}.",
        (
            setting.figure(
                "map-s",
                _plot(log, space),
                "S of one drive: left all of it, no echo at 5.000 m; right the room",
            ),
        ),
        (
            setting.table(
                "near",
                ("data points", "within 0.1 m of a surface, %"),
                rows,
                "Share near a true surface, mean over drives, by the cause of the reading",
            ),
        ),
    )


def _plot(log: sm.SonarLog, space: FreeSpace) -> Figure:
    figure, panels = figure_with(1, 2, width=5.8, height=5.4)
    points_m = plotted_points(log)
    around = (*(points_m.min(axis=0) - 0.2), *(points_m.max(axis=0) + 0.2))
    for axes, bounds_m in zip(panels, (around, _bounds(space)), strict=True):
        draw_points(axes, points_m, colour=_READING, label="data points")
        axes.plot(log.x_m, log.y_m, color=_PATH, lw=1.2, label="robot's trajectory")
        draw_outline(axes, space, bounds_m, colour="#000000")
        _legend(axes)
    return figure


def _estimated_walls(
    setting: Setting, log: sm.SonarLog, space: FreeSpace, shares: list[Shares]
) -> Item:
    walls = mean_of([share.walls for share in shares])
    echoes = mean_of([share.echoes for share in shares])
    return Item(
        "Figure 6.6",
        "ES of one sonar with walls of 40 to 150 mm, Rth = 3000 mm: robot, sonar, readings and "
        "walls, which grow with the reading.",
        f"{walls.text(1, '%', factor=100)} of the cells of estimated walls (all sonars) lie within "
        f"0.1 m of a surface, against {echoes.text(1, '%', factor=100)} of the data points of an "
        "echo around which they stand.",
        (
            setting.figure(
                "es",
                _es_picture(log, space),
                f"ES of sonar {_SONAR}, every fifth scan; right: a part of it, cell by cell "
                "(cells of 1 cm)",
            ),
        ),
    )


def _es_picture(log: sm.SonarLog, space: FreeSpace) -> Figure:
    chosen = log.select((log.sonar == _SONAR) & (log.scan % _EVERY == 0))
    es = _walls(chosen)
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
