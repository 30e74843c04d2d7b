"""Navigate: reach a goal in a room that is seen only by sonar."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from sim.envs.tasks.task import Evaluation, StepOutcome, Task, TaskSetup
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import InputError
from sonarmap.kernels.cells import cell_index
from sonarmap.kernels.jit import njit

__all__ = ["Navigate", "NavigateWeights", "navigate_terms"]

# A goal farther than this is observed as if it were so far.
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


class Navigate(Task):
    """Reach a goal in a room that is seen only by sonar.

    Observation of the goal
    -----------------------
    ``goal``: float32 (3,) in [-1, 1], its range over 10 m (1 for farther), cosine and sine of its
    bearing, by odometry.

    Terms of the reward (weights: `NavigateWeights`)
    ------------------------------------------------
    ``progress``: metres by which the drive to the goal has become shorter, around obstacles.
    ``arrival``: 1 on arrival. ``collision``: 1 if the robot touched something. ``stuck``: 1 if that
    ends the episode. ``effort``: mean square of the wanted wheel speeds over 0.75 m/s. ``time``: 1.

    Ends
    ----
    When the robot is within 0.3 m of the goal in truth, ``info["is_success"]``. After 400 steps.
    """

    weights_class = NavigateWeights
    # Control steps of a tenth of a second; assumed.
    max_episode_steps = 400
    observations: ClassVar[Mapping[str, Box]] = {
        "goal": Box(np.array([0, -1, -1], np.float32), np.ones(3, np.float32))
    }

    ARRIVED_M = 0.3
    """A robot this near to its goal, in truth, has arrived; assumed."""
    NEAREST_M, FARTHEST_M = 1.0, 8.0
    """Random goals are between so many metres of driving from the start; assumed."""

    def __init__(self, robots: int, weights: NavigateWeights | None = None) -> None:
        super().__init__(robots, weights)
        self._goal_m = np.zeros((robots, 2))
        self._left_m = np.zeros(robots)
        self._distance_m = np.zeros((robots, 1, 1), np.float32)
        # Lower-left corner and cell of each room's grid.
        self._grid = np.ones((robots, 3))

    def begin(self, row: int, setup: TaskSetup) -> None:
        """Begin the episode of one robot."""
        facts, goal = setup.facts, setup.goal
        if isinstance(goal, str):
            goal = facts.random_goal(setup.rng, setup.start, self.NEAREST_M, self.FARTHEST_M)
        elif not facts.is_reachable(*goal):
            raise InputError(
                f"goal of ({goal[0]:g}, {goal[1]:g}) m must be where the robot (radius "
                f"{BODY_RADIUS_M} m) fits and to where it can drive in {facts.world.name!r}"
            )
        self._goal_m[row] = goal
        distance_m = facts.distance_m(*goal)
        self._grow(*distance_m.shape)
        self._distance_m[row] = np.inf
        self._distance_m[row, : distance_m.shape[0], : distance_m.shape[1]] = distance_m
        self._grid[row] = *facts.grid.origin_xy_m, facts.grid.resolution_m
        begin = facts.grid.cell_of(setup.start.x_m, setup.start.y_m)
        left_m = float(distance_m[begin])
        # Where the grid does not say, at a wall, the straight line has to do.
        straight_m = math.dist(goal, (setup.start.x_m, setup.start.y_m))
        self._left_m[row] = left_m if math.isfinite(left_m) else straight_m

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return the goal's range, as a share of 10 m, and the cosine and sine of its bearing."""
        goal = np.empty((len(states), 3), np.float32)
        _observe_goals(states, self._goal_m, goal)
        return {"goal": goal}

    def evaluate(self, outcome: StepOutcome) -> Evaluation:
        """Evaluate the control step that has just ended."""
        states, robots = outcome.states, len(outcome.states)
        progress_m, arrived = np.empty(robots), np.empty(robots, bool)
        _measure_progress(
            states,
            self._goal_m,
            self._distance_m,
            self._grid,
            self.ARRIVED_M,
            self._left_m,
            progress_m,
            arrived,
        )
        terms = navigate_terms(
            progress_m, arrived, states["touched"], outcome.stuck, outcome.effort
        )
        return self.evaluation(terms, arrived | outcome.stuck, is_success=arrived)

    def goal_of(self, row: int) -> tuple[float, float] | None:
        """Return where a robot shall go, metres."""
        x_m, y_m = self._goal_m[row].tolist()
        return x_m, y_m

    def _grow(self, rows: int, cols: int) -> None:
        robots, had_rows, had_cols = self._distance_m.shape
        if rows > had_rows or cols > had_cols:
            old = self._distance_m
            shape = robots, max(rows, had_rows), max(cols, had_cols)
            self._distance_m = np.full(shape, np.inf, np.float32)
            self._distance_m[:, :had_rows, :had_cols] = old


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
        How much shorter the drive to the goal has become, metres.
    arrived, touched, stuck : ndarray of bool
        Whether the robot is there, whether it touched something, and whether it has for too long.
    effort : ndarray
        See `sim.envs.tasks.task.StepOutcome`.
    """
    return {
        "progress": progress_m,
        "arrival": arrived.astype(float),
        "collision": touched.astype(float),
        "stuck": stuck.astype(float),
        "effort": effort,
        "time": np.ones(len(effort)),
    }


@njit()
def _observe_goals(states, goal_m, goal):  # type: ignore[no-untyped-def]
    """Write where the goals are as the robots believe, see the environment's docstring."""
    for i in range(states.size):
        pose = states[i].believed_pose
        dx, dy = goal_m[i, 0] - pose[0], goal_m[i, 1] - pose[1]
        bearing = math.atan2(dy, dx) - pose[2]
        goal[i, 0] = min(math.hypot(dx, dy) / _GOAL_RANGE_M, 1.0)
        goal[i, 1], goal[i, 2] = math.cos(bearing), math.sin(bearing)


@njit()
def _measure_progress(states, goal_m, distance_m, grid, arrived_m, left_m, progress_m, arrived):  # type: ignore[no-untyped-def]
    """Write how much shorter the drives have become and who is there; change what is left.

    Where the grid does not say how far it is, close to a wall, the drive has not changed.
    """
    for i in range(states.size):
        x, y = states[i].true_pose[0], states[i].true_pose[1]
        col = cell_index(x, grid[i, 0], grid[i, 2])
        row = cell_index(y, grid[i, 1], grid[i, 2])
        now_m = left_m[i]
        known = 0 <= row < distance_m.shape[1] and 0 <= col < distance_m.shape[2]
        if known and math.isfinite(distance_m[i, row, col]):
            now_m = distance_m[i, row, col]
        progress_m[i], left_m[i] = left_m[i] - now_m, now_m
        arrived[i] = math.hypot(goal_m[i, 0] - x, goal_m[i, 1] - y) <= arrived_m
