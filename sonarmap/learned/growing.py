"""`GrowingLog`: readings as they come, and when it is time to look at them all again.

The learned mapper looks at a log as a whole: which arcs win cells, which readings repeat others.
A map of the past is therefore made anew, not added to, whenever the robot has driven on. In
between, readings are only kept, so that most cost next to nothing. Drives that grow long are looked
at more rarely, by a share of their way, so that the cost of a reading grows slowly.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sonarmap.errors import InputError
from sonarmap.log import SonarLog
from sonarmap.rings import SonarRing

__all__ = ["GrowingLog", "joined"]

# A map is due after this way, plus this share of all of it, or this turn, or so many readings of a
# robot that stands. Assumed.
_WAY_M, _WAY_SHARE, _TURN_RAD, _READINGS = 0.10, 0.01, math.radians(20), 100


class GrowingLog:
    """Readings of a ring in the order of firing.

    Parameters
    ----------
    ring : SonarRing
        The sonars.
    """

    def __init__(self, ring: SonarRing) -> None:
        self.ring = ring
        self._parts: list[SonarLog] = []
        self._last: tuple[float, float, float] | None = None
        self._way_m = self._due_way_m = self._turned_rad = 0.0
        self._new = 0

    def add(self, readings: SonarLog) -> None:
        """Add readings; a usable one that is not too close counts as new.

        Raises
        ------
        InputError
            If they are of another ring.
        """
        if readings.ring != self.ring:
            raise InputError(
                f"readings must be of the ring {self.ring.name!r}, got {readings.ring.name!r}"
            )
        if not len(readings):
            return
        self._parts.append(readings)
        self._new += int((readings.usable & (readings.range_m >= 0)).sum())
        here = float(readings.x_m[-1]), float(readings.y_m[-1]), float(readings.heading_rad[-1])
        if self._last is not None:
            self._way_m += math.dist(here[:2], self._last[:2])
            turned = math.remainder(here[2] - self._last[2], 2 * math.pi)
            self._turned_rad += abs(turned)
        self._last = here

    @property
    def is_due(self) -> bool:
        """Whether so much is new that the map should be made anew; at the first reading it is."""
        return self._new > 0 and (
            self._due_way_m == 0.0
            or self._way_m >= self._due_way_m
            or self._turned_rad >= _TURN_RAD
            or self._new >= _READINGS
        )

    def whole(self) -> SonarLog:
        """Return all readings as one log, numbered by scans as they came; nothing is new then."""
        self._due_way_m = self._way_m + _WAY_M + _WAY_SHARE * self._way_m
        self._turned_rad, self._new = 0.0, 0
        if len(self._parts) > 1:
            self._parts = [joined(self._parts)]
        return self._parts[0]


def joined(parts: list[SonarLog]) -> SonarLog:
    """Return logs of a ring, each later than the one before, as one; without their truth."""
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in SonarLog.DTYPES
    }
    # Each part may count its scans from 0.
    for name in ("scan", "time_s"):
        columns[name] = np.maximum.accumulate(columns[name])
    return SonarLog(parts[0].ring, **columns)
