"""Where a log's frame lies in a measured room: `align`.

A real robot's odometry begins where the robot was switched on, a room's file where somebody put
the corner of a drawing. The rigid motion between the two is found from the readings: an echo comes
from somewhere on the arc of its range, so somewhere on the arc there is a face, and between the
sonar and the arc there is none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.optimize import least_squares

from sonarmap import InputError, SonarLog
from sonarmap.errors import instance, whole
from sonarmap.kernels.jit import njit
from worlds.raycast import clearance
from worlds.truthgrid import FREE, OCCUPIED, truth
from worlds.world import Pose, World

__all__ = ["Alignment", "align"]

LEAST_READINGS = 30
"""Fewer echoes do not tell where they were measured. Assumed."""

_CELL_M = 0.05
# An echo farther than this from every face is a wrong one, and how far it is off says nothing more:
# four times the roughness of odometry and room together. Assumed.
_FAR_M = 0.3
# Where the search begins: so many headings, places this far apart, at most so many in all.
_HEADINGS, _LATTICE_M, _MOST_STARTS = 48, 0.25, 80_000
_COARSE_READINGS, _FINE_READINGS = 120, 400
# Of each reading so many points on its arc, and points before it as shares of its range.
_COARSE_BEARINGS, _FINE_BEARINGS = 5, 9
_BEFORE = (0.3, 0.6, 0.85)
# The best of the search that are refined; two nearer to one another than this are one.
_REFINED, _APART_M, _APART_RAD = 24, 0.3, math.radians(10)
# Residuals beyond this count less than squared, metres. Assumed.
_SOFT_M = 0.03
# Drawn anew from so many stretches of the log, so often, for the spread.
_STRETCHES, _DRAWS = 12, 24
# Alternatives that a line for people lists.
_SHOWN = 4
_Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Alignment:
    """The rigid motion from a log's frame into a room's.

    Parameters
    ----------
    motion : Pose
        Where the origin of the log's frame lies in the room's, metres, and its direction there,
        radians in [-pi, pi].
    std : Pose
        Standard deviations, from stretches of the log drawn anew: of where the middle of the drive
        comes to lie, metres, and of the direction, radians.
    median_m : float
        Median distance of the echoes' arcs from the nearest face, metres: small where log and
        room agree.
    readings : int
        How many echoes were compared.
    alternatives : tuple of Pose
        Other motions that explain the log as well: to these sonars the room looks the same from
        there. Not empty in a symmetric room; then the log alone cannot tell which is right.
    """

    motion: Pose
    std: Pose
    median_m: float
    readings: int
    alternatives: tuple[Pose, ...]

    def __str__(self) -> str:
        """One line for people."""
        line = (
            f"x {self.motion.x_m:.3f} ± {self.std.x_m:.3f} m, "
            f"y {self.motion.y_m:.3f} ± {self.std.y_m:.3f} m, "
            f"turned {math.degrees(self.motion.heading_rad):.2f} ± "
            f"{math.degrees(self.std.heading_rad):.2f}°; {self.readings} echoes, the median "
            f"{self.median_m * 100:.1f} cm from a face"
        )
        if self.alternatives:
            others = ", ".join(
                f"({each.x_m:.2f} m, {each.y_m:.2f} m, {math.degrees(each.heading_rad):.0f}°)"
                for each in self.alternatives[:_SHOWN]
            )
            more = len(self.alternatives) - _SHOWN
            line += (
                f"; to these sonars the room looks the same from {others}"
                f"{f' and {more} more places' if more > 0 else ''}: symmetric, or too plain"
            )
        return line

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON-able values, angles in degrees."""
        return {
            "motion": _plain(self.motion),
            "std": _plain(self.std),
            "median_m": self.median_m,
            "readings": self.readings,
            "alternatives": [_plain(each) for each in self.alternatives],
        }

    def moved(self, log: SonarLog) -> SonarLog:
        """Return a log with its odometry in the room's frame; its truth stays as it is."""
        x_m, y_m = _moved(_numbers(self.motion), log.x_m, log.y_m)
        return log.replace(x_m=x_m, y_m=y_m, heading_rad=log.heading_rad + self.motion.heading_rad)

    def world_in_log_frame(self, world: World) -> World:
        """Return the room in the log's frame, where a map made from the log lies."""
        cos, sin = math.cos(self.motion.heading_rad), math.sin(self.motion.heading_rad)
        x_m, y_m = self.motion.x_m, self.motion.y_m
        back = Pose(-cos * x_m - sin * y_m, sin * x_m - cos * y_m, -self.motion.heading_rad)
        return world.placed(back)


