"""`Backend`: what moves the robots of an environment and fires their sonars."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.robot.odometry import OdometryModel
from sim.sonar.protocol import Sonar
from worlds import Pose, World

__all__ = ["Backend", "EpisodeSetup"]


@dataclass(frozen=True, eq=False)
class EpisodeSetup:
    """What the episode of one robot begins with.

    Parameters
    ----------
    world : World
        The room.
    start : Pose
        Where the robot begins, clear of every solid.
    sonar : Sonar
        Its sonars.
    odometry : OdometryModel
        Errors of its odometry.
    noise_rng, slip_rng : numpy.random.Generator
        Where the errors of the sonars and of the odometry are drawn from.
    """

    world: World
    start: Pose
    sonar: Sonar
    odometry: OdometryModel
    noise_rng: np.random.Generator
    slip_rng: np.random.Generator


class Backend(Protocol):
    """Robots that drive and fire their sonars, one a row."""

    @property
    def states(self) -> NDArray[np.void]:
        """State of each robot (`sim.envs.states.robot_dtype`), changed in place by the others."""

    def begin(self, row: int, setup: EpisodeSetup) -> None:
        """Begin an episode of one robot; what fires at time 0 is read."""

    def advance(self, wanted_mps: NDArray[np.float64], moves: NDArray[np.bool_]) -> None:
        """Drive the robots of the rows that move for one control step.

        Parameters
        ----------
        wanted_mps : ndarray, shape (robots, 2)
            Wanted speeds of the left and right wheel.
        moves : ndarray of bool, shape (robots,)
            Which robots; the others stay as they are.
        """

    def close(self) -> None:
        """Release what is held; closing twice is fine."""
