"""`Task`: what a robot is asked to do, how well it does, and when it is done."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from sim.envs.facts import RoomFacts
from sim.envs.maps.robot_maps import RobotMaps
from worlds import Pose

__all__ = ["Briefing", "Moment", "Task", "Verdict", "weighted"]


@dataclass(frozen=True, slots=True, eq=False)
class Briefing:
    """What a task is told when an episode begins.

    Parameters
    ----------
    facts : RoomFacts
        The truth of the room.
    start : Pose
        Where the robot begins.
    goal : str or tuple of float
        "random", or a place (x, y) in metres, for tasks that have a goal.
    rng : numpy.random.Generator
        What the task draws comes from it.
    """

    facts: RoomFacts
    start: Pose
    goal: str | tuple[float, float]
    rng: np.random.Generator


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """What a task judges: robots at the end of a control step, a row a robot.

    Parameters
    ----------
    states : structured ndarray, shape (robots,)
        See `sim.envs.states.robot_dtype`.
    stuck : ndarray of bool, shape (robots,)
        Robots that have touched something for too long.
    effort : ndarray, shape (robots,)
        Mean square of the wanted wheel speeds, as shares of the fastest; in [0, 1].
    maps : RobotMaps or None
        What the robots have mapped, if anybody asks for it.
    """

    states: NDArray[np.void]
    stuck: NDArray[np.bool_]
    effort: NDArray[np.float64]
    maps: RobotMaps | None


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """How well the robots do, a row a robot.

    Parameters
    ----------
    terms : mapping of str to ndarray, shape (robots,)
        The terms of the reward, without their weights.
    reward : ndarray, shape (robots,)
        Their weighted sum.
    terminated : ndarray of bool, shape (robots,)
        Who is done.
    info : mapping of str to ndarray
        What else there is to tell.
    """

    terms: Mapping[str, NDArray[np.float64]]
    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    info: Mapping[str, NDArray[Any]]


class Task(Protocol):
    """What robots are asked to do; holds the task's state of every robot."""

    needs_maps: bool
    """Whether it judges the robots' maps."""

    observations: Mapping[str, Box]
    """What the robot is told beside what it senses."""

    def begin(self, row: int, briefing: Briefing) -> None:
        """Begin the episode of one robot."""

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return new arrays of what is in `observations`, a row a robot."""

    def judge(self, moment: Moment) -> Verdict:
        """Judge the control step that has just ended."""

    def goal_of(self, row: int) -> tuple[float, float] | None:
        """Return where a robot shall go, for the picture."""


def weighted(
    terms: Mapping[str, NDArray[np.float64]], weights: Mapping[str, float]
) -> NDArray[np.float64]:
    """Return the weighted sum of the terms of a reward."""
    reward: NDArray[np.float64] = sum(weights[name] * value for name, value in terms.items())  # type: ignore[assignment]
    return reward
