"""Follow a wall: keep a set distance to it, through corners and past openings."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.envs.rooms import Rooms
from sim.envs.tasks.task import Evaluation, StepOutcome, Task, TaskSetup
from sim.robot.amigobot import SPEED_MAX_MPS
from sonarmap.kernels.jit import njit
from worlds.raycast import first_hit

__all__ = ["FollowWall", "FollowWallWeights", "closeness", "follow_terms"]

# Where a wall beside the robot is looked for, off its heading: at a right angle and half a right
# angle to both sides of that.
_FROM_RAD, _TO_RAD, _LOOKS = math.radians(45), math.radians(135), 7
# A wall farther than this is no wall to follow.
_FARTHEST_M = 2.0


@dataclass(frozen=True, slots=True)
class FollowWallWeights:
    """Weights of the reward's terms, see `follow_terms`."""

    following: float = 1.0
    collision: float = -0.5
    effort: float = -0.01


class FollowWall(Task):
    """Keep half a metre from the wall on the left, through corners and past openings.

    The distance is that of the nearest surface between 45 and 135 degrees to the left of the
    robot's middle.

    Terms of the reward (weights: `FollowWallWeights`)
    --------------------------------------------------
    ``following``: how well the distance is kept, 1 within 5 cm and 0 from 40 cm on, times the
    distance driven ahead over that of a tenth of a second at full speed. ``collision``: 1 if the
    robot touched something. ``effort``: mean square of the wanted wheel speeds over 0.75 m/s.

    Ends
    ----
    After 600 steps.
    """

    weights_class = FollowWallWeights
    # Control steps of a tenth of a second; assumed.
    max_episode_steps = 600

    DISTANCE_M = 0.5
    """Wanted distance of the robot's centre from the wall; assumed."""
    EXACT_M, LOST_M = 0.05, 0.4
    """Errors that count as none, and as having lost the wall; assumed."""

    def __init__(self, robots: int, weights: FollowWallWeights | None = None) -> None:
        super().__init__(robots, weights)
        self._rooms = Rooms(robots)
        self._room = np.zeros(robots, np.int64)
        self._place_m = np.zeros((robots, 2))

    def begin(self, row: int, setup: TaskSetup) -> None:
        """Begin the episode of one robot."""
        self._room[row] = self._rooms.enter(row, setup.facts.world)
        self._place_m[row] = setup.start.x_m, setup.start.y_m

    def evaluate(self, outcome: StepOutcome) -> Evaluation:
        """Evaluate the control step that has just ended."""
        pose = outcome.states["true_pose"]
        wall_m = _wall_beside(self._rooms.table, self._room, pose)
        moved_m = pose[:, :2] - self._place_m
        self._place_m = pose[:, :2].copy()
        ahead_m = moved_m[:, 0] * np.cos(pose[:, 2]) + moved_m[:, 1] * np.sin(pose[:, 2])
        error_m = np.abs(wall_m - self.DISTANCE_M)
        close = closeness(error_m, self.EXACT_M, self.LOST_M)
        terms = follow_terms(close, ahead_m, outcome.states["touched"], outcome.effort)
        return self.evaluation(terms, outcome.stuck.copy(), wall_m=wall_m, closeness=close)


def closeness(error_m: NDArray[np.float64], exact_m: float, lost_m: float) -> NDArray[np.float64]:
    """Return 1 for an error up to `exact_m`, 0 from `lost_m` on, and a straight line between."""
    return np.clip((lost_m - error_m) / (lost_m - exact_m), 0.0, 1.0)


def follow_terms(
    close: NDArray[np.float64],
    ahead_m: NDArray[np.float64],
    touched: NDArray[np.bool_],
    effort: NDArray[np.float64],
) -> dict[str, NDArray[np.float64]]:
    """Return the terms of the reward of one control step.

    Parameters
    ----------
    close : ndarray
        How well the distance is kept, in [0, 1].
    ahead_m : ndarray
        How far the robot has driven ahead, metres; negative backwards.
    touched : ndarray of bool
        Whether the robot touched something.
    effort : ndarray
        See `sim.envs.tasks.task.StepOutcome`.

    Notes
    -----
    Following is the product: neither to stand at the right distance nor to drive far from any
    wall earns anything. Its unit is that of a tenth of a second at full speed.
    """
    return {
        "following": close * ahead_m / (0.1 * SPEED_MAX_MPS),
        "collision": touched.astype(float),
        "effort": effort,
    }


@njit()
def _wall_beside(table, rooms, poses):  # type: ignore[no-untyped-def]
    """Return how far the nearest face on the left of each robot is, inf beyond `_FARTHEST_M`."""
    segments, _, circles, _, _, grid, shape, cell_start, cell_face = table
    nearest = np.full(rooms.size, np.inf)
    for i in range(rooms.size):
        for k in range(_LOOKS):
            angle = poses[i, 2] + _FROM_RAD + (_TO_RAD - _FROM_RAD) * k / (_LOOKS - 1)
            distance, _ = first_hit(
                segments, circles, grid, shape, cell_start, cell_face,
                rooms[i], poses[i, 0], poses[i, 1], math.cos(angle), math.sin(angle), _FARTHEST_M,
            )  # fmt: skip
            nearest[i] = min(nearest[i], distance)
    return nearest
