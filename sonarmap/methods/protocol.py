"""What a mapping method is: anything that turns a log into an occupancy map on a given grid."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Space
from sonarmap.rings import SonarRing

__all__ = ["IncrementalMap", "IncrementalMethod", "MappingMethod"]


@runtime_checkable
class MappingMethod(Protocol):
    """A way from a log to a map: a frozen dataclass of its parameters.

    `name` is what `sonarmap.method` and the command line call it, `source` one sentence on where
    it comes from; both are class variables.
    """

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def source(self) -> str:
        """Where it comes from."""

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid; stale and rejected readings are never used."""

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched: ranges of parameters by their names."""


class IncrementalMap(Protocol):
    """A map that grows reading by reading."""

    def add(self, readings: SonarLog) -> None:
        """Add readings of the ring that the map was begun for, in the order of firing."""

    @property
    def map(self) -> OccupancyMap:
        """The map so far; later readings do not change it."""


@runtime_checkable
class IncrementalMethod(MappingMethod, Protocol):
    """A mapping method that also takes readings one at a time, as an environment has them."""

    def begin(self, ring: SonarRing, grid: GridSpec) -> IncrementalMap:
        """Return an empty map on a grid; adding a whole log to it equals `map`."""
