"""Follow a wall: keep a set distance to it, through corners and past openings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from gymnasium.spaces import Box
from numba import njit
from numpy.typing import NDArray

from sim.envs.rooms import Rooms
from sim.envs.tasks.task import Briefing, Moment, Verdict, weighted
from sim.robot.amigobot import SPEED_MAX_MPS
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


class FollowWall:
    """Judges how robots keep their distance to the wall on their left.

    Parameters
    ----------
    robots : int
        How many.
    weights : FollowWallWeights, optional
        Of the terms of the reward.
    """

    DISTANCE_M = 0.5
    """Wanted distance of the robot's centre from the wall; assumed."""
    EXACT_M, LOST_M = 0.05, 0.4
    """Errors that count as none, and as having lost the wall; assumed."""

    needs_maps = False
    observations: Mapping[str, Box] = {}

    def __init__(self, robots: int, weights: FollowWallWeights | None = None) -> None:
        self._weights = asdict(weights or FollowWallWeights())
        self._rooms = Rooms(robots)
        self._room = np.zeros(robots, np.int64)
        self._place_m = np.zeros((robots, 2))

    def begin(self, row: int, briefing: Briefing) -> None:
        """Begin the episode of one robot."""
        self._room[row] = self._rooms.enter(row, briefing.facts.world)
        self._place_m[row] = briefing.start.x_m, briefing.start.y_m

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return nothing: the robot is told nothing."""
        return {}

    def judge(self, moment: Moment) -> Verdict:
        """Judge the control step that has just ended."""
        pose = moment.states["true_pose"]
        wall_m = _wall_beside(self._rooms.table, self._room, pose)
        way_m = pose[:, :2] - self._place_m
        self._place_m = pose[:, :2].copy()
        ahead_m = way_m[:, 0] * np.cos(pose[:, 2]) + way_m[:, 1] * np.sin(pose[:, 2])
        error_m = np.abs(wall_m - self.DISTANCE_M)
        close = closeness(error_m, self.EXACT_M, self.LOST_M)
        terms = follow_terms(close, ahead_m, moment.states["touched"], moment.effort)
        return Verdict(
            terms,
            weighted(terms, self._weights),
            moment.stuck.copy(),
            {"wall_m": wall_m, "closeness": close},
        )

    def goal_of(self, row: int) -> tuple[float, float] | None:
        """Return None: there is no goal."""
        return None


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
        See `Moment`.

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


@njit(cache=True)
def _wall_beside(table, rooms, poses):
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
