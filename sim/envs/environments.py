"""The environments. Their class docstrings are the specification."""

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

    Observation
    -----------
    A dictionary of new arrays:

    ================  ================  =========  ================================================
    ``range``         float32 (8,)      [0, 1]     newest reading of each sonar over its maximum
                                                   range; 1 for no echo, 0 for too close
    ``validity``      int8 (8,)         {0, 1}     1 if that reading is a range
    ``speed``         float32 (2,)      [-1, 1]    speed ahead and turn rate by the encoders over
                                                   0.75 m/s and 0.87 rad/s
    ``last_action``   float32 (2,)      [-1, 1]    shares of the limits that were wanted last
    ``map``           uint8 (1, n, n)   [0, 255]   with ``map_patch=n``: P(occupied) times 255
                                                   around the robot by odometry, ahead is up; 128
                                                   is unknown
    ================  ================  =========  ================================================

    Action
    ------
    ``action="velocity"``: float32 (2,) in [-1, 1], speed ahead over 0.75 m/s and turn rate over
    0.87 rad/s. ``"wheels"``: float32 (2,) in [-1, 1], left and right wheel over 0.75 m/s.
    ``"discrete"``: 0 ahead, 1 and 2 in a curve to the left and right, 3 and 4 turn left and right
    in place, 5 back. Whatever is wanted, the robot's own limits of speed, turn rate and
    acceleration hold (`sim.kinematics.limited_speeds`). A step is 0.1 s.

    Reward
    ------
    The weighted sum of ``map_score`` (gain of the true map score in this step, bit m^2: summed
    over the cells that are not hidden), ``area`` (m^2 of which a reading spoke for the first
    time), ``collision`` (1 if it touched something) and ``effort`` (mean square of the wanted
    wheel speeds over 0.75 m/s).
    ``info["reward_terms"]`` has the terms without their weights; these are a frozen value,
    `ExploreWeights`.

    Begin, end, faults
    ------------------
    The robot begins at rest in a random place of the room (``start``). The episode ends when
    the map calls 95 % of the cells that the robot can reach free, or when the robot has touched
    something for 2 s without a break. The time
    limit, 1200 steps, belongs to the registration. An action outside of the space, a step after
    the end or after ``close``, an unknown option and a start in a wall are errors that name the
    rule.

    Arguments
    ---------
    See `sim.envs.SonarEnv`. ``world``, ``sonar``, ``odometry``, ``start``, ``goal`` and
    ``randomisation`` (see `sim.envs.EpisodeOptions`) may also be given to ``reset`` in
    ``options``, for one episode.
    """

    @classmethod
    def _make_task(cls, robots: int, weights: Any) -> Task:
        return Explore(robots, weights)


class ExploreVectorEnv(SonarVectorEnv):
    """Many of `ExploreEnv` at once, see `SonarVectorEnv`."""

    env_class = ExploreEnv


class NavigateEnv(SonarEnv):
    """Reach a goal in a room that is seen only by sonar.

    Observation
    -----------
    A dictionary of new arrays:

    ================  ================  =========  ================================================
    ``range``         float32 (8,)      [0, 1]     newest reading of each sonar over its maximum
                                                   range; 1 for no echo, 0 for too close
    ``validity``      int8 (8,)         {0, 1}     1 if that reading is a range
    ``speed``         float32 (2,)      [-1, 1]    speed ahead and turn rate by the encoders over
                                                   0.75 m/s and 0.87 rad/s
    ``last_action``   float32 (2,)      [-1, 1]    shares of the limits that were wanted last
    ``goal``          float32 (3,)      [-1, 1]    range of the goal over 10 m, cosine and sine of
                                                   its bearing, by odometry
    ``map``           uint8 (1, n, n)   [0, 255]   with ``map_patch=n``: P(occupied) times 255
                                                   around the robot by odometry, ahead is up; 128
                                                   is unknown
    ================  ================  =========  ================================================

    Action
    ------
    ``action="velocity"``: float32 (2,) in [-1, 1], speed ahead over 0.75 m/s and turn rate over
    0.87 rad/s. ``"wheels"``: float32 (2,) in [-1, 1], left and right wheel over 0.75 m/s.
    ``"discrete"``: 0 ahead, 1 and 2 in a curve to the left and right, 3 and 4 turn left and right
    in place, 5 back. Whatever is wanted, the robot's own limits of speed, turn rate and
    acceleration hold (`sim.kinematics.limited_speeds`). A step is 0.1 s.

    Reward
    ------
    The weighted sum of ``progress`` (metres by which the way to the goal has become shorter,
    around obstacles), ``arrival`` (1 on arrival), ``collision`` (1 if it touched something),
    ``effort`` (mean square of the wanted wheel speeds over 0.75 m/s) and ``time`` (1).
    ``info["reward_terms"]`` has the terms without their weights; these are a frozen value,
    `NavigateWeights`.

    Begin, end, faults
    ------------------
    The robot begins at rest in a random place of the room (``start``). The episode ends when
    the robot is within 0.3 m of the goal in truth (``info["is_success"]``), or has touched
    something for 2 s without a break. The time
    limit, 400 steps, belongs to the registration. An action outside of the space, a step after
    the end or after ``close``, an unknown option and a start in a wall are errors that name the
    rule.

    Arguments
    ---------
    See `sim.envs.SonarEnv`. ``world``, ``sonar``, ``odometry``, ``start``, ``goal`` and
    ``randomisation`` (see `sim.envs.EpisodeOptions`) may also be given to ``reset`` in
    ``options``, for one episode.
    """

    @classmethod
    def _make_task(cls, robots: int, weights: Any) -> Task:
        return Navigate(robots, weights)


class NavigateVectorEnv(SonarVectorEnv):
    """Many of `NavigateEnv` at once, see `SonarVectorEnv`."""

    env_class = NavigateEnv


class FollowWallEnv(SonarEnv):
    """Keep half a metre from the wall on the left, through corners and past openings.

    Observation
    -----------
    A dictionary of new arrays:

    ================  ================  =========  ================================================
    ``range``         float32 (8,)      [0, 1]     newest reading of each sonar over its maximum
                                                   range; 1 for no echo, 0 for too close
    ``validity``      int8 (8,)         {0, 1}     1 if that reading is a range
    ``speed``         float32 (2,)      [-1, 1]    speed ahead and turn rate by the encoders over
                                                   0.75 m/s and 0.87 rad/s
    ``last_action``   float32 (2,)      [-1, 1]    shares of the limits that were wanted last
    ``map``           uint8 (1, n, n)   [0, 255]   with ``map_patch=n``: P(occupied) times 255
                                                   around the robot by odometry, ahead is up; 128
                                                   is unknown
    ================  ================  =========  ================================================

    Action
    ------
    ``action="velocity"``: float32 (2,) in [-1, 1], speed ahead over 0.75 m/s and turn rate over
    0.87 rad/s. ``"wheels"``: float32 (2,) in [-1, 1], left and right wheel over 0.75 m/s.
    ``"discrete"``: 0 ahead, 1 and 2 in a curve to the left and right, 3 and 4 turn left and right
    in place, 5 back. Whatever is wanted, the robot's own limits of speed, turn rate and
    acceleration hold (`sim.kinematics.limited_speeds`). A step is 0.1 s.

    Reward
    ------
    The weighted sum of ``following`` (how well the distance is kept, 1 within 5 cm and 0 from
    40 cm on, times the way ahead over that of a tenth of a second at full speed), ``collision``
    (1 if it touched something) and ``effort`` (mean square of the wanted wheel speeds over
    0.75 m/s). The distance is that of the nearest surface between 45 and 135 degrees to the left.
    ``info["reward_terms"]`` has the terms without their weights; these are a frozen value,
    `FollowWallWeights`.

    Begin, end, faults
    ------------------
    The robot begins at rest in a random place of the room (``start``). The episode ends when
    the robot has touched something for 2 s without a break. The time
    limit, 600 steps, belongs to the registration. An action outside of the space, a step after
    the end or after ``close``, an unknown option and a start in a wall are errors that name the
    rule.

    Arguments
    ---------
    See `sim.envs.SonarEnv`. ``world``, ``sonar``, ``odometry``, ``start``, ``goal`` and
    ``randomisation`` (see `sim.envs.EpisodeOptions`) may also be given to ``reset`` in
    ``options``, for one episode.
    """

    @classmethod
    def _make_task(cls, robots: int, weights: Any) -> Task:
        return FollowWall(robots, weights)


class FollowWallVectorEnv(SonarVectorEnv):
    """Many of `FollowWallEnv` at once, see `SonarVectorEnv`."""

    env_class = FollowWallEnv
