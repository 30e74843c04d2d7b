"""Navigate: reach a goal in a room that is seen only by sonar."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from gymnasium.spaces import Box
from numba import njit
from numpy.typing import NDArray

from sim.envs.tasks.task import Briefing, Moment, Verdict, weighted
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import InputError

__all__ = ["Navigate", "NavigateWeights", "navigate_terms"]

# A goal farther than this is told as if it were so far.
_GOAL_RANGE_M = 10.0


@dataclass(frozen=True, slots=True)
class NavigateWeights:
    """Weights of the reward's terms, see `navigate_terms`."""

    progress: float = 1.0
    arrival: float = 5.0
    collision: float = -0.2
    stuck: float = -5.0
    effort: float = -0.01
    time: float = -0.01


class Navigate:
    """Judges how robots drive to their goals.

    Parameters
    ----------
    robots : int
        How many.
    weights : NavigateWeights, optional
        Of the terms of the reward.
    """

    ARRIVED_M = 0.3
    """A robot this near to its goal, in truth, has arrived; assumed."""
    NEAREST_M, FARTHEST_M = 1.0, 8.0
    """Random goals are between so many metres of driving from the start; assumed."""

    needs_maps = False

    def __init__(self, robots: int, weights: NavigateWeights | None = None) -> None:
        self._weights = asdict(weights or NavigateWeights())
        self._goal_m = np.zeros((robots, 2))
        self._left_m = np.zeros(robots)
        self._way_m = np.zeros((robots, 1, 1), np.float32)
        # Lower-left corner and cell of each room's grid.
        self._grid = np.ones((robots, 3))
        self.observations: Mapping[str, Box] = {
            "goal": Box(np.array([0, -1, -1], np.float32), np.ones(3, np.float32))
        }

    def begin(self, row: int, briefing: Briefing) -> None:
        """Begin the episode of one robot."""
        facts, goal = briefing.facts, briefing.goal
        if isinstance(goal, str):
            goal = facts.random_goal(briefing.rng, briefing.start, self.NEAREST_M, self.FARTHEST_M)
        elif not facts.is_reachable(*goal):
            raise InputError(
                f"goal of ({goal[0]:g}, {goal[1]:g}) m must be where the robot (radius "
                f"{BODY_RADIUS_M} m) fits and to where it can drive in {facts.world.name!r}"
            )
        self._goal_m[row] = goal
        way_m = facts.way_m(*goal)
        self._grow(*way_m.shape)
        self._way_m[row] = np.inf
        self._way_m[row, : way_m.shape[0], : way_m.shape[1]] = way_m
        self._grid[row] = *facts.grid.origin_xy_m, facts.grid.resolution_m
        begin = facts.grid.cell_of(briefing.start.x_m, briefing.start.y_m)
        left_m = float(way_m[begin])
        # Where the grid does not tell, at a wall, the straight way has to do.
        straight_m = math.dist(goal, (briefing.start.x_m, briefing.start.y_m))
        self._left_m[row] = left_m if math.isfinite(left_m) else straight_m

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return the goal's range, as a share of 10 m, and the cosine and sine of its bearing."""
        goal = np.empty((len(states), 3), np.float32)
        _tell_goals(states, self._goal_m, goal)
        return {"goal": goal}

    def judge(self, moment: Moment) -> Verdict:
        """Judge the control step that has just ended."""
        states, robots = moment.states, len(moment.states)
        progress_m, arrived = np.empty(robots), np.empty(robots, bool)
        _judge_ways(
            states,
            self._goal_m,
            self._way_m,
            self._grid,
            self.ARRIVED_M,
            self._left_m,
            progress_m,
            arrived,
        )
        terms = navigate_terms(progress_m, arrived, states["touched"], moment.stuck, moment.effort)
        return Verdict(
            terms,
            weighted(terms, self._weights),
            arrived | moment.stuck,
            {"is_success": arrived},
        )

    def goal_of(self, row: int) -> tuple[float, float] | None:
        """Return where a robot shall go, metres."""
        x_m, y_m = self._goal_m[row].tolist()
        return x_m, y_m

    def _grow(self, rows: int, cols: int) -> None:
        robots, had_rows, had_cols = self._way_m.shape
        if rows > had_rows or cols > had_cols:
            old = self._way_m
            shape = robots, max(rows, had_rows), max(cols, had_cols)
            self._way_m = np.full(shape, np.inf, np.float32)
            self._way_m[:, :had_rows, :had_cols] = old


def navigate_terms(
    progress_m: NDArray[np.float64],
    arrived: NDArray[np.bool_],
    touched: NDArray[np.bool_],
    stuck: NDArray[np.bool_],
    effort: NDArray[np.float64],
) -> dict[str, NDArray[np.float64]]:
    """Return the terms of the reward of one control step.

    Parameters
    ----------
    progress_m : ndarray
        How much shorter the way to the goal has become, metres.
    arrived, touched, stuck : ndarray of bool
        Whether the robot is there, whether it touched something, and whether it has for too long.
    effort : ndarray
        See `Moment`.
    """
    return {
        "progress": progress_m,
        "arrival": arrived.astype(float),
        "collision": touched.astype(float),
        "stuck": stuck.astype(float),
        "effort": effort,
        "time": np.ones(len(effort)),
    }


@njit(cache=True)
def _tell_goals(states, goal_m, told):
    """Write where the goals are as the robots believe, see the environment's docstring."""
    for i in range(states.size):
        pose = states[i].believed_pose
        dx, dy = goal_m[i, 0] - pose[0], goal_m[i, 1] - pose[1]
        bearing = math.atan2(dy, dx) - pose[2]
        told[i, 0] = min(math.hypot(dx, dy) / _GOAL_RANGE_M, 1.0)
        told[i, 1], told[i, 2] = math.cos(bearing), math.sin(bearing)


@njit(cache=True)
def _judge_ways(states, goal_m, way_m, grid, arrived_m, left_m, progress_m, arrived):
    """Write how much shorter the ways have become and who is there; change what is left.

    Where the grid does not tell how far it is, close to a wall, the way has not changed.
    """
    for i in range(states.size):
        x, y = states[i].true_pose[0], states[i].true_pose[1]
        col = math.floor((x - grid[i, 0]) / grid[i, 2])
        row = math.floor((y - grid[i, 1]) / grid[i, 2])
        now_m = left_m[i]
        known = 0 <= row < way_m.shape[1] and 0 <= col < way_m.shape[2]
        if known and math.isfinite(way_m[i, row, col]):
            now_m = way_m[i, row, col]
        progress_m[i], left_m[i] = left_m[i] - now_m, now_m
        arrived[i] = math.hypot(goal_m[i, 0] - x, goal_m[i, 1] - y) <= arrived_m
