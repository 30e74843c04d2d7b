"""`Channels`: what a whole log says of each cell, as a stack of maps that a network reads.

Every channel is of the cells alone: nothing depends on how many sonars the ring has, where they sit
or how wide their cones are but through the cells that they touched. When log and grid are turned by
a quarter or mirrored, the channels turn and mirror with them; the two of a direction change sign as
the cosine and the sine of twice the angle do (`TURNING`).

Counts are of votes, not of readings: what a sonar reads while the robot hardly moves shares one
vote, exact repeats count once, and a square of 25 cm keeps so many readings of a direction and no
more. Counts then enter as log(1 + count), which a hundredth vote hardly moves.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog

if TYPE_CHECKING:
    from sonarmap.kernels.listed_cones import ListedCones

__all__ = ["CHANNELS", "TURNING", "VERSION", "channels", "telling"]

VERSION = 1
"""Raised when a channel changes its meaning: weights of another version are refused."""

CHANNELS: dict[str, str] = {
    "timid": "log-odds of cautious steps, squeezed: the plain map to start from",
    "pass_axis": "echoes whose inner cone passed through: the beam is strong there",
    "pass_edge": "the same by the outer cone, where a sonar often misses what stands there",
    "pass_core": "the same on the very axis: an opening that is narrower than a cone",
    "pass_short": "passes of short echoes alone: they are hardly ever too long",
    "pass_steady": "passes of echoes that the next reading confirms: seldom chance",
    "none_axis": "no echo, inner cone, up to 3 m: free, or a mirror that sent the sound away",
    "none_edge": "no echo, outer cone",
    "none_far": "no echo, beyond 3 m: in view, and hardly more",
    "hit_axis": "arcs of echoes, inner half, each by one over its length: it has one cause",
    "hit_edge": "arcs, outer half",
    "hit_core": "arcs on the very axis, by count: what a data point is",
    "hit_all": "arcs by count: how often a cell may have been it",
    "hit_far": "arcs of longer echoes: bounces are among these",
    "hit_steady": "arcs of echoes that the next reading confirms",
    "shadow": "cells behind an arc: inside of what it met, if anything",
    "directions_passed": "distinct directions, of 16, that passed through",
    "directions_hit": "distinct directions, of 16, with the cell on an arc",
    "nearest_pass": "nearest range of a pass: near ones are sharp and sure",
    "nearest_hit": "nearest range of an arc",
    "first_pass": "how little of its way the robot had made at the first pass: odometry drifts",
    "hit_travel": "mean way at the arcs: of two images of a wall the earlier is the better placed",
    "first_share": "shares of echoes after one round of arcs competing for cells",
    "last_share": "shares after the last round",
    "largest_share": "largest share of a single echo",
    "lost": "what passes and rivals took from the cell in the last round",
    "competed": "P(occupied) by the competition",
    "cos_2": "direction of the echoes it is thought to have sent: cosine of twice the angle",
    "sin_2": "sine of twice the angle: walls lie across it",
    "path": "nearness of the robot's own way, which is free",
}
"""The channels in their order, and why each is there."""

TURNING = ("cos_2", "sin_2")

# Metres. Half an arc's thickness: a cell and a half. Assumed, like all numbers here.
_TOLERANCE_M, _DEPTH_M, _SHORT_M, _NO_ECHO_M = 0.075, 0.40, 1.5, 3.0
_CORE, _MIDDLE = 0.2, 0.5
_DIRECTIONS = 16
# The competition, see `sonarmap.methods.arc_competition.ArcCompetition`.
_ROUNDS, _PRIOR, _PRIOR_WEIGHT, _UNEXPLAINED = 4, 0.06, 1.0, 0.05
_ARC_M, _RIVAL, _PASS, _NO_ECHO = 0.05, 0.05, 0.1, 0.5
# Repeats: a vote for so much way; places and readings that differ by less are the same.
_TRAVEL_M, _TURN_RAD = 0.05, math.radians(5)
_SAME_M, _SAME_RAD = 0.001, 0.001
# A square of this side keeps so many readings of each direction.
_SQUARE_M, _KEPT = 0.25, 6
_STEADY_M = 0.10
_NEAR_M, _PATH_M, _TRAVELLED_M = 5.0, 0.5, 10.0
_BATCH = 500


def channels(log: SonarLog, grid: GridSpec) -> NDArray[np.float32]:
    """Return the channels of a log on a grid, shape (len(CHANNELS), rows, cols).

    Parameters
    ----------
    log : SonarLog
        The log; stale, rejected and too close readings do not count.
    grid : GridSpec
        Where the cells are. Their side is meant to be 5 cm, for which the numbers are chosen.
    """
    from sonarmap.kernels.evidence import SUMS, sum_evidence

    log = telling(log)
    size, n = grid.rows * grid.cols, len(log)
    sums = np.zeros((size, SUMS), np.float32)
    passed, hit = np.zeros(size, np.uint16), np.zeros(size, np.uint16)
    nearest = np.full((size, 3), _NEAR_M, np.float32)
    nearest[:, 2] = np.inf
    ring = log.ring
    echo = log.range_m <= ring.range_max_m
    near_m = min(ring.range_max_m, _NO_ECHO_M)
    reading_m = np.where(echo, log.range_m, ring.range_max_m)
    steady, vote = _steady(log, echo), _votes(log)
    axis_rad = log.axis_rad
    bin_of = np.floor(axis_rad % (2 * math.pi) * (_DIRECTIONS / (2 * math.pi))).astype(np.int64)
    bin_of %= _DIRECTIONS
    arc_cells = 2 * ring.half_angle_rad * reading_m / grid.resolution_m
    arc_weight = 1 / np.maximum(arc_cells, 1)
    limits = (_TOLERANCE_M, _ARC_M, _DEPTH_M, _SHORT_M, _CORE, _MIDDLE, near_m, ring.range_max_m)
    travel_m = _travel(log)
    first, cells, claimed = [np.zeros(1, np.int64)], [np.empty(0, np.int32)], []
    for begin in range(0, n, _BATCH):
        rows = slice(begin, begin + _BATCH)
        cones = _cones(log, rows, grid, reading_m[rows] + np.where(echo[rows], _DEPTH_M, 0.0))
        of, cell, claim = sum_evidence(
            cones.first,
            cones.cell,
            cones.range_m,
            cones.share,
            reading_m[rows],
            echo[rows],
            steady[rows],
            vote[rows],
            bin_of[rows],
            arc_weight[rows],
            travel_m[rows],
            limits,
            sums,
            passed,
            hit,
            nearest,
        )
        first.append(first[-1][-1] + of[1:])
        cells.append(cell)
        claimed.append(claim)
    listed = (
        np.concatenate(first),
        np.concatenate(cells),
        np.concatenate([np.empty(0, np.float32), *claimed]),
    )
    competed = _competition(log, grid, listed, vote * np.where(echo, 1.0, _NO_ECHO), echo)
    return _stacked(log, grid, sums, passed, hit, nearest, competed)


def telling(log: SonarLog) -> SonarLog:
    """Return the readings that say something new: usable, none twice, not too many from a place.

    A reading that repeats another one of its sonar, from the same pose, says nothing, wherever it
    stands in the log. And each square of 25 cm keeps six readings a direction, spread over those
    that there are: what is kept is bounded by the area that the robot drove over.
    """
    log = log.select(log.usable & (log.range_m >= 0))
    if not len(log):
        return log
    reading_m = np.where(np.isfinite(log.range_m), log.range_m, -1.0)
    key = np.column_stack(
        [
            log.sonar,
            np.round(log.x_m / _SAME_M),
            np.round(log.y_m / _SAME_M),
            np.round(log.heading_rad % (2 * math.pi) / _SAME_RAD),
            np.round(reading_m / _SAME_M),
        ]
    )
    log = log.select(np.sort(_first_of(key.astype(np.int64))))
    x, y = np.floor(log.sensor_xy_m / _SQUARE_M).astype(np.int64).T
    direction = np.floor(log.axis_rad % (2 * math.pi) * (_DIRECTIONS / (2 * math.pi)))
    place = np.column_stack([x, y, direction.astype(np.int64) % _DIRECTIONS])
    group = _groups(place)
    count = np.bincount(group)
    if count.max(initial=0) <= _KEPT:
        return log
    order = np.argsort(group, kind="stable")
    rank = np.empty(len(log), np.int64)
    rank[order] = np.arange(len(log)) - np.repeat(np.cumsum(count) - count, count)
    # Evenly spread: a reading is kept where rank * kept / count steps over a whole number.
    of = np.maximum(count[group], _KEPT)
    return log.select((rank * _KEPT) // of != ((rank - 1) * _KEPT) // of)


def _groups(key: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return a number for each row, the same for equal rows."""
    order = np.lexsort(key.T)
    new = np.concatenate([[False], (np.diff(key[order], axis=0) != 0).any(axis=1)])
    group = np.empty(order.size, np.int64)
    group[order] = np.cumsum(new)
    return group


