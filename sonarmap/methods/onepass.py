"""What methods have in common that take each reading once and keep their belief in layers."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol, Self, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, finite, one_of, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.cones import Beams, Cells, NoEcho, beams_of, cone_cells
from sonarmap.methods.conversion import Convertible
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Space
from sonarmap.rings import SonarRing

__all__ = ["ConeMethod", "EvidenceMethod", "Layers", "OnePass", "OnePassMap", "Scene", "Votes"]

Layers = dict[str, NDArray[Any]]
"""What a method believes of the cells, by name: arrays over the flat grid."""

# The polynomial of the kernel for the bearing is exact to 1e-11 up to here.
_WIDEST_RAD = math.pi / 2


class Votes(Protocol):
    """Which of a beam's cells may be told something: a remedy for repeated readings."""

    def admit(self, beams: Beams, cells: Cells) -> Cells:
        """Return the cells that these beams may touch, and remember that they did."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Where a method works: the ring, the grid, and what follows from its parameters for them.

    Parameters
    ----------
    ring, grid
        The sonars and the cells.
    half_angle_rad : float
        Half-angle of the cones.
    limit_m : float
        Longest reading that is taken as an echo.
    """

    ring: SonarRing
    grid: GridSpec
    half_angle_rad: float
    limit_m: float

    @property
    def size(self) -> int:
        """Number of cells."""
        return self.grid.rows * self.grid.cols


@dataclass(frozen=True, kw_only=True)
class EvidenceMethod(Convertible, ABC):
    """What all methods have in common that read a log through the cells that its beams touch.

    Parameters
    ----------
    no_echo : {"ignore", "clear"}
        What no echo means: nothing, or that the cone is free up to the longest reading used.
    max_range_m : float, optional
        Readings above it are taken as no echo, metres, > 0. By default the ring's maximum range.
    scale, offset
        See `Convertible`.
    """

    name: ClassVar[str]
    source: ClassVar[str]

    no_echo: NoEcho = "ignore"
    max_range_m: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of("no_echo", self.no_echo, get_args(NoEcho))
        if self.max_range_m is not None:
            positive("max_range_m", self.max_range_m)

    @classmethod
    @abstractmethod
    def space(cls) -> Space:
        """Return what may be searched."""

    @abstractmethod
    def fuse(self, log: SonarLog, grid: GridSpec, votes: Votes | None = None) -> OccupancyMap:
        """Return the map of a log on a grid, with a remedy for repeated readings or without."""

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid."""
        return self.fuse(log, grid)

    def replace(self, **changes: Any) -> Self:
        """Return the method with some parameters replaced."""
        return dataclasses.replace(self, **changes)

    def longest_reading_m(self, ring: SonarRing) -> float:
        """Return the range above which a reading is taken as no echo, metres."""
        return ring.range_max_m if self.max_range_m is None else self.max_range_m

    def cone_rad(self, ring: SonarRing) -> float:
        """Return the half-angle of the cones."""
        return ring.half_angle_rad

    def scene(self, ring: SonarRing, grid: GridSpec) -> Scene:
        """Return where to work, with what the ring decides filled in."""
        return Scene(ring, grid, self.cone_rad(ring), self.longest_reading_m(ring))

    def touched(
        self,
        scene: Scene,
        beams: Beams,
        reach_m: NDArray[np.float64],
        votes: Votes | None = None,
    ) -> Iterator[tuple[Beams, Cells]]:
        """Return beams, part by part, with the cells of their cones that they may touch."""
        for rows, cells in cone_cells(beams, scene.grid, scene.half_angle_rad, reach_m):
            part = beams.select(rows)
            yield part, cells if votes is None else votes.admit(part, cells)


@dataclass(frozen=True, kw_only=True)
class ConeMethod(EvidenceMethod):
    """A method of evidence whose cones may be narrower or wider than the ring's.

    Parameters
    ----------
    half_angle_rad : float, optional
        Half-angle of the cone, in (0, pi/2). By default the ring's.
    no_echo, max_range_m, scale, offset
        See `EvidenceMethod`.
    """

    half_angle_rad: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.half_angle_rad is not None and not (
            0 < finite("half_angle_rad", self.half_angle_rad) < _WIDEST_RAD
        ):
            raise InputError(f"half_angle_rad must be in (0, pi/2), got {self.half_angle_rad!r}")

    def cone_rad(self, ring: SonarRing) -> float:
        """Return the half-angle of the cones."""
        return ring.half_angle_rad if self.half_angle_rad is None else self.half_angle_rad


@dataclass(frozen=True, kw_only=True)
class OnePass(EvidenceMethod):
    """A method whose belief grows reading by reading."""

    @abstractmethod
    def layers(self, scene: Scene) -> Layers:
        """Return the layers before the first reading."""

    @abstractmethod
    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return how far each beam says anything, metres, shape (n,)."""

    @abstractmethod
    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Change the layers by what beams say of cells."""

    @abstractmethod
    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map that the layers stand for."""

    def listed(
        self, scene: Scene, beams: Beams, votes: Votes | None
    ) -> Iterator[tuple[Beams, Cells]]:
        """Return beams with the cells that they may touch; by default those of their cones."""
        return self.touched(scene, beams, self.reach_m(scene, beams), votes)

    def fuse(self, log: SonarLog, grid: GridSpec, votes: Votes | None = None) -> OccupancyMap:
        """Return the map of a log on a grid, with a remedy for repeated readings or without."""
        built = self.begin(log.ring, grid, votes)
        built.add(log)
        return built.map

    def begin(self, ring: SonarRing, grid: GridSpec, votes: Votes | None = None) -> OnePassMap:
        """Return an empty map, to which readings are added one at a time."""
        return OnePassMap(self, self.scene(ring, grid), votes)


class OnePassMap:
    """A map that grows reading by reading."""

    def __init__(self, method: OnePass, scene: Scene, votes: Votes | None) -> None:
        self._method, self._scene, self._votes = method, scene, votes
        self._layers = method.layers(scene)

    def add(self, readings: SonarLog) -> None:
        """Add readings of the ring.

        Raises
        ------
        InputError
            If they are of another ring.
        """
        ring = self._scene.ring
        if readings.ring != ring:
            raise InputError(
                f"readings must be of the ring {ring.name!r}, got {readings.ring.name!r}"
            )
        beams = beams_of(readings, self._scene.limit_m, self._method.no_echo)
        for part, cells in self._method.listed(self._scene, beams, self._votes):
            self._method.add(self._scene, self._layers, part, cells)

    @property
    def map(self) -> OccupancyMap:
        """The map so far."""
        return self._method.read(self._scene, self._layers)
