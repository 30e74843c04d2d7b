"""The simple cone: a fan of rays, the first return, and mirrors beyond a critical angle.

A ray-following sonar after Wilkes, Dudek, Jenkin and Milios (SPIE 1388, 1990), cut down to what
the thesis describes: a surface met beyond its material's critical incidence angle mirrors the
sound away; the ray is followed, and comes back the way it went once it meets a surface within
its critical angle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sim.acoustics import Echoes, cause_of
from sim.engine import RayCaster
from sonarmap import AMIGOBOT, InputError, SonarRing, ring
from sonarmap.errors import did_you_mean, non_negative, positive
from worlds import World

__all__ = ["PRESETS", "ConeSonar", "preset"]

# A mirrored ray begins this far off the surface, so that it does not meet it again; metres.
_OFF_SURFACE_M = 1e-6


@dataclass(frozen=True)
class ConeSonar:
    """A ring whose sonars hear the nearest surface in a fan of rays that sends sound back.

    Parameters
    ----------
    name : str
        Name of the preset.
    ring : SonarRing
        Places, cone width, nearest and farthest range.
    scan_period_s : float
        All sonars are read at once, this often; a multiple of 5 ms.
    rays : int
        Rays of a fan, odd (one lies on the axis), >= 3. 31 over 30 degrees find the foot of a
        perpendicular to 0.04 mm at 1 m.
    max_bounces : int
        How many mirroring surfaces a sound is followed over, >= 0; then it is lost.
    noise_std_m : float
        Standard deviation of the range noise, metres.
    quantum_m : float
        Readings are whole multiples of it, metres; 0 for none.
    threshold : float
        An echo is heard while the product of the reflectivities on its way is at least this.
    """

    name: str
    ring: SonarRing
    scan_period_s: float
    rays: int = 31
    max_bounces: int = 2
    # A real AmigoBot that stood still 2 m from a target: 1000 readings, 1.0 mm.
    noise_std_m: float = 0.001
    # The robot's protocol speaks in millimetres.
    quantum_m: float = 0.001
    # Assumed: with it curtain and foam are silent and two mirrors are still heard.
    threshold: float = 0.3

    def __post_init__(self) -> None:
        positive("scan_period_s", self.scan_period_s)
        non_negative("noise_std_m", self.noise_std_m)
        non_negative("quantum_m", self.quantum_m)
        non_negative("threshold", self.threshold)
        if self.rays < 3 or self.rays % 2 == 0:
            raise InputError(f"rays must be odd and >= 3, got {self.rays!r}")
        if self.max_bounces < 0:
            raise InputError(f"max_bounces must be >= 0, got {self.max_bounces!r}")

    def replace(self, **changes: object) -> ConeSonar:
        """Return this sonar with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]

    def listen(
        self,
        rays: RayCaster,
        world: World,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        rng: np.random.Generator,
    ) -> Echoes:
        """Fire k sonars at once and return what they hear, see `sim.acoustics.Sonar`."""
        half = self.ring.half_angle_rad
        angle = (axis_rad[:, None] + np.linspace(-half, half, self.rays)).ravel()
        paths = self._follow(
            rays,
            world,
            np.repeat(sensor_xy_m, self.rays, axis=0),
            np.column_stack([np.cos(angle), np.sin(angle)]),
        )

        # First return: of each fan the ray whose sound is back first.
        first = paths.echo_m.reshape(-1, self.rays).argmin(axis=1)
        chosen = np.arange(first.size) * self.rays + first
        met_m = paths.met_m.reshape(-1, self.rays)
        axis_range_m, cone_range_m = met_m[:, self.rays // 2], met_m.min(axis=1)
        heard_m, bounces = paths.echo_m[chosen], paths.bounces[chosen]
        return Echoes(
            range_m=self._measured(heard_m, rng),
            axis_range_m=axis_range_m,
            cone_range_m=cone_range_m,
            cause=cause_of(heard_m, bounces, axis_range_m, cone_range_m),
            surface=paths.surface[chosen],
            incidence_rad=paths.incidence_rad[chosen],
            bounces=bounces,
        )

    def _follow(
        self,
        rays: RayCaster,
        world: World,
        origin: NDArray[np.float64],
        direction: NDArray[np.float64],
    ) -> _Paths:
        """Follow n rays until each has come back, is lost, or has bounced often enough."""
        critical_rad = np.array([solid.material.critical_incidence_rad for solid in world.solids])
        reflectivity = np.array([solid.material.reflectivity for solid in world.solids])
        paths = _Paths.silent(len(origin))
        # What is still under way: its row in `paths`, the range so far, its strength.
        row = np.arange(len(origin))
        travelled_m, strength = np.zeros(len(origin)), np.ones(len(origin))
        for bounce in range(self.max_bounces + 1):
            hits = rays.cast(origin, direction, self.ring.range_max_m - travelled_m)
            if bounce == 0:
                paths.met_m[:] = hits.distance_m
            met = np.flatnonzero(hits.surface >= 0)
            row, surface, normal = row[met], hits.surface[met], hits.normal_xy[met]
            origin, direction = origin[met], direction[met]
            leg_m = hits.distance_m[met]
            travelled_m = travelled_m[met] + leg_m
            strength = strength[met] * reflectivity[surface]
            cos = -(direction * normal).sum(axis=1)
            incidence_rad = np.arccos(np.clip(cos, -1, 1))

            loud = strength >= self.threshold
            returns = loud & (incidence_rad <= critical_rad[surface])
            back = row[returns]
            paths.echo_m[back] = travelled_m[returns]
            paths.surface[back] = surface[returns]
            paths.incidence_rad[back] = incidence_rad[returns]
            paths.bounces[back] = bounce

            # The rest is mirrored on; a leg shorter than the step off the surface is none.
            on = np.flatnonzero(
                loud & ~returns & (travelled_m < self.ring.range_max_m - _OFF_SURFACE_M)
            )
            if on.size == 0:
                break
            row, travelled_m, strength = row[on], travelled_m[on], strength[on]
            origin = origin[on] + leg_m[on, None] * direction[on] + _OFF_SURFACE_M * normal[on]
            direction = direction[on] + 2 * cos[on, None] * normal[on]
        return paths

    def _measured(
        self, heard_m: NDArray[np.float64], rng: np.random.Generator
    ) -> NDArray[np.float64]:
        noise_m = rng.normal(0.0, 1.0, heard_m.size) * self.noise_std_m
        reading = heard_m + noise_m
        if self.quantum_m > 0:
            reading = np.round(reading / self.quantum_m) * self.quantum_m
        # Noise alone must not turn an echo at the very end of the range into silence.
        reading = np.where(np.isfinite(heard_m), np.minimum(reading, self.ring.range_max_m), np.inf)
        return np.where(reading < self.ring.range_min_m, -np.inf, reading)


@dataclass(frozen=True, eq=False)
class _Paths:
    """What became of n rays."""

    met_m: NDArray[np.float64]
    """Distance of the first surface, +inf for none."""
    echo_m: NDArray[np.float64]
    """Range that the returning sound says, +inf if none returns."""
    surface: NDArray[np.int32]
    """The surface that sent it back, -1 for none."""
    incidence_rad: NDArray[np.float64]
    bounces: NDArray[np.int16]

    @classmethod
    def silent(cls, n: int) -> _Paths:
        """Return n paths that met nothing; the arrays are then filled in."""
        return cls(
            met_m=np.full(n, np.inf),
            echo_m=np.full(n, np.inf),
            surface=np.full(n, -1, np.int32),
            incidence_rad=np.full(n, np.nan),
            bounces=np.zeros(n, np.int16),
        )


# `thesis`: 175 ms, Rashid 2006 p. 59; 0.165 to 3.0 m, p. 56. `aria`: a status packet every 100 ms.
PRESETS: Mapping[str, ConeSonar] = MappingProxyType(
    {
        sonar.name: sonar
        for sonar in (
            ConeSonar("thesis", AMIGOBOT, scan_period_s=0.175),
            ConeSonar("aria", ring("amigobot-aria"), scan_period_s=0.100),
        )
    }
)


def preset(name: str) -> ConeSonar:
    """Return the preset called `name`, or raise `InputError` with the nearest known name."""
    try:
        return PRESETS[name]
    except KeyError:
        raise InputError(f"sonar {name!r} is unknown{did_you_mean(name, PRESETS)}") from None
