"""What the simulator asks of an engine: rays and motion, nothing else."""

from __future__ import annotations

import math
from types import TracebackType
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from sim.amigobot import BODY_RADIUS_M
from sonarmap.errors import InputError, did_you_mean
from worlds import Pose, RayHits, World

__all__ = ["ENGINES", "ClosedByWith", "Engine", "RayCaster", "open_engine"]

ENGINES = ("bullet", "segments")


class RayCaster(Protocol):
    """Casts rays at the surfaces of a world; the robot itself is invisible to them."""

    def cast(
        self,
        origins_xy_m: NDArray[np.float64],
        directions_xy: NDArray[np.float64],
        range_max_m: NDArray[np.float64],
    ) -> RayHits:
        """Return the first surface within ``range_max_m`` of each of n rays.

        Parameters
        ----------
        origins_xy_m, directions_xy : ndarray, shape (n, 2)
            Where each ray begins, metres, and its unit direction.
        range_max_m : ndarray, shape (n,)
            How far each ray goes, metres, > 0.
        """


class Engine(RayCaster, Protocol):
    """A robot in a world: it drives, it collides, and rays can be cast from it."""

    @property
    def pose(self) -> Pose:
        """True pose of the robot."""

    @property
    def wheel_turns_rad(self) -> tuple[float, float]:
        """How far the left and right wheel have turned since the start, radians."""

    def advance(self, left_mps: float, right_mps: float, duration_s: float) -> bool:
        """Drive towards the given wheel speeds; return whether the robot touched something.

        Speeds are reached within the robot's limits (`sim.kinematics.limited_speeds`).
        `duration_s` is a whole multiple of `sim.amigobot.PHYSICS_DT_S`.
        """

    def close(self) -> None:
        """Release what the engine holds; closing twice is fine."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...


class ClosedByWith:
    """What is closed when the ``with`` that uses it ends."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Release what is held; closing twice is fine."""
        raise NotImplementedError


def open_engine(name: str, world: World, *, start: Pose | None = None, gui: bool = False) -> Engine:
    """Return the engine called `name` with a robot in a world; use it by ``with``.

    Parameters
    ----------
    name : {"bullet", "segments"}
        PyBullet with its dynamics, or the faces of the world alone with plain kinematics.
    world : World
        The room.
    start : Pose, optional
        Where the robot begins; by default the world's start.
    gui : bool
        Show the engine's window, if it has one.

    Raises
    ------
    InputError
        If there is no such engine, what it needs is not installed, it has no window, or the
        robot does not fit at the start.
    """
    if name not in ENGINES:
        raise InputError(f"engine {name!r} is unknown{did_you_mean(name, ENGINES)}")
    start = world.start if start is None else start
    if not world.has_room_at(start.x_m, start.y_m, radius_m=BODY_RADIUS_M):
        raise InputError(
            f"start of ({start.x_m:g}, {start.y_m:g}) m, {math.degrees(start.heading_rad):g} "
            f"degrees must leave the robot (radius {BODY_RADIUS_M} m) clear of every solid"
        )
    if name == "segments":
        if gui:
            raise InputError("engine 'segments' has no window: gui needs engine 'bullet'")
        from sim.segments import Segments

        return Segments(world, start)
    from sim.bullet import Bullet  # the physics engine: loaded when it is used

    return Bullet(world, start, gui=gui)
