"""The environments. Their docstrings, with that of `SonarEnv`, are the specification."""

from __future__ import annotations

from typing import Any

from sim.envs.env import SonarEnv
from sim.envs.tasks.explore import Explore
from sim.envs.tasks.follow_wall import FollowWall
from sim.envs.tasks.navigate import Navigate
from sim.envs.tasks.task import Task
from sim.envs.vector import SonarVectorEnv

__all__ = [
    "ExploreEnv",
    "ExploreVectorEnv",
    "FollowWallEnv",
    "FollowWallVectorEnv",
    "NavigateEnv",
    "NavigateVectorEnv",
]


class ExploreEnv(SonarEnv):
    """Map an unknown room with sonar alone.

    Terms of the reward (weights: `ExploreWeights`)
    -----------------------------------------------
    ``map_score``: gain of the true map score in this step, bit m^2, summed over the cells that
    are not hidden. ``area``: m^2 of which a reading spoke for the first time. ``collision``: 1 if
    the robot touched something. ``effort``: mean square of the wanted wheel speeds over 0.75 m/s.

    Ends
    ----
    When the map calls 95 % of the cells that the robot can reach free; ``info["mapped_share"]``.
    After 1200 steps.
    """

    @classmethod
    def make_task(cls, robots: int, weights: Any) -> Task:
        """Return the task of so many robots."""
        return Explore(robots, weights)


class ExploreVectorEnv(SonarVectorEnv):
    """Many of `ExploreEnv` at once, see `SonarVectorEnv`."""

    env_class = ExploreEnv


class NavigateEnv(SonarEnv):
    """Reach a goal in a room that is seen only by sonar.

    Observation of the goal
    -----------------------
    ``goal``: float32 (3,) in [-1, 1], its range over 10 m (1 for farther), cosine and sine of its
    bearing, by odometry.

    Terms of the reward (weights: `NavigateWeights`)
    ------------------------------------------------
    ``progress``: metres by which the way to the goal has become shorter, around obstacles.
    ``arrival``: 1 on arrival. ``collision``: 1 if the robot touched something. ``stuck``: 1 if that
    ends the episode. ``effort``: mean square of the wanted wheel speeds over 0.75 m/s. ``time``: 1.

    Ends
    ----
    When the robot is within 0.3 m of the goal in truth, ``info["is_success"]``. After 400 steps.
    """

    @classmethod
    def make_task(cls, robots: int, weights: Any) -> Task:
        """Return the task of so many robots."""
        return Navigate(robots, weights)


class NavigateVectorEnv(SonarVectorEnv):
    """Many of `NavigateEnv` at once, see `SonarVectorEnv`."""

    env_class = NavigateEnv


class FollowWallEnv(SonarEnv):
    """Keep half a metre from the wall on the left, through corners and past openings.

    The distance is that of the nearest surface between 45 and 135 degrees to the left of the
    robot's middle.

    Terms of the reward (weights: `FollowWallWeights`)
    --------------------------------------------------
    ``following``: how well the distance is kept, 1 within 5 cm and 0 from 40 cm on, times the way
    ahead over that of a tenth of a second at full speed. ``collision``: 1 if the robot touched
    something. ``effort``: mean square of the wanted wheel speeds over 0.75 m/s.

    Ends
    ----
    After 600 steps.
    """

    @classmethod
    def make_task(cls, robots: int, weights: Any) -> Task:
        """Return the task of so many robots."""
        return FollowWall(robots, weights)


class FollowWallVectorEnv(SonarVectorEnv):
    """Many of `FollowWallEnv` at once, see `SonarVectorEnv`."""

    env_class = FollowWallEnv