def align(log: SonarLog, world: World, *, seed: int = 0) -> Alignment:
    """Find the rigid motion between the frame of a log and that of the room it was taken in.

    Parameters
    ----------
    log : SonarLog
        Its odometry and readings count, its truth does not. Stale and rejected readings are left
        out, and so are those without an echo.
    world : World
        The room.
    seed : int
        Of the readings that are drawn from a long log, >= 0.

    Returns
    -------
    Alignment
        The best motion of all starts over the free floor and all headings, refined by least
        squares; of several that are as good the one nearest to none.

    Raises
    ------
    InputError
        If fewer than `LEAST_READINGS` readings have an echo.
    """
    instance("log", log, SonarLog)
    instance("world", world, World)
    rng = np.random.default_rng(whole("seed", seed, least=0))
    log = log.select(log.usable & np.isfinite(log.range_m))
    if len(log) < LEAST_READINGS:
        raise InputError(
            f"log must have at least {LEAST_READINGS} readings with an echo to be aligned, got "
            f"{len(log)}"
        )
    # Turned about the middle of the drive, a motion's place and direction are nearly independent.
    middle = np.array([log.x_m.mean(), log.y_m.mean()])
    log = log.replace(x_m=log.x_m - middle[0], y_m=log.y_m - middle[1])
    fine = _drawn(log, _FINE_READINGS, rng)
    starts = _searched(_drawn(log, _COARSE_READINGS, rng), world)
    arcs = _arcs(fine, _FINE_BEARINGS)
    found = [_refined(arcs, world, start) for start in starts]
    costs = np.array([_cost_by_reading(fine, arcs, world, motion) for motion in found])
    order = np.argsort(costs.mean(axis=1))
    as_good = [found[order[0]]]
    for rank in order[1:]:
        if _is_as_good(costs[rank] - costs[order[0]]) and all(
            _apart(found[rank], other) for other in as_good
        ):
            as_good.append(found[rank])
    nearest = min(range(len(as_good)), key=lambda i: _size(as_good[i] - (*middle, 0.0)))
    best = as_good.pop(nearest)
    spread = [_refined(arcs[_stretches(len(fine), rng)], world, best) - best for _ in range(_DRAWS)]
    std = np.std(spread, axis=0)
    return Alignment(
        motion=_about_origin(best, middle),
        std=Pose(*std.tolist()),
        median_m=float(np.median(_distances(arcs, world, best))),
        readings=len(fine),
        alternatives=tuple(_about_origin(each, middle) for each in as_good),
    )


def _drawn(log: SonarLog, most: int, rng: np.random.Generator) -> SonarLog:
    """Return at most so many readings of a log, in their order."""
    if len(log) <= most:
        return log
    return log.select(np.sort(rng.choice(len(log), most, replace=False)))


