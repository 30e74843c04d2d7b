"""Policies without learning: random, along a wall, to the nearest frontier.

A policy is a function from one robot's observation to its action. The two that look do nothing but
that: they remember nothing, so one of them may drive many robots, and an episode needs no call.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, distance_transform_edt, label

from sim.envs.env import Observation
from sim.envs.policies.kernel import step_towards
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import GridSpec, SonarRing, ring
from sonarmap.errors import positive
from sonarmap.occupancy import FREE_UP_TO, OCCUPIED_FROM

__all__ = ["Policy", "frontier_policy", "random_policy", "wall_follow_policy"]

Policy = Callable[[Observation], Any]
"""From one robot's observation to its action."""

# All numbers below are assumed: they make the policies useful, no text gives them.

# Wall following, as a share of the fastest drive.
_FOLLOW_SHARE = 0.6
# A wall beside the robot that is farther than this is lost.
_LOST_M = 1.1
# What is so near ahead is turned away from: in place, and while driving.
_STOP_M, _SLOW_M = 0.35, 0.8
# Something so near to a sonar ahead leaves no room to turn: back off.
_TOUCHING_M = 0.12
_BACK_SHARE = -0.3
# Something half aside is in the way only if it is so many times nearer.
_FORE_FACTOR = 1.4

# The frontier: P(occupied) times 255 in a patch.
_FREE_BYTE, _OCCUPIED_BYTE = 255 * FREE_UP_TO, 255 * OCCUPIED_FROM
# A frontier of fewer cells is a gap between two cones, not an unknown place.
_FRONTIER_CELLS = 4
# The newest readings up to here speak louder than the map; a cone is drawn as so many points.
_NEAR_ECHO_M, _FAN = 1.5, 9
# The robot keeps so far from occupied cells if it can; paths nearer to them count as longer.
_ROOMY_M, _NARROW_COST = 0.5, 3.0
# To turn by a radian takes as long as to drive so far.
_TURN_COST_M = 0.5
# How far ahead of its heading a robot that turns at full speed counts as being.
_LEAD_RAD = 1.0
# It steers to a point so far down its path.
_LOOK_AHEAD_M = 0.5
_FRONTIER_SHARE = 0.6


def random_policy(space: Space[Any], rng: np.random.Generator) -> Policy:
    """Return the policy that draws every action from the whole space of actions.

    Parameters
    ----------
    space : gymnasium.spaces.Space
        ``env.action_space``, of one robot or of a batch; it is not changed.
    rng : numpy.random.Generator
        Where the actions are drawn from.
    """
    own = deepcopy(space)
    own.seed(int(rng.integers(2**31)))
    return lambda observation: own.sample()


def wall_follow_policy(
    *, distance_m: float = 0.5, sonars: SonarRing | None = None
) -> Callable[[Observation], NDArray[np.float32]]:
    """Return the policy that keeps the wall on the left at a distance, by the readings alone.

    For ``action="velocity"``. With no wall near on any side it drives straight on.

    Parameters
    ----------
    distance_m : float
        Wanted distance of the robot's centre from the wall, > 0.
    sonars : SonarRing, optional
        Where the sonars are, by default those of the environments' default sonar.
    """
    positive("distance_m", distance_m)
    looks = _Looks(ring("amigobot-aria") if sonars is None else sonars)

    def act(observation: Observation) -> NDArray[np.float32]:
        range_m = looks.range_m(observation)
        ahead_m, left_m = looks.ahead_m(range_m), looks.left_m(range_m)
        if ahead_m < _STOP_M:
            return _careful(looks, range_m, 0.0, -1.0)
        if left_m < _LOST_M:
            # Towards the wall by as much as it is too far, but never head-on.
            turn = max(-1.0, min(0.6, 2.5 * (left_m - distance_m)))
            turn -= max(0.0, 1.0 - ahead_m / _SLOW_M)
        else:
            # The wall ended: a curve around its corner. It never was: straight on.
            turn = 0.75 if looks.behind_left_m(range_m) < _LOST_M else 0.0
        return _careful(looks, range_m, _FOLLOW_SHARE, turn)

    return act


