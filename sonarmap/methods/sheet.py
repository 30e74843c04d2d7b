"""The blank sheet: every cell is a wall with the same probability, whatever the sonars say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.errors import InputError, finite
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["SHARE", "Sheet", "proper_share"]

SHARE = 0.06
"""Share of walls among the cells that can be seen: 4 to 8 % in the shipped rooms at 5 cm."""


@dataclass(frozen=True)
class Sheet:
    """A constant map, the floor that any method should beat.

    Parameters
    ----------
    share : float
        P(occupied) of every cell, in (0, 1): the prior share of walls.
    """

    name: ClassVar[str] = "sheet"
    source: ClassVar[str] = "Ours: the map of one who knows the share of walls and nothing else."

    share: float = SHARE

    def __post_init__(self) -> None:
        proper_share("share", self.share)

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the constant map, in which no cell counts as observed."""
        p = np.full(grid.shape, self.share)
        return OccupancyMap.from_probability(grid, p, np.zeros(grid.shape, bool))

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {"share": Real(0.01, 0.3)}


def proper_share(name: str, value: float) -> float:
    """Return a probability in (0, 1), else raise `InputError`."""
    if not 0 < finite(name, value) < 1:
        raise InputError(f"{name} must be in (0, 1), got {value!r}")
    return value
