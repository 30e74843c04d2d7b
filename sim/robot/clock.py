"""The clock of the physics: times as whole numbers of its steps."""

from __future__ import annotations

from sim.robot.amigobot import PHYSICS_DT_S
from sonarmap.errors import InputError

__all__ = ["check_steps", "physics_steps"]


def physics_steps(time_s: float) -> int:
    """Return how many steps of the physics a time is, rounded."""
    return round(time_s / PHYSICS_DT_S)


def check_steps(name: str, time_s: float) -> None:
    """Raise `InputError` if a time is not a whole number of steps of the physics, at least one."""
    steps = time_s / PHYSICS_DT_S
    if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
        raise InputError(f"{name} must be a multiple of {PHYSICS_DT_S} s, got {time_s!r}")
