"""`CompiledDriver`: a driver as numbers, for compiled code that runs whole drives."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CONSTANT", "FOLLOW", "ROUTE", "WANDER", "CompiledDriver"]

CONSTANT, ROUTE, FOLLOW, WANDER = range(4)


@dataclass(frozen=True, slots=True)
class CompiledDriver:
    """A driver that `sim.robot.deciding` knows, as numbers.

    Parameters
    ----------
    kind : int
        `CONSTANT`, `ROUTE`, `FOLLOW` or `WANDER`.
    numbers : tuple of float
        Its parameters, see `sim.robot.deciding`.
    sectors_deg : tuple of (float, float)
        Between which headings it looks for the nearest reading, see `Sensed.nearest_m`.
    points_m : tuple of (x, y)
        Where it goes, in order and then again from the first.
    """

    kind: int
    numbers: tuple[float, ...]
    sectors_deg: tuple[tuple[float, float], ...] = ()
    points_m: tuple[tuple[float, float], ...] = ()
