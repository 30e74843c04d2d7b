"""Bayesian updating: the log-odds of readings, added cell by cell (Rashid 2006, section 4.4).

A cell is updated by a reading when its centre lies within the model's half-angle of the acoustic
axis and within its reach of the sonar. Probabilities are clipped to [1e-6, 1 - 1e-6] and added as
log-odds: equation 4.14, whose printed denominator has an index slip (both of its factors belong to
reading n). Without a limit on the sum the order of the readings does not matter.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple, Self, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, one_of, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.bayes.models import Regions, SensorModel
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Space
from sonarmap.rings import SonarRing

__all__ = [
    "Bayes",
    "BayesMap",
    "BayesUpdating",
    "Evidence",
    "NoEcho",
    "evidence_of",
    "reading_limit_m",
]

NoEcho = Literal["ignore", "clear"]


@dataclass(frozen=True, kw_only=True)
class BayesUpdating(ABC):
    """What all methods of Bayesian updating have in common.

    Parameters
    ----------
    no_echo : {"ignore", "clear"}
        What no echo means: nothing, or that the cone is free up to the longest reading used (less
        the model's tolerance).
    max_range_m : float, optional
        Readings above it are taken as no echo, metres, > 0. By default the ring's maximum range,
        or the model's if that is less.
    log_odds_limit : float
        Bound on the absolute log-odds of a cell, > 0. Off by default; with it the order of the
        readings matters.
    """

    name: ClassVar[str]
    source: ClassVar[str]

    no_echo: NoEcho = "ignore"
    max_range_m: float | None = None
    log_odds_limit: float = math.inf

    def __post_init__(self) -> None:
        one_of("no_echo", self.no_echo, get_args(NoEcho))
        if self.max_range_m is not None:
            positive("max_range_m", self.max_range_m)
        if not self.log_odds_limit > 0:
            raise InputError(f"log_odds_limit must be > 0, got {self.log_odds_limit!r}")

    @abstractmethod
    def sensor_model(self, ring: SonarRing) -> SensorModel:
        """Return the sensor model for a ring."""

    @classmethod
    @abstractmethod
    def space(cls) -> Space:
        """Return what may be searched."""

    def replace(self, **changes: Any) -> Self:
        """Return the method with some parameters replaced."""
        return dataclasses.replace(self, **changes)

    def longest_reading_m(self, ring: SonarRing) -> float:
        """Return the range above which a reading is taken as no echo, metres."""
        return reading_limit_m(ring, self.sensor_model(ring), self.max_range_m)

    def uses(self, log: SonarLog) -> NDArray[np.bool_]:
        """Return which readings of a log say anything, shape (n,)."""
        return _says_something(log, self.longest_reading_m(log.ring), self.no_echo)[0]

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid."""
        built = self.begin(log.ring, grid)
        built.add(log)
        return built.map

    def begin(self, ring: SonarRing, grid: GridSpec) -> BayesMap:
        """Return an empty map, to which readings are added one at a time."""
        return BayesMap(self, ring, grid)

    def compiled_evidence(self, ring: SonarRing) -> Evidence | None:
        """Return what it adds for a reading, for compiled code that maps many robots at once.

        None if it does anything else than to add the log-odds of the regions of readings.
        """
        if self.no_echo != "ignore" or math.isfinite(self.log_odds_limit):
            return None
        return Evidence(self.sensor_model(ring), self.longest_reading_m(ring))


@dataclass(frozen=True)
class Bayes(BayesUpdating):
    """Bayesian updating with a sensor model that is at hand.

    Parameters
    ----------
    model : SensorModel
        What a reading says of the cells in its cone.
    no_echo, max_range_m, log_odds_limit
        See `BayesUpdating`.
    """

    name: ClassVar[str] = "bayes"
    source: ClassVar[str] = "Rashid 2006, section 4.4, with a sensor model of one's own"

    model: SensorModel

    def sensor_model(self, ring: SonarRing) -> SensorModel:
        """Return the model, whatever the ring."""
        return self.model

    @classmethod
    def space(cls) -> Space:
        """Return nothing: the model is given."""
        return {}


class Evidence(NamedTuple):
    """What readings say: the regions of a sensor model, up to a longest reading in metres."""

    model: SensorModel
    limit_m: float


class BayesMap:
    """A map that Bayesian updating grows reading by reading."""

    def __init__(self, method: BayesUpdating, ring: SonarRing, grid: GridSpec) -> None:
        self._method, self._ring, self._grid = method, ring, grid
        self._model = method.sensor_model(ring)
        self._limit_m = reading_limit_m(ring, self._model, method.max_range_m)
        self._log_odds = np.zeros(grid.shape)

    def add(self, readings: SonarLog) -> None:
        """Add the evidence of readings of the ring.

        Raises
        ------
        InputError
            If they are of another ring.
        """
        if readings.ring != self._ring:
            raise InputError(
                f"readings must be of the ring {self._ring.name!r}, got {readings.ring.name!r}"
            )
        used, regions = evidence_of(readings, self._model, self._limit_m, self._method.no_echo)
        from sonarmap.kernels import fusion  # numba: loaded when mapping

        half_angle_rad = self._model.half_angle_rad
        fusion.add_readings(
            self._log_odds,
            fusion.GridCells(*self._grid.shape, *self._grid.origin_xy_m, self._grid.resolution_m),
            fusion.Sensors(readings.sensor_xy_m[used], readings.axis_rad[used]),
            fusion.Cone(half_angle_rad, fusion.bearing_polynomial(half_angle_rad)),
            fusion.RegionArrays(regions.border_m, regions.axis, regions.edge),
            self._method.log_odds_limit,
        )

    @property
    def map(self) -> OccupancyMap:
        """The map so far."""
        return OccupancyMap(self._grid, self._log_odds)


def reading_limit_m(ring: SonarRing, model: SensorModel, max_range_m: float | None) -> float:
    """Return the range above which a reading is taken as no echo, metres."""
    limit_m = ring.range_max_m if max_range_m is None else positive("max_range_m", max_range_m)
    return min(limit_m, model.range_limit_m)


def evidence_of(
    log: SonarLog, model: SensorModel, limit_m: float, no_echo: NoEcho
) -> tuple[NDArray[np.bool_], Regions]:
    """Return which readings say something (a mask), and the regions of those.

    Readings above `limit_m` are taken as no echo; stale, rejected and too close ones say nothing.
    """
    used, echo = _says_something(log, limit_m, no_echo)
    if no_echo == "ignore":
        return used, model.regions(log.range_m[used])
    regions = model.free_regions(np.full(int(used.sum()), limit_m))
    heard = echo[used]
    measured = model.regions(log.range_m[echo])
    regions.border_m[heard] = measured.border_m
    regions.axis[heard] = measured.axis
    regions.edge[heard] = measured.edge
    return used, regions


def _says_something(
    log: SonarLog, limit_m: float, no_echo: NoEcho
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which readings say something, and which of them by an echo."""
    known = log.usable & (log.range_m >= 0)
    echo = known & (log.range_m <= limit_m)
    return (echo if no_echo == "ignore" else known), echo
