"""A robot's motion from one event to the next, and its odometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import Engine
from sim.robot.amigobot import PHYSICS_DT_S
from sim.robot.clock import physics_steps
from sim.robot.odometry import Odometer
from sonarmap import SonarRing
from worlds import Pose

__all__ = ["Motion", "transducers"]


class Motion:
    """The motion of a robot, driven from event to event: firings, packets, ends of control steps.

    Parameters
    ----------
    robot : Engine
        What moves it.
    odometer : Odometer
        What it believes.

    Attributes
    ----------
    time_s : float
        Time since the start, seconds.
    speeds_mps : tuple of float
        Wanted speeds of the left and right wheel.
    """

    def __init__(self, robot: Engine, odometer: Odometer) -> None:
        self._robot, self._odometer = robot, odometer
        self._touched = False
        self.time_s = 0.0
        self.speeds_mps = (0.0, 0.0)

    @property
    def true_pose(self) -> Pose:
        """Where the robot is."""
        return self._robot.pose

    @property
    def believed_pose(self) -> Pose:
        """Where the robot believes to be."""
        return self._odometer.pose

    def until(self, time_s: float) -> None:
        """Drive on to a time."""
        steps = physics_steps(time_s) - physics_steps(self.time_s)
        self.time_s = time_s
        if steps > 0:
            duration_s = steps * PHYSICS_DT_S
            touched = self._robot.advance(*self.speeds_mps, duration_s)
            self._touched = self._touched or touched
            self._odometer.update(self._robot.wheel_turns_rad)

    def touched_since(self) -> bool:
        """Return whether the robot touched something since the last call."""
        touched, self._touched = self._touched, False
        return touched


def transducers(ring: SonarRing, pose: Pose) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places (k, 2) and the axes (k,) of a ring's sonars at a pose."""
    places = ring.sensor_xy_m(slice(None), pose.x_m, pose.y_m, pose.heading_rad)
    return places, pose.heading_rad + ring.heading_rad
