"""`CompiledCone`: a simple cone as numbers, for compiled code that fires many robots' rings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from worlds import World

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

    def materials(
        self, world: World
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return what a world is made of for it.

        Returns
        -------
        critical_cos, reflectivity, roughness_m : ndarray, shape (surfaces,)
            Cosine of the critical angle, share of the amplitude that comes back, roughness.
        """
        critical_rad = world.critical_incidence_rad
        if self.critical_rad is not None:
            critical_rad = np.full_like(critical_rad, self.critical_rad)
        return np.cos(critical_rad), world.reflectivity, self.roughness_factor * world.roughness_m
