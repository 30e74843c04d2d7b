"""The engines by name, and a robot in a world on one of them."""

from __future__ import annotations

import math
from typing import Protocol

from sim import catalogue
from sim.engines.protocol import Engine
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap.errors import InputError
from sonarmap.registry import Registry
from worlds import Pose, World

__all__ = ["ENGINES", "EngineMaker", "open_engine"]


class EngineMaker(Protocol):
    """What `ENGINES` holds: an engine's class, or a function like it."""

    def __call__(self, world: World, start: Pose, *, gui: bool = False) -> Engine:
        """Return an engine with a robot at its start, clear of every solid, in a world.

        Raises
        ------
        InputError
            If what it needs is not installed, or it has no window and one is wanted.
        """


# The physics engine is imported when it is asked for.
ENGINES = Registry[EngineMaker]("engine", "sonarbed.engines", catalogue.ENGINES)


def open_engine(name: str, world: World, *, start: Pose | None = None, gui: bool = False) -> Engine:
    """Return the engine called `name` with a robot in a world; use it by ``with``.

    Parameters
    ----------
    name : str
        A name of `ENGINES`: "bullet", PyBullet with its dynamics, or "segments", the faces of the
        world alone with plain kinematics; or ``package.module:Name`` of an `EngineMaker`.
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
    make = ENGINES.find(name)
    start = world.start if start is None else start
    if not world.has_room_at(start.x_m, start.y_m, radius_m=BODY_RADIUS_M):
        raise InputError(
            f"start of ({start.x_m:g}, {start.y_m:g}) m, {math.degrees(start.heading_rad):g} "
            f"degrees must leave the robot (radius {BODY_RADIUS_M} m) clear of every solid"
        )
    return make(world, start, gui=gui)
