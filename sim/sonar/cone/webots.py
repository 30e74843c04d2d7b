"""The sonar of Webots, to compare with: the nearest ray that meets its surface steeply enough."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster
from sim.sonar.causes import cause_of
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.protocol import Echoes
from sim.sonar.simultaneous import SimultaneousSonar
from sonarmap import InputError, LogTruth
from worlds import World

__all__ = ["WEBOTS_CRITICAL_RAD", "WebotsSonar"]

WEBOTS_CRITICAL_RAD = math.radians(22.5)
"""The same for every surface: cyberbotics/webots, src/webots/nodes/WbDistanceSensor.cpp."""


@dataclass(frozen=True)
class WebotsSonar(SimultaneousSonar):
    """A ring whose sonars read the nearest of a few rays under 22.5 degrees, without noise.

    Parameters
    ----------
    name, ring, scan_period_s
        See `sim.sonar.simultaneous.SimultaneousSonar`.
    rays : int
        Rays of a fan, odd, so that one lies on the axis.
    """

    # Webots draws its cones with up to ten rays.
    rays: int = 9

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rays < 1 or self.rays % 2 == 0:
            raise InputError(f"rays must be odd and >= 1, got {self.rays!r}")

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire all sonars and return what they detect: the maximum range where there is no echo."""
        k, ring = len(axis_rad), self.ring
        bearing = np.linspace(-ring.half_angle_rad, ring.half_angle_rad, self.rays)
        angle = (axis_rad[:, None] + (bearing if self.rays > 1 else 0.0)).ravel()
        direction = np.column_stack([np.cos(angle), np.sin(angle)])
        origin = np.repeat(sensor_xy_m, self.rays, axis=0)
        hits = rays.cast(origin, direction, np.full(angle.size, ring.range_max_m))
        cos = np.clip(-(hits.normal_xy * direction).sum(axis=1), -1, 1)
        incidence = np.arccos(cos).reshape(k, -1)
        met_m = hits.distance_m.reshape(k, -1)
        answers_m = np.where(incidence <= WEBOTS_CRITICAL_RAD, met_m, np.inf)
        best = np.arange(k), answers_m.argmin(axis=1)
        echo_m = answers_m[best]
        silent = np.isinf(echo_m)
        axis_range_m, cone_range_m = met_m[:, self.rays // 2], met_m.min(axis=1)
        bounces = np.zeros(k, np.int16)
        reading = np.where(silent, ring.range_max_m, echo_m)
        return Echoes(
            range_m=np.where(reading < ring.range_min_m, -np.inf, reading),
            axis_range_m=axis_range_m,
            cone_range_m=cone_range_m,
            cause=cause_of(echo_m, bounces, axis_range_m, cone_range_m),
            surface=np.where(silent, -1, hits.surface.reshape(k, -1)[best]).astype(np.int32),
            incidence_rad=np.where(silent, np.nan, incidence[best]),
            bounces=bounces,
            source=np.where(silent, LogTruth.NO_SOURCE, np.arange(k)).astype(np.int16),
            level_db=np.full(k, np.nan),
        )

    def compiled(self) -> CompiledCone:
        """Return it as a simple cone, see `sim.sonar.protocol.Sonar`."""
        return CompiledCone(
            rays=self.rays,
            max_bounces=0,
            threshold=0.0,
            noise_std_m=0.0,
            scale=1.0,
            quantum_m=0.0,
            silent_m=self.ring.range_max_m,
            critical_rad=WEBOTS_CRITICAL_RAD,
            roughness_factor=0.0,
        )
