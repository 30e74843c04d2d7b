"""The sonar of Webots, to compare with: the nearest ray that meets its surface steeply enough."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sim.acoustics import Ears, EarsTogether, Echoes, cause_of
from sim.engine import RayCaster
from sim.firing import AllAtOnce
from sonarmap import InputError, LogTruth, SonarRing
from sonarmap.errors import positive
from worlds import World

__all__ = ["WEBOTS_CRITICAL_RAD", "WebotsSonar"]

WEBOTS_CRITICAL_RAD = math.radians(22.5)
"""The same for every surface: cyberbotics/webots, src/webots/nodes/WbDistanceSensor.cpp."""


@dataclass(frozen=True)
class WebotsSonar:
    """A ring whose sonars read the nearest of a few rays under 22.5 degrees, without noise.

    Parameters
    ----------
    name : str
        Name of the preset.
    ring : SonarRing
        Places, cone width, nearest and farthest range.
    scan_period_s : float
        All sonars are read at once, this often, seconds, > 0.
    rays : int
        Rays of a fan, odd, so that one lies on the axis.
    """

    name: str
    ring: SonarRing
    scan_period_s: float
    # Webots draws its cones with up to ten rays.
    rays: int = 9

    def __post_init__(self) -> None:
        positive("scan_period_s", self.scan_period_s)
        if self.rays < 1 or self.rays % 2 == 0:
            raise InputError(f"rays must be odd and >= 1, got {self.rays!r}")

    def replace(self, **changes: object) -> WebotsSonar:
        """Return this sonar with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]

    @property
    def firing(self) -> AllAtOnce:
        """All sonars at once."""
        return AllAtOnce(self.scan_period_s)

    def ears(self, rays: RayCaster, world: World, rng: np.random.Generator) -> Ears:
        """Return the sonars of one drive, see `sim.acoustics.Sonar`."""
        return EarsTogether(self, rays, world, rng)

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire all sonars and return what they hear: the maximum range where there is no echo."""
        k, ring = len(axis_rad), self.ring
        bearing = np.linspace(-ring.half_angle_rad, ring.half_angle_rad, self.rays)
        angle = (axis_rad[:, None] + (bearing if self.rays > 1 else 0.0)).ravel()
        direction = np.column_stack([np.cos(angle), np.sin(angle)])
        origin = np.repeat(sensor_xy_m, self.rays, axis=0)
        hits = rays.cast(origin, direction, np.full(angle.size, ring.range_max_m))
        cos = np.clip(-(hits.normal_xy * direction).sum(axis=1), -1, 1)
        incidence = np.arccos(cos).reshape(k, -1)
        met_m = hits.distance_m.reshape(k, -1)
        heard = np.where(incidence <= WEBOTS_CRITICAL_RAD, met_m, np.inf)
        best = np.arange(k), heard.argmin(axis=1)
        heard_m = heard[best]
        silent = np.isinf(heard_m)
        axis_range_m, cone_range_m = met_m[:, self.rays // 2], met_m.min(axis=1)
        bounces = np.zeros(k, np.int16)
        reading = np.where(silent, ring.range_max_m, heard_m)
        return Echoes(
            range_m=np.where(reading < ring.range_min_m, -np.inf, reading),
            axis_range_m=axis_range_m,
            cone_range_m=cone_range_m,
            cause=cause_of(heard_m, bounces, axis_range_m, cone_range_m),
            surface=np.where(silent, -1, hits.surface.reshape(k, -1)[best]).astype(np.int32),
            incidence_rad=np.where(silent, np.nan, incidence[best]),
            bounces=bounces,
            source=np.where(silent, LogTruth.NO_SOURCE, np.arange(k)).astype(np.int16),
            level_db=np.full(k, np.nan),
        )