def _arcs(log: SonarLog, bearings: int) -> _Floats:
    """Return points on the arc of each reading in the log's frame, shape (n, bearings, 2)."""
    half_rad = log.ring.half_angle_rad
    angle = log.axis_rad[:, None] + np.linspace(-half_rad, half_rad, bearings)
    reach = log.range_m[:, None, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    arcs: _Floats = log.sensor_xy_m[:, None, :] + reach
    return arcs


def _before(log: SonarLog) -> _Floats:
    """Return points between each sonar and its echo in the log's frame, shape (n, shares, 2)."""
    ahead = np.column_stack([np.cos(log.axis_rad), np.sin(log.axis_rad)])
    reach = log.range_m[:, None, None] * np.array(_BEFORE)[:, None] * ahead[:, None, :]
    before: _Floats = log.sensor_xy_m[:, None, :] + reach
    return before


def _searched(log: SonarLog, world: World) -> list[_Floats]:
    """Return the best motions of a search over places of the log's first pose and headings."""
    known = truth(world, resolution_m=_CELL_M)
    far = distance_transform_edt(known.state != OCCUPIED, sampling=_CELL_M)
    field = np.minimum(far, _FAR_M) / _FAR_M
    solid = (known.state != FREE).astype(float)
    rows, cols = np.nonzero(known.state == FREE)
    step = max(1, round(_LATTICE_M / _CELL_M))
    while True:
        chosen = (rows % step == 0) & (cols % step == 0)
        if chosen.sum() * _HEADINGS <= _MOST_STARTS:
            break
        step += 1
    x_m, y_m = known.grid.centre_of(rows[chosen], cols[chosen])
    headings = np.arange(_HEADINGS) * math.tau / _HEADINGS
    first = np.array([log.x_m[0], log.y_m[0]])
    arcs, before = _arcs(log, _COARSE_BEARINGS) - first, _before(log) - first
    places = np.column_stack([np.atleast_1d(x_m), np.atleast_1d(y_m)])
    costs = _search(arcs, before, places, headings, field, solid, *known.grid.origin_xy_m, _CELL_M)
    kept: list[_Floats] = []
    for at in np.argsort(costs, axis=None):
        place, heading = np.unravel_index(at, costs.shape)
        turn = headings[heading]
        cos, sin = math.cos(turn), math.sin(turn)
        shift = places[place] - (cos * first[0] - sin * first[1], sin * first[0] + cos * first[1])
        motion = np.array([*shift, turn])
        if all(_apart(motion, other) for other in kept):
            kept.append(motion)
        if len(kept) == _REFINED:
            break
    return kept


@njit(error_model="numpy")
def _search(
    arcs: _Floats,
    before: _Floats,
    places: _Floats,
    headings: _Floats,
    field: _Floats,
    solid: _Floats,
    left_m: float,
    bottom_m: float,
    cell_m: float,
) -> _Floats:
    """Return the cost of each (place, heading): of arcs off the faces and faces before them."""
    costs = np.empty((places.shape[0], headings.size))
    rows, cols = field.shape
    for h in range(headings.size):
        cos, sin = math.cos(headings[h]), math.sin(headings[h])
        for p in range(places.shape[0]):
            x0, y0 = places[p, 0] - left_m, places[p, 1] - bottom_m
            total = 0.0
            for i in range(arcs.shape[0]):
                nearest = 1.0
                for j in range(arcs.shape[1]):
                    x, y = arcs[i, j, 0], arcs[i, j, 1]
                    col = math.floor((x0 + cos * x - sin * y) / cell_m)
                    row = math.floor((y0 + sin * x + cos * y) / cell_m)
                    if 0 <= row < rows and 0 <= col < cols:
                        nearest = min(nearest, field[row, col])
                total += nearest
                for j in range(before.shape[1]):
                    x, y = before[i, j, 0], before[i, j, 1]
                    col = math.floor((x0 + cos * x - sin * y) / cell_m)
                    row = math.floor((y0 + sin * x + cos * y) / cell_m)
                    if 0 <= row < rows and 0 <= col < cols:
                        total += solid[row, col] / before.shape[1]
                    else:
                        total += 1.0 / before.shape[1]
            costs[p, h] = total
    return costs


def _refined(arcs: _Floats, world: World, start: _Floats) -> _Floats:
    """Return the motion near another that brings the arcs nearest to faces."""

    def distances(motion: _Floats) -> _Floats:
        return _distances(arcs, world, motion)

    found = least_squares(
        distances,
        start,
        loss="soft_l1",
        f_scale=_SOFT_M,
        diff_step=(1e-4, 1e-4, 1e-4),
        x_scale=(0.1, 0.1, 0.05),
        max_nfev=40,
    )
    refined: _Floats = found.x
    return refined


def _distances(arcs: _Floats, world: World, motion: _Floats) -> _Floats:
    """Return how far the nearest point of each arc is from a face, at most `_FAR_M`."""
    x_m, y_m = _moved(motion, arcs[..., 0], arcs[..., 1])
    distances: _Floats = _nearest(world.faces.table, x_m, y_m, _FAR_M)
    return distances


@njit(error_model="numpy")
def _nearest(table: Any, x_m: _Floats, y_m: _Floats, reach_m: float) -> _Floats:
    nearest = np.full(x_m.shape[0], reach_m)
    for i in range(x_m.shape[0]):
        for j in range(x_m.shape[1]):
            found = clearance(table, 0, x_m[i, j], y_m[i, j], nearest[i])[0]
            # Deep inside of a pillar the distance is negative.
            nearest[i] = min(nearest[i], abs(found))
    return nearest


def _cost_by_reading(log: SonarLog, arcs: _Floats, world: World, motion: _Floats) -> _Floats:
    """Return what speaks against a motion, reading by reading: 0 nothing, 2 all."""
    off = _distances(arcs, world, motion) / _FAR_M
    sensor = log.sensor_xy_m
    x_m, y_m = _moved(motion, sensor[:, 0], sensor[:, 1])
    axis = log.axis_rad + motion[2]
    ahead = np.column_stack([np.cos(axis), np.sin(axis)])
    reach = np.maximum(log.range_m * _BEFORE[-1], 1e-3)
    met = world.faces.cast(np.column_stack([x_m, y_m]), ahead, reach)
    # As much as the face comes too early; sound that went by way of mirrors passes faces as well.
    early = np.where(np.isfinite(met.distance_m), 1 - met.distance_m / reach, 0.0)
    cost: _Floats = off + np.clip(early, 0, 1)
    return cost


def _is_as_good(difference: _Floats) -> bool:
    """Return whether a motion is not worse than the best, by its cost over the stretches."""
    parts = np.array([part.mean() for part in np.array_split(difference, _STRETCHES)])
    error = parts.std(ddof=1) / math.sqrt(parts.size)
    # Under 1 % of the whole scale nobody could tell them apart by eye either.
    return bool(parts.mean() <= max(2 * error, 0.01) and parts.mean() <= 0.05)


def _stretches(n: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Draw as many stretches of n readings as there are, some twice: neighbours go together."""
    parts = np.array_split(np.arange(n), _STRETCHES)
    return np.concatenate([parts[i] for i in rng.integers(_STRETCHES, size=_STRETCHES)])


def _moved(motion: _Floats, x_m: _Floats, y_m: _Floats) -> tuple[_Floats, _Floats]:
    cos, sin = math.cos(motion[2]), math.sin(motion[2])
    return motion[0] + cos * x_m - sin * y_m, motion[1] + sin * x_m + cos * y_m


def _apart(one: _Floats, other: _Floats) -> bool:
    turn = abs(math.remainder(one[2] - other[2], math.tau))
    return math.hypot(*(one[:2] - other[:2])) > _APART_M or turn > _APART_RAD


def _size(motion: _Floats) -> float:
    """Return how much a motion moves, a turn counted as that of a place a metre away, metres."""
    return math.hypot(motion[0], motion[1]) + abs(math.remainder(motion[2], math.tau))


def _about_origin(motion: _Floats, middle: _Floats) -> Pose:
    """Return the motion of the log's own frame from that of the frame about a place in it."""
    x_m, y_m = _moved(motion, *(-middle))
    return Pose(float(x_m), float(y_m), math.remainder(float(motion[2]), math.tau))


def _numbers(pose: Pose) -> _Floats:
    return np.array([pose.x_m, pose.y_m, pose.heading_rad])


def _plain(pose: Pose) -> dict[str, float]:
    return {"x_m": pose.x_m, "y_m": pose.y_m, "heading_deg": math.degrees(pose.heading_rad)}
