"""The engines by name, and a robot in a world on one of them."""

from __future__ import annotations

import math

from sim.engines.protocol import Engine
from sim.engines.segments import Segments
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap.errors import InputError, did_you_mean
from worlds import Pose, World

__all__ = ["ENGINES", "open_engine"]

ENGINES = ("bullet", "segments")


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
        return Segments(world, start)
    from sim.engines.bullet import Bullet  # the physics engine: loaded when it is used

    return Bullet(world, start, gui=gui)