def frontier_policy(
    *, cell_m: float = 0.1, sonars: SonarRing | None = None
) -> Callable[[Observation], NDArray[np.float32]]:
    """Return the policy that drives to the nearest frontier of the map that it observes.

    A frontier is where free cells that the robot can reach meet unknown ones (Yamauchi, "A
    frontier-based approach for autonomous exploration", 1997). For ``action="velocity"`` and
    observations with a map (``map_patch=n``). With no frontier in the patch it drives on and
    turns away from what is near.

    Parameters
    ----------
    cell_m : float
        Side of a cell of the patch, metres: the environment's ``map_resolution_m``.
    sonars : SonarRing, optional
        Where the sonars are, by default those of the environments' default sonar.
    """
    positive("cell_m", cell_m)
    looks = _Looks(ring("amigobot-aria") if sonars is None else sonars)

    def act(observation: Observation) -> NDArray[np.float32]:
        range_m = looks.range_m(observation)
        turning = float(observation["last_action"][1])
        patch = _with_echoes(observation["map"][0], looks.echoes_m(range_m), cell_m)
        target = _path_to_frontier(patch, cell_m, turning)
        if target is None:
            blocked = looks.ahead_m(range_m) < _SLOW_M
            turn = 0.8 * looks.clearer_side(range_m) if blocked else 0.0
            return _careful(looks, range_m, 0.0 if blocked else _FRONTIER_SHARE, turn)
        bearing = math.atan2(target[1], target[0])
        speed = _FRONTIER_SHARE * max(0.0, math.cos(bearing)) ** 3
        return _careful(looks, range_m, speed, 1.5 * bearing)

    return act


