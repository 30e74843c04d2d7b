"""Navigate: reach a goal in a room that is seen only by sonar."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from sim.amigobot import BODY_RADIUS_M
from sim.envs.tasks.task import Briefing, Moment, Verdict, weighted
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
        straight_m = math.dist(goal, (briefing.start.x_m, briefing.start.y_m))
        self._left_m[row] = straight_m
        start = np.array([[briefing.start.x_m, briefing.start.y_m]])
        self._left_m[row] = self._way_left(start, np.array([row]))[0]

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return the goal's range, as a share of 10 m, and the cosine and sine of its bearing."""
        pose = states["believed_pose"]
        dx, dy = (self._goal_m - pose[:, :2]).T
        bearing = np.arctan2(dy, dx) - pose[:, 2]
        goal = np.empty((len(states), 3), np.float32)
        goal[:, 0] = np.minimum(np.hypot(dx, dy) / _GOAL_RANGE_M, 1.0)
        goal[:, 1], goal[:, 2] = np.cos(bearing), np.sin(bearing)
        return {"goal": goal}

    def judge(self, moment: Moment) -> Verdict:
        """Judge the control step that has just ended."""
        place_m = moment.states["true_pose"][:, :2]
        left_m = self._way_left(place_m, np.arange(len(place_m)))
        progress_m, self._left_m = self._left_m - left_m, left_m
        dx, dy = (self._goal_m - place_m).T
        arrived = np.hypot(dx, dy) <= self.ARRIVED_M
        terms = navigate_terms(progress_m, arrived, moment.states["touched"], moment.effort)
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

    def _way_left(
        self, place_m: NDArray[np.float64], rows: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return how far robots have to drive; as before where the grid does not tell."""
        grid = self._grid[rows]
        cell = np.floor((place_m - grid[:, :2]) / grid[:, 2:]).astype(np.int64)
        inside = (cell >= 0).all(axis=1) & (cell < self._way_m.shape[:0:-1]).all(axis=1)
        cell[~inside] = 0
        way_m = np.where(inside, self._way_m[rows, cell[:, 1], cell[:, 0]], np.inf)
        return np.where(np.isfinite(way_m), way_m, self._left_m[rows])

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
    effort: NDArray[np.float64],
) -> dict[str, NDArray[np.float64]]:
    """Return the terms of the reward of one control step.

    Parameters
    ----------
    progress_m : ndarray
        How much shorter the way to the goal has become, metres.
    arrived, touched : ndarray of bool
        Whether the robot is there, and whether it touched something.
    effort : ndarray
        See `Moment`.
    """
    return {
        "progress": progress_m,
        "arrival": arrived.astype(float),
        "collision": touched.astype(float),
        "effort": effort,
        "time": np.ones(len(effort)),
    }