def _first_of(key: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the first row of each group of equal rows."""
    group = _groups(key)
    first = np.full(int(group.max()) + 1, group.size)
    np.minimum.at(first, group, np.arange(group.size))
    return first


def _votes(log: SonarLog) -> NDArray[np.float64]:
    from sonarmap.methods.arc_competition import shared_votes

    return shared_votes(log, _TRAVEL_M, _TURN_RAD)


def _travel(log: SonarLog) -> NDArray[np.float64]:
    """Return the way of the robot up to each reading, metres."""
    steps_m = np.hypot(np.diff(log.x_m), np.diff(log.y_m))
    return np.concatenate([[0.0], np.cumsum(steps_m)])


def _steady(log: SonarLog, echo: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which echoes agree with the one of the same sonar before or after."""
    steady = np.zeros(len(log), bool)
    order = np.argsort(log.sonar, kind="stable")
    reading = np.where(echo, log.range_m, np.inf)[order]
    with np.errstate(invalid="ignore"):  # inf - inf
        agrees = (np.diff(log.sonar[order]) == 0) & (np.abs(np.diff(reading)) <= _STEADY_M)
    steady[order[1:]] = agrees
    steady[order[:-1]] |= agrees
    return steady


def _cones(log: SonarLog, rows: slice, grid: GridSpec, reach_m: NDArray[np.float64]) -> ListedCones:
    from sonarmap.kernels.listed_cones import ListedCones

    half_angle = log.ring.half_angle_rad
    return ListedCones.on(grid, log.sensor_xy_m[rows], log.axis_rad[rows], half_angle, reach_m)


def _competition(
    log: SonarLog,
    grid: GridSpec,
    listed: tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]],
    vote: NDArray[np.float64],
    echo: NDArray[np.bool_],
) -> tuple[NDArray[np.float64], ...]:
    """Return shares after the first and the last round, losses, P and `arc_shares`."""
    from sonarmap.kernels.competition import compete
    from sonarmap.kernels.evidence import arc_shares

    first, cell, claim = listed
    size = grid.rows * grid.cols
    p, first_share = np.full(size, _PRIOR), np.zeros(size)
    hits, misses = np.zeros(size), np.zeros(size)
    for number in range(_ROUNDS):
        hits, misses = np.zeros(size), np.zeros(size)
        compete(p, first, cell, claim, vote, echo, _UNEXPLAINED, _RIVAL, _PASS, hits, misses)
        p = (_PRIOR_WEIGHT * _PRIOR + hits) / (_PRIOR_WEIGHT + hits + misses)
        if number == 0:
            first_share = hits
    shares = np.zeros((size, 4))
    place = (*grid.origin_xy_m, grid.resolution_m)
    arc_shares(p, first, cell, claim, vote, log.sensor_xy_m, _UNEXPLAINED, grid.cols, place, shares)
    return first_share, hits, misses, p, shares


