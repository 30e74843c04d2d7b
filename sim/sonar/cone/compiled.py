"""`CompiledCone`: a simple cone as numbers, for compiled code that fires many robots' rings."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["CompiledCone"]


@dataclass(frozen=True, slots=True)
class CompiledCone:
    """A sonar whose ring fires all at once and takes the first return.

    Parameters
    ----------
    rays : int or None
        Rays of a fan, evenly spread over the ring's cone; None for the whole cone.
    max_bounces : int
        How many mirroring surfaces a sound is traced over.
    threshold : float
        An echo is detected while the product of the reflectivities on its path is at least this.
    noise_std_m, scale, quantum_m, silent_m : float
        See `sim.sonar.cone.kernel.measured`.
    critical_rad : float or None
        Critical angle of incidence of every surface; None for that of its material.
    roughness_factor : float
        What the roughness of surfaces is multiplied with.
    """

    rays: int | None
    max_bounces: int
    threshold: float
    noise_std_m: float
    scale: float
    quantum_m: float
    silent_m: float
    critical_rad: float | None = None
    roughness_factor: float = 1.0
