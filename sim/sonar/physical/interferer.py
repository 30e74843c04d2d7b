"""A fixed source of sound: another robot's sonar, or a beacon."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import finite, positive

__all__ = ["Interferer"]


@dataclass(frozen=True, slots=True)
class Interferer:
    """Sends pulses of the sonars' frequency in all directions, again and again.

    Parameters
    ----------
    x_m, y_m : float
        Its place in the room, at the height of the sonars.
    period_s : float
        Time from one pulse to the next, seconds, > 0.
    first_s : float
        Time of one of its pulses, seconds.
    level_db : float
        Its level against that of a sonar on its axis, decibels.
    """

    x_m: float
    y_m: float
    period_s: float
    first_s: float = 0.0
    level_db: float = 0.0

    def __post_init__(self) -> None:
        positive("period_s", self.period_s)
        for name in ("x_m", "y_m", "first_s", "level_db"):
            finite(name, getattr(self, name))

    def pulses_s(self, from_s: float, to_s: float) -> NDArray[np.float64]:
        """Return the times of its pulses from one time to another."""
        first = math.ceil((from_s - self.first_s) / self.period_s)
        last = math.floor((to_s - self.first_s) / self.period_s)
        pulses_s: NDArray[np.float64] = self.first_s + self.period_s * np.arange(
            first, last + 1, dtype=float
        )
        return pulses_s
