"""The simple cone: the first return of its sound, and mirrors beyond a critical angle.

A sonar after Wilkes, Dudek, Jenkin and Milios (SPIE 1388, 1990), cut down to what
the thesis describes: a surface met beyond its material's critical incidence angle mirrors the
sound away; the ray is traced on, and comes back along its path once it meets a surface within
its critical angle. A fan of rays stands for the cone; where the faces of the room are known, the
first return can be had exactly instead (``rays=None``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from sim.engines.protocol import RayCaster, table_of
from sim.sonar.air import Air
from sim.sonar.causes import cause_of
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.cone.exact.echo import hear_all
from sim.sonar.cone.kernel import all_measured, meet_surfaces, open_fans
from sim.sonar.protocol import Echoes
from sim.sonar.simultaneous import SimultaneousSonar
from sonarmap import InputError, LogTruth
from sonarmap.errors import non_negative, positive
from worlds import World
from worlds.facetable import FaceTable

__all__ = ["FAN_RAYS", "ConeSonar"]

FAN_RAYS = 31
"""Rays of a fan that stands for the whole cone where rays can only be cast: 31 over 30 degrees find
the foot of a perpendicular to 0.04 mm at 1 m."""


@dataclass(frozen=True)
class ConeSonar(SimultaneousSonar):
    """A ring whose sonars detect the nearest surface in their cones that sends sound back.

    Parameters
    ----------
    name, ring, scan_period_s
        See `sim.sonar.simultaneous.SimultaneousSonar`.
    rays : int, optional
        By default the whole cone counts, exactly, on an engine that knows the faces of the room
        (`sim.engines.protocol.table_of`), as "segments" does; others cast a fan of `FAN_RAYS`
        rays. Or the rays of a fan on any engine, odd (one lies on the axis) and >= 3.
    max_bounces : int
        How many mirroring surfaces a sound is traced over, >= 0; then it is lost.
    noise_std_m : float
        Standard deviation of the range noise, metres; the roughness of the surface that sends
        the echo adds to it as an independent error.
    quantum_m : float
        Readings are whole multiples of it, metres; 0 for none.
    threshold : float
        An echo is detected while the product of the reflectivities on its path is at least this.
    range_scale : float
        Readings are this many times the range, > 0: the speed of sound that the robot assumes
        over that in the air (`sim.Air`).
    """

    rays: int | None = None
    max_bounces: int = 2
    # A real AmigoBot that stood still 2 m from a target: 1000 readings, 1.0 mm.
    noise_std_m: float = 0.001
    # The robot's protocol speaks in millimetres.
    quantum_m: float = 0.001
    # Assumed: with it curtain and foam are silent and two mirrors are still detected.
    threshold: float = 0.3
    range_scale: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        non_negative("noise_std_m", self.noise_std_m)
        non_negative("quantum_m", self.quantum_m)
        non_negative("threshold", self.threshold)
        positive("range_scale", self.range_scale)
        if self.rays is not None and (self.rays < 3 or self.rays % 2 == 0):
            raise InputError(f"rays must be odd and >= 3, got {self.rays!r}")
        if self.max_bounces < 0:
            raise InputError(f"max_bounces must be >= 0, got {self.max_bounces!r}")

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire the first k sonars of the ring at once and return what they detect.

        Parameters
        ----------
        rays : RayCaster
            Where the surfaces are.
        world : World
            What they are made of.
        sensor_xy_m : ndarray, shape (k, 2)
            True places of the transducers, metres.
        axis_rad : ndarray, shape (k,)
            True directions of their axes, radians.
        rng : numpy.random.Generator
            Draws k values of noise whatever is detected.
        """
        table = table_of(rays) if self.rays is None else None
        found = (
            self._first_in_fan(rays, world, sensor_xy_m, axis_rad)
            if table is None
            else self._first_in_cone(table, world, sensor_xy_m, axis_rad)
        )
        echo_m, surface, incidence_rad, bounces, axis_range_m, cone_range_m = found
        return Echoes(
            range_m=self._measured(echo_m, surface, world.roughness_m, rng),
            axis_range_m=axis_range_m,
            cone_range_m=cone_range_m,
            cause=cause_of(echo_m, bounces, axis_range_m, cone_range_m),
            surface=surface,
            incidence_rad=incidence_rad,
            bounces=bounces,
            # A simple cone detects no other sonar and knows no level.
            source=np.where(surface < 0, LogTruth.NO_SOURCE, np.arange(surface.size)).astype(
                np.int16
            ),
            level_db=np.full(surface.size, np.nan),
        )

    def _first_in_cone(
        self,
        table: FaceTable,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> tuple[NDArray[Any], ...]:
        """Return the fields of `ExactEchoes`: the first return of each cone."""
        found: tuple[NDArray[Any], ...] = hear_all(
            tuple(table),
            0,
            sensor_xy_m,
            axis_rad,
            self.ring.half_angle_rad,
            (self.ring.range_max_m, self.max_bounces, self.threshold),
            np.cos(world.critical_incidence_rad),
            world.reflectivity,
        )
        return found

    def _first_in_fan(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
    ) -> tuple[NDArray[Any], ...]:
        """Return the fields of `ExactEchoes`: of each fan the ray whose sound is back first."""
        k, far_m = len(axis_rad), self.ring.range_max_m
        under_way = open_fans(sensor_xy_m, axis_rad, self._bearing_rad)
        echo_m = np.full(k, far_m)
        surface = np.full(k, -1, np.int32)
        incidence_rad = np.full(k, np.nan)
        bounces = np.zeros(k, np.int16)
        first = echo_m, surface, incidence_rad, bounces
        critical_cos = np.cos(world.critical_incidence_rad)
        surfaces = critical_cos, world.reflectivity, world.roughness_m
        for bounce in range(self.max_bounces + 1):
            _, origin, direction, travelled_m, _ = under_way
            hits = rays.cast(origin, direction, far_m - travelled_m)
            if bounce == 0:
                met_m = hits.distance_m.reshape(k, self._bearing_rad.size)
            met = hits.distance_m, hits.normal_xy, hits.surface
            under_way = meet_surfaces(under_way, *met, surfaces, self.threshold, bounce, first)
            if under_way[0].size == 0:
                break
        echo_m[surface < 0] = np.inf
        axis_range_m, cone_range_m = met_m[:, met_m.shape[1] // 2], met_m.min(axis=1)
        return *first, axis_range_m, cone_range_m

    def randomised(self, noise_factor: float, air: Air) -> Self:
        """Return it with its noise multiplied, in other air, see `sim.sonar.protocol.Sonar`."""
        scale = self.range_scale * Air().speed_mps / air.speed_mps
        return self.replace(noise_std_m=noise_factor * self.noise_std_m, range_scale=scale)

    def compiled(self) -> CompiledCone:
        """Return it as a simple cone, see `sim.sonar.protocol.Sonar`."""
        return CompiledCone(
            rays=self.rays,
            max_bounces=self.max_bounces,
            threshold=self.threshold,
            noise_std_m=self.noise_std_m,
            scale=self.range_scale,
            quantum_m=self.quantum_m,
            silent_m=math.inf,
        )

    @cached_property
    def _bearing_rad(self) -> NDArray[np.float64]:
        half_rad, rays = self.ring.half_angle_rad, FAN_RAYS if self.rays is None else self.rays
        return np.linspace(-half_rad, half_rad, rays)

    def _measured(
        self,
        echo_m: NDArray[np.float64],
        surface: NDArray[np.int32],
        roughness_m: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> NDArray[np.float64]:
        readings_m: NDArray[np.float64] = all_measured(
            echo_m,
            surface,
            roughness_m,
            rng.normal(size=echo_m.size),
            self.noise_std_m,
            self.range_scale,
            self.quantum_m,
            self.ring.range_min_m,
            self.ring.range_max_m,
        )
        return readings_m
