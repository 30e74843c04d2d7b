"""A drive: a robot's motion from one moment that matters to the next, and its odometry."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import Engine
from sim.robot import amigobot
from sim.robot.odometry import Odometer
from sim.sonar.firing import Firing
from sonarmap import InputError, SonarRing
from worlds import Pose

__all__ = ["Drive", "check_firing", "check_steps", "physics_steps", "transducers"]


class Drive:
    """The motion of a robot, told by the moments at which something happens.

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
        """Drive on to a moment."""
        steps = physics_steps(time_s) - physics_steps(self.time_s)
        self.time_s = time_s
        if steps > 0:
            duration_s = steps * amigobot.PHYSICS_DT_S
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


def check_firing(firing: Firing, sonars: int) -> None:
    """Raise `InputError` if a ring of so many sonars cannot fire between steps of the physics."""
    firing.check(sonars)
    offsets = {slot.offset_s for scan in (0, 1) for slot in firing.slots(scan, sonars)}
    check_steps("scan_period_s", firing.period_s)
    for offset_s in sorted(offsets - {0.0}):
        check_steps("the time between firings", offset_s)


def physics_steps(time_s: float) -> int:
    """Return how many steps of the physics a time is, rounded."""
    return round(time_s / amigobot.PHYSICS_DT_S)


def check_steps(name: str, time_s: float) -> None:
    """Raise `InputError` if a time is not a whole number of steps of the physics, at least one."""
    steps = time_s / amigobot.PHYSICS_DT_S
    if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
        raise InputError(f"{name} must be a multiple of {amigobot.PHYSICS_DT_S} s, got {time_s!r}")
