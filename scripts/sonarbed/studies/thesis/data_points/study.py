"""Figures 6.2, 6.4 and 6.6: readings as data points, the plot S, and the estimated walls ES."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import mean_of
from sonarbed.reporting.wording import cause_name
from sonarbed.studies.thesis.data_points.figures import (
    SONAR,
    es_picture,
    estimated_walls,
    plot,
    scan_picture,
)
from sonarbed.studies.thesis.free_space import NEAR_M, FreeSpace, plotted_points
from sonarbed.studies.thesis.questions import ThesisSection
from sonarmap.filters.hsr import NO_ECHO_M, EstimatedWalls, Mark

__all__ = ["NearShares", "run", "shares_near"]

_ROOM = "thesis-exp1"


@dataclass(frozen=True, slots=True)
class NearShares:
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


def run(context: StudyContext) -> ThesisSection:
    """Plot the readings of drives in the first room and the walls HSR estimates from them."""
    logs = context.logs(context.specs(_ROOM))
    space = FreeSpace.of(worlds.load(_ROOM))
    shares = [shares_near(log, space, estimated_walls(log)) for log in logs]
    items = (
        _one_scan(context, logs[0], space),
        _all_points(context, logs[0], space, shares),
        _estimated_walls(context, logs[0], space, shares),
    )
    return ThesisSection("data_points", "HSR: data points and estimated walls (section 6.1)", items)


def shares_near(log: sm.SonarLog, space: FreeSpace, es: EstimatedWalls) -> NearShares:
    """Return which shares of a log's data points and of its estimated walls are near a surface."""
    judged = log.select(~np.isneginf(log.range_m))
    near = space.distance_m(plotted_points(judged)) <= NEAR_M
    cause = judged.require_truth("the study of data points").cause
    cells_m = np.column_stack(es.grid.centre_of(*np.nonzero(es.marks == Mark.WALL)))
    return NearShares(
        points=_share(near),
        echoes=_share(near[np.isfinite(judged.range_m)]),
        by_cause={kind: _share(near[cause == kind]) for kind in sm.Cause if (cause == kind).any()},
        walls=_share(space.distance_m(cells_m) <= NEAR_M),
    )


def _share(those: NDArray[np.bool_]) -> float:
    return float(those.mean()) if those.size else float("nan")


def _one_scan(context: StudyContext, log: sm.SonarLog, space: FreeSpace) -> Item:
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
            context.figure(
                "scan",
                scan_picture(scan, points_m, space),
                "One scan at its odometry; no echo would be drawn at 5.000 m, out of the picture",
            ),
        ),
        (
            context.table(
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


def _all_points(
    context: StudyContext, log: sm.SonarLog, space: FreeSpace, shares: list[NearShares]
) -> Item:
    points = mean_of([share.points for share in shares])
    echoes = mean_of([share.echoes for share in shares])
    rows = [
        ("all", points.text(1, factor=100)),
        ("with an echo", echoes.text(1, factor=100)),
        *(
            (
                cause_name(cause),
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
            context.figure(
                "map-s",
                plot(log, space),
                "S of one drive: left all of it, no echo at 5.000 m; right the room",
            ),
        ),
        (
            context.table(
                "near",
                ("data points", "within 0.1 m of a surface, %"),
                rows,
                "Share near a true surface, mean over drives, by the cause of the reading",
            ),
        ),
    )


def _estimated_walls(
    context: StudyContext, log: sm.SonarLog, space: FreeSpace, shares: list[NearShares]
) -> Item:
    walls = mean_of([share.walls for share in shares])
    echoes = mean_of([share.echoes for share in shares])
    return Item(
        "Figure 6.6",
        "ES of one sonar with walls of 40 to 150 mm, Rth = 3000 mm: robot, sonar, readings and "
        "walls, which grow with the reading.",
        f"{walls.text(1, '%', factor=100)} of the cells of estimated walls (all sonars, "
        "each cell counted once) lie within 0.1 m of a surface, against "
        f"{echoes.text(1, '%', factor=100)} of the data points of an echo around which they stand.",
        (
            context.figure(
                "es",
                es_picture(log, space),
                f"ES of sonar {SONAR}, every fifth scan; right: a part of it, cell by cell "
                "(cells of 1 cm)",
            ),
        ),
    )
