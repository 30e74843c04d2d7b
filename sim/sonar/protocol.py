"""What an acoustic model answers, and how a reading's cause follows from the truth."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Protocol, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.firing import AllAtOnce, Firing
from sonarmap import Cause, SonarRing
from sonarmap.errors import positive
from worlds import World

__all__ = ["SAME_POINT_M", "Ears", "Echoes", "Sonar", "SonarTogether", "cause_of"]

SAME_POINT_M = 0.06
"""Ranges that differ by less denote the same point: Rashid 2006, p. 55 (TDTh, between the axis
and the edge of the cone at 2 m)."""


# What compiled code knows of the causes.
_DIRECT, _OFF_AXIS, _OUT_OF_RANGE, _BOUNCE, _DROPOUT = (
    int(cause)
    for cause in (
        Cause.DIRECT,
        Cause.OFF_AXIS,
        Cause.OUT_OF_RANGE,
        Cause.BOUNCE,
        Cause.DROPOUT,
    )
)


@dataclass(frozen=True, eq=False)
class Echoes:
    """What k sonars heard, each array of shape (k,); see `sonarmap.LogTruth` for the meaning.

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


class Ears(Protocol):
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

    def hear(self) -> Echoes:
        """Return what was heard, one entry for each firing of a sonar since the last call."""


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

    def ears(self, rays: RayCaster, world: World, rng: np.random.Generator) -> Ears:
        """Return the sonars of one drive.

        Parameters
        ----------
        rays : RayCaster
            Where the surfaces are.
        world : World
            What they are made of; a surface index is an index of its solids.
        rng : numpy.random.Generator
            The only source of noise; draws the same number of values whatever is heard.
        """

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k transducers that do not hear each other and return what they hear.

        Parameters
        ----------
        rays, world, rng
            As for `ears`.
        sensor_xy_m : ndarray, shape (k, 2)
            True places of the transducers, metres.
        axis_rad : ndarray, shape (k,)
            True directions of their axes, radians.
        """


@dataclass(frozen=True)
class SonarTogether(ABC):
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

    def ears(self, rays: RayCaster, world: World, rng: np.random.Generator) -> Ears:
        """Return the sonars of one drive, see `Sonar`."""
        return _EarsTogether(self, rays, world, rng)

    @abstractmethod
    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k transducers and return what they hear, see `Sonar`."""


class _EarsTogether:
    """The `Ears` of sonars that fire all together and remember nothing."""

    def __init__(
        self, sonar: Sonar, rays: RayCaster, world: World, rng: np.random.Generator
    ) -> None:
        self._sonar, self._rays, self._world, self._rng = sonar, rays, world, rng

    def fire(
        self,
        time_s: float,
        sonars: tuple[int, ...],
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> None:
        """Let all sonars fire."""
        self._heard = self._sonar.listen(self._rays, self._world, sensor_xy_m, axis_rad, self._rng)

    def hear(self) -> Echoes:
        """Return what they heard."""
        return self._heard


@njit(cache=True)  # a scan has a few readings: numpy's own calls would cost more than they do
def cause_of(
    heard_m: NDArray[np.float64],
    bounces: NDArray[np.int16],
    axis_range_m: NDArray[np.float64],
    cone_range_m: NDArray[np.float64],
) -> NDArray[np.int8]:
    """Return the `Cause` of readings that come from a sonar's own sound.

    Parameters
    ----------
    heard_m : ndarray
        Range of the echo before noise, metres; +inf for none.
    bounces : ndarray of int
        Mirroring surfaces on its way.
    axis_range_m, cone_range_m : ndarray
        True ranges on the axis and of the nearest surface in the cone; +inf beyond the maximum.

    Notes
    -----
    A straight echo is right when it comes from no farther than the axis truly reaches: DIRECT
    within `SAME_POINT_M` of it, OFF_AXIS nearer. A straight echo from farther says that what
    stands on the axis was not heard, so it is a DROPOUT, as is silence with something in range.
    """
    cause = np.empty(heard_m.size, np.int8)
    for i in range(heard_m.size):
        if math.isinf(heard_m[i]):
            cause[i] = _OUT_OF_RANGE if math.isinf(cone_range_m[i]) else _DROPOUT
        elif bounces[i] > 0:
            cause[i] = _BOUNCE
        elif heard_m[i] > axis_range_m[i] + SAME_POINT_M:
            cause[i] = _DROPOUT
        elif heard_m[i] >= axis_range_m[i] - SAME_POINT_M:
            cause[i] = _DIRECT
        else:
            cause[i] = _OFF_AXIS
    return cause