def _stacked(
    log: SonarLog,
    grid: GridSpec,
    sums: NDArray[np.float32],
    passed: NDArray[np.uint16],
    hit: NDArray[np.uint16],
    nearest: NDArray[np.float32],
    competed: tuple[NDArray[np.float64], ...],
) -> NDArray[np.float32]:
    """Return the channels, each about within [-1, 2], whatever the log."""
    from sonarmap.kernels import evidence as k

    first_share, last_share, lost, p, shares = competed
    stack = np.zeros((len(CHANNELS), grid.rows * grid.cols), np.float32)
    index = {name: number for number, name in enumerate(CHANNELS)}

    def put(name: str, values: NDArray[np.floating]) -> None:
        stack[index[name]] = values

    put("timid", np.tanh(sums[:, k.TIMID] / 4))
    for name in ("pass_axis", "pass_edge", "pass_core", "pass_short", "pass_steady"):
        put(name, np.log1p(sums[:, getattr(k, name.upper())]) / 3)
    for name in ("none_axis", "none_edge", "none_far"):
        put(name, np.log1p(sums[:, getattr(k, name.upper())]) / 3)
    for name in ("hit_axis", "hit_edge", "hit_far", "hit_steady"):
        put(name, np.log1p(8 * sums[:, getattr(k, name.upper())]) / 2)
    for name in ("hit_core", "hit_all", "shadow"):
        put(name, np.log1p(sums[:, getattr(k, name.upper())]) / 2)
    put("directions_passed", np.bitwise_count(passed) / np.float32(_DIRECTIONS))
    put("directions_hit", np.bitwise_count(hit) / np.float32(_DIRECTIONS))
    put("nearest_pass", 1 - nearest[:, 0] / np.float32(_NEAR_M))
    put("nearest_hit", 1 - nearest[:, 1] / np.float32(_NEAR_M))
    put("first_pass", np.exp(-nearest[:, 2] / _TRAVELLED_M))
    hits = sums[:, k.HIT_AXIS] + sums[:, k.HIT_EDGE]
    mean_m = sums[:, k.HIT_TRAVEL] / np.maximum(hits, 1e-9)
    put("hit_travel", np.where(hits > 0, np.exp(-mean_m / _TRAVELLED_M), 0))
    put("first_share", np.log1p(4 * first_share) / 2)
    put("last_share", np.log1p(4 * last_share) / 2)
    put("largest_share", shares[:, 3])
    put("lost", np.log1p(4 * lost) / 2)
    put("competed", p)
    # Towards 0 where there is little to have a direction.
    scale = 1 / (shares[:, 0] + 0.1)
    put("cos_2", shares[:, 1] * scale)
    put("sin_2", shares[:, 2] * scale)
    put("path", _path(log, grid).ravel())
    return stack.reshape(-1, *grid.shape)


def _path(log: SonarLog, grid: GridSpec) -> NDArray[np.float64]:
    """Return exp(-distance / 0.5 m) to where the robot was."""
    from scipy.ndimage import distance_transform_edt

    row, col = grid.cell_of(log.x_m, log.y_m)
    inside = grid.contains(row, col)
    way = np.ones(grid.shape, bool)
    way[row[inside], col[inside]] = False
    if way.all():
        return np.zeros(grid.shape)
    near: NDArray[np.float64] = np.exp(distance_transform_edt(way) * (-grid.resolution_m / _PATH_M))
    return near
