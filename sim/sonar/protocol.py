"""What a sonar is: a ring with its acoustics and its timing, and the array of one drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.air import Air
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.firing import Firing
from sim.sonar.physical.images.setup import CompiledImages
from sonarmap import SonarRing
from worlds import World

__all__ = ["Echoes", "Sonar", "SonarArray", "from_sonars", "joined"]


@dataclass(frozen=True, eq=False)
class Echoes:
    """What k sonars measured, each array of shape (k,); see `sonarmap.LogTruth` for the meaning.

    ``surface`` is an index of the world's solids, -1 for none.
    """

    range_m: NDArray[np.float64]
    axis_range_m: NDArray[np.float64]
    cone_range_m: NDArray[np.float64]
    cause: NDArray[np.int8]
    surface: NDArray[np.int32]
    incidence_rad: NDArray[np.float64]
    bounces: NDArray[np.int16]
    source: NDArray[np.int16]
    level_db: NDArray[np.float64]


def joined(echoes: Sequence[Echoes]) -> Echoes:
    """Return what was measured in several firings as one, in their order."""
    if len(echoes) == 1:
        return echoes[0]
    return Echoes(
        **{
            field.name: np.concatenate([getattr(each, field.name) for each in echoes])
            for field in fields(Echoes)
        }
    )


def from_sonars(echoes: Echoes, sonars: Sequence[int]) -> Echoes:
    """Return the echoes of some sonars of a ring with sources that are numbers of the ring.

    What `Sonar.listen` returns counts the transducers that it was given from 0.
    """
    own = np.where(echoes.source >= 0, np.asarray(sonars)[echoes.source], echoes.source)
    return replace(echoes, source=own.astype(np.int16))


class SonarArray(Protocol):
    """The sonars of one drive, which may remember sounds that are still under way."""

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let some sonars fire at once.

        Parameters
        ----------
        time_s : float
            Time of the firing, not before that of the last one.
        sonars : tuple of int
            Which sonars of the ring fire.
        sensor_xy_m : ndarray, shape (sonars of the ring, 2)
            True places of all transducers, metres.
        axis_rad : ndarray, shape (sonars of the ring,)
            True directions of all axes, radians.
        """

    def detect(self) -> Echoes:
        """Return what was detected, one entry for each firing of a sonar since the last call."""


class Sonar(Protocol):
    """A ring of sonars with its acoustics and its timing."""

    @property
    def name(self) -> str:
        """Name of the preset."""

    @property
    def ring(self) -> SonarRing:
        """The ring that it reads."""

    @property
    def firing(self) -> Firing:
        """When its sonars fire."""

    def array(self, rays: RayCaster, world: World, rng: np.random.Generator) -> SonarArray:
        """Return the sonars of one drive.

        Parameters
        ----------
        rays : RayCaster
            Where the surfaces are.
        world : World
            What they are made of; a surface index is an index of its solids.
        rng : numpy.random.Generator
            The only source of noise; draws the same number of values whatever is detected.
        """

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k transducers without cross-talk between them and return what they detect.

        Parameters
        ----------
        rays, world, rng
            As for `array`.
        sensor_xy_m : ndarray, shape (k, 2)
            True places of the transducers, metres.
        axis_rad : ndarray, shape (k,)
            True directions of their axes, radians.
        """

    def randomised(self, noise_factor: float, air: Air) -> Sonar:
        """Return this sonar with its noise multiplied, in other air than the robot assumes.

        Raises
        ------
        InputError
            If it has neither noise nor air.
        """

    def compiled(self) -> CompiledCone | CompiledImages | None:
        """Return it as numbers for compiled code that runs whole drives; None if it cannot be.

        A simple cone whose ring fires all at once, which many robots of environments fire in one
        call as well, or a physical sonar that listens by images.
        """