class _Looks:
    """Which sonars look where."""

    def __init__(self, sonars: SonarRing) -> None:
        heading_deg = np.rad2deg(sonars.heading_rad)
        self._reach_m = sonars.range_max_m
        self._axis_rad = sonars.heading_rad
        self._fan_rad = np.linspace(-sonars.half_angle_rad, sonars.half_angle_rad, _FAN)
        self._mount_m = np.column_stack([sonars.x_m, sonars.y_m])
        self._offset_m = np.hypot(sonars.x_m, sonars.y_m)
        self._bow = np.abs(heading_deg) <= 20
        self._left = (heading_deg > 20) & (heading_deg < 120)
        self._right = (heading_deg < -20) & (heading_deg > -120)
        self._fore = (np.abs(heading_deg) > 20) & (np.abs(heading_deg) < 60)
        self._behind_left = heading_deg >= 120

    def range_m(self, observation: Observation) -> NDArray[np.float64]:
        """Return the readings in metres; the farthest for no echo, 0 for too close."""
        metres: NDArray[np.float64] = observation["range"].astype(float) * self._reach_m
        return metres

    def ahead_m(self, range_m: NDArray[np.float64]) -> float:
        """Return how near something is that the robot would drive into."""
        bow_m = range_m[self._bow].min(initial=np.inf)
        # A wall that the robot passes is as near to the sonars that look half aside.
        return float(min(bow_m, _FORE_FACTOR * range_m[self._fore].min(initial=np.inf)))

    def left_m(self, range_m: NDArray[np.float64]) -> float:
        """Return how far from the robot's centre something is on the left."""
        return float((range_m + self._offset_m)[self._left].min(initial=np.inf))

    def behind_left_m(self, range_m: NDArray[np.float64]) -> float:
        """Return how far from the robot's centre something is behind it on the left."""
        return float((range_m + self._offset_m)[self._behind_left].min(initial=np.inf))

    def clearer_side(self, range_m: NDArray[np.float64]) -> float:
        """Return 1 if there is more room to the left than to the right, else -1."""
        left_m, right_m = (range_m[side].min(initial=np.inf) for side in (self._left, self._right))
        return 1.0 if left_m >= right_m else -1.0

    def echoes_m(self, range_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where near echoes may come from, metres ahead and to the left, shape (k, 2)."""
        near = range_m < _NEAR_ECHO_M
        bearing_rad = self._axis_rad[near, None] + self._fan_rad
        direction = np.stack([np.cos(bearing_rad), np.sin(bearing_rad)], axis=-1)
        points: NDArray[np.float64] = (
            self._mount_m[near, None] + range_m[near, None, None] * direction
        )
        return points.reshape(-1, 2)

    def is_touching(self, range_m: NDArray[np.float64]) -> bool:
        """Return whether something is too near on either side."""
        return bool(range_m[self._left | self._right].min(initial=np.inf) < _TOUCHING_M)


def _careful(
    looks: _Looks, range_m: NDArray[np.float64], speed: float, turn: float
) -> NDArray[np.float32]:
    """Return the action that is nearest to what is wanted and safe by the readings."""
    ahead_m = looks.ahead_m(range_m)
    if ahead_m < _TOUCHING_M:
        speed = _BACK_SHARE
    speed = min(speed, max(0.0, ahead_m - _TOUCHING_M) / _SLOW_M) if speed > 0 else speed
    if looks.is_touching(range_m):
        turn = 0.7 * looks.clearer_side(range_m)
    return np.clip([speed, turn], -1.0, 1.0).astype(np.float32)


def _with_echoes(
    patch: NDArray[np.uint8], points_m: NDArray[np.float64], cell_m: float
) -> NDArray[np.uint8]:
    """Return a patch in which the cells of points, metres ahead and to the left, are occupied.

    Long readings over a mirror may have wiped a wall off the map that the sonars detect.
    """
    # In units of its cells, downwards and to the right.
    grid = GridSpec(1.0, (0.0, 0.0), patch.shape)
    down, right = (0.5 * len(patch) - points_m / cell_m).T
    rows, cols = grid.cell_of(right, down)
    inside = grid.contains(rows, cols)
    marked = patch.copy()
    marked[rows[inside], cols[inside]] = 255
    return marked


def _path_to_frontier(
    patch: NDArray[np.uint8], cell_m: float, turning: float
) -> tuple[float, float] | None:
    """Return a point on the shortest path to a frontier, metres ahead and to the left.

    None if no frontier can be reached. `turning` is the share of the fastest turn that was wanted
    last: a path that goes on turning so is preferred, or the robot would waver between two.
    """
    size = len(patch)
    middle = (size - 1) / 2
    rows, cols = np.indices(patch.shape)
    from_robot_m = np.hypot(rows - middle, cols - middle) * cell_m
    occupied = patch > _OCCUPIED_BYTE
    # Where the robot stands is free, though no reading says so.
    free = (patch < _FREE_BYTE) | (from_robot_m <= BODY_RADIUS_M)
    unknown = ~free & ~occupied
    room_m = _room_m(occupied, cell_m)
    passable = free & ((room_m > BODY_RADIUS_M) | (from_robot_m <= 2 * BODY_RADIUS_M))
    frontier = _large(passable & binary_dilation(unknown), _FRONTIER_CELLS)
    frontier &= from_robot_m > 2 * BODY_RADIUS_M
    if not frontier.any():
        return None
    cost = 1 + _NARROW_COST * np.maximum(1 - room_m / _ROOMY_M, 0)
    bearing_rad = np.arctan2(middle - cols, middle - rows)
    turn_rad = np.abs(np.remainder(bearing_rad - _LEAD_RAD * turning + np.pi, 2 * np.pi) - np.pi)
    cost += np.where(from_robot_m <= _LOOK_AHEAD_M, _TURN_COST_M / _LOOK_AHEAD_M * turn_rad, 0)
    cost[~passable] = np.inf
    begin = int(middle)
    row, col = step_towards(frontier, cost, begin, begin, round(_LOOK_AHEAD_M / cell_m))
    if row < 0:
        return None
    return (middle - row) * cell_m, (middle - col) * cell_m


def _room_m(occupied: NDArray[np.bool_], cell_m: float) -> NDArray[np.float64]:
    """Return how far each cell is from the nearest occupied one, metres."""
    if not occupied.any():
        return np.full(occupied.shape, np.inf)
    room_m: NDArray[np.float64] = distance_transform_edt(~occupied) * cell_m
    return room_m


def _large(cells: NDArray[np.bool_], at_least: int) -> NDArray[np.bool_]:
    """Return the cells that hang together with enough others."""
    labels, _ = label(cells, structure=np.ones((3, 3)))
    large: NDArray[np.bool_] = (np.bincount(labels.ravel()) >= at_least)[labels] & cells
    return large
