"""The engine without PyBullet: the world's exact faces, and plain kinematics between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import ClosedByWith
from sim.robot.amigobot import PHYSICS_DT_S
from sim.robot.kinematics import drive
from sonarmap.errors import InputError
from worlds import Faces, Pose, RayHits, World
from worlds.raycast import cast_rays

__all__ = ["Segments"]


class Segments(ClosedByWith):
    """A world with an AmigoBot, without masses and forces; use it by ``with``.

    Rays and walls are exact; wheels never slip; a robot that runs into something slides along
    it (see `sim.robot.kinematics.drive`).

    Parameters
    ----------
    world : World
        The room.
    start : Pose
        Where the robot begins, clear of every solid.
    gui : bool
        Must be False: there is no window.

    Attributes
    ----------
    table : FaceTable
        The faces, see `sim.engines.protocol.table_of`.
    """

    def __init__(self, world: World, start: Pose, *, gui: bool = False) -> None:
        if gui:
            raise InputError("engine 'segments' has no window: gui needs engine 'bullet'")
        self.table, self._faces = world.faces.table, world.faces
        self._pose = np.array([start.x_m, start.y_m, start.heading_rad], float)
        self._speeds_mps, self._turns_rad = np.zeros((2, 2))

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    @property
    def faces(self) -> Faces:
        """The faces that rays meet: a sonar may use them instead of rays."""
        return self._faces

    @property
    def pose(self) -> Pose:
        """True pose of the robot."""
        return Pose(*self._pose.tolist())

    @property
    def wheel_turns_rad(self) -> tuple[float, float]:
        """How far the left and right wheel have turned since the start, radians."""
        left, right = self._turns_rad.tolist()
        return left, right

    def advance(self, left_mps: float, right_mps: float, duration_s: float) -> bool:
        """Drive towards the given wheel speeds; return whether the robot touched something."""
        steps = round(duration_s / PHYSICS_DT_S)
        touched: bool = drive(
            self.table,
            0,
            self._pose,
            self._speeds_mps,
            self._turns_rad,
            float(left_mps),
            float(right_mps),
            steps,
        )
        return touched

    def cast(
        self,
        origins_xy_m: NDArray[np.float64],
        directions_xy: NDArray[np.float64],
        range_max_m: NDArray[np.float64],
    ) -> RayHits:
        """Return the first surface within ``range_max_m`` of each ray."""
        return RayHits(*cast_rays(self.table, 0, origins_xy_m, directions_xy, range_max_m))
