"""What sonars share that fire all together and remember nothing."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.air import Air
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.firing import AllAtOnce
from sim.sonar.protocol import Echoes, Sonar, SonarArray, from_sonars, joined
from sonarmap import InputError, SonarRing
from sonarmap.errors import positive
from worlds import World

__all__ = ["SimultaneousSonar"]


@dataclass(frozen=True)
class SimultaneousSonar(ABC):
    """What sonars have in common that fire all together and remember nothing.

    Parameters
    ----------
    name : str
        Name of the preset.
    ring : SonarRing
        Places, cone width, nearest and farthest range.
    scan_period_s : float
        All sonars are read at once, this often, seconds, > 0; a multiple of 5 ms.
    """

    name: str
    ring: SonarRing
    scan_period_s: float

    def __post_init__(self) -> None:
        positive("scan_period_s", self.scan_period_s)

    def replace(self, **changes: object) -> Self:
        """Return this sonar with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]

    @property
    def firing(self) -> AllAtOnce:
        """All sonars at once."""
        return AllAtOnce(self.scan_period_s)

    def array(self, rays: RayCaster, world: World, rng: np.random.Generator) -> SonarArray:
        """Return the sonars of one drive, see `Sonar`."""
        return _SimultaneousArray(self, rays, world, rng)

    def randomised(self, noise_factor: float, air: Air) -> Self:
        """Refuse: there is neither noise nor air; overridden where there is."""
        raise InputError(f"sonar {self.name!r} has neither noise nor air to randomise")

    def compiled(self) -> CompiledCone | None:
        """Return None: no simple cone, see `Sonar`; overridden where it is one."""
        return None

    @abstractmethod
    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k transducers and return what they detect, see `Sonar`."""


class _SimultaneousArray:
    """The array of sonars that remember nothing: each firing is over before the next."""

    def __init__(
        self, sonar: Sonar, rays: RayCaster, world: World, rng: np.random.Generator
    ) -> None:
        self._sonar, self._rays, self._world, self._rng = sonar, rays, world, rng
        self._detected: list[Echoes] = []

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let some sonars fire at once, see `SonarArray`."""
        fired = list(sonars)
        echoes = self._sonar.listen(
            self._rays, self._world, sensor_xy_m[fired], axis_rad[fired], self._rng
        )
        self._detected.append(from_sonars(echoes, sonars))

    def detect(self) -> Echoes:
        """Return what was detected since the last call, see `SonarArray`."""
        detected, self._detected = self._detected, []
        return joined(detected)
