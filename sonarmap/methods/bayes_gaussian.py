"""Bayesian updating with the Gaussian sensor model of Elfes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, finite, positive
from sonarmap.methods.cones import Beams, Cells
from sonarmap.methods.onepass import ConeMethod, Layers, OnePass, Scene
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["BayesGaussian"]

# Beyond so many standard deviations behind the reading the log-odds are below 1e-5.
_REACH = 5.0


@dataclass(frozen=True, kw_only=True)
class BayesGaussian(ConeMethod, OnePass):
    """Bayes' rule with ranges and bearings that are normally distributed about the nearest target.

    Parameters
    ----------
    sigma_m : float
        Standard deviation of the range, metres, > 0.
    sigma_rad : float, optional
        Standard deviation of the bearing, > 0. By default half of the cone's half-angle.
    detection : float
        Probability that a target on the axis is heard, in (0, 1).
    density_per_m : float
        Obstacles expected on a metre of the beam beforehand, > 0.
    no_echo, max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    Elfes's model of a reading R from a target at range r and bearing a::

        p(R | r, a) = exp(-((R - r)^2 / sigma_m^2 + a^2 / sigma_rad^2) / 2)
                      / (2 pi sigma_m sigma_rad)

    is that of the *nearest* obstacle; he gets p(R | cell) by summing over all configurations of the
    cells on the beam. With cells that get ever smaller that sum has a closed form: obstacles are
    met at the rate lambda = density_per_m, and with v = (r - R) / sigma_m + lambda sigma_m::

        p(R | occupied) / p(R | empty) = Phi(v) + phi(v) / (lambda sigma_m)

    where Phi and phi are the normal distribution and its density, for readings of more than a few
    sigma_m: 0 before the reading, a peak at it, 1 behind it. A target is only heard with the
    probability w = detection exp(-a^2 / (2 sigma_rad^2)), else the reading tells nothing of it::

        ratio = 1 - w + w (Phi(v) + phi(v) / (lambda sigma_m))

    and without an echo 1 - w. Its logarithm is added to the cell. Ours are the continuous limit,
    the probability of detection in place of the angular density, and all defaults: the article
    gives no numbers.
    """

    name: ClassVar[str] = "bayes-gaussian"
    source: ClassVar[str] = (
        "Elfes, Using Occupancy Grids for Mobile Robot Perception and Navigation, IEEE Computer "
        "22(6), 1989."
    )

    sigma_m: float = 0.05
    sigma_rad: float | None = None
    detection: float = 0.9
    density_per_m: float = 0.3

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("sigma_m", self.sigma_m)
        positive("density_per_m", self.density_per_m)
        if self.sigma_rad is not None:
            positive("sigma_rad", self.sigma_rad)
        if not 0 < finite("detection", self.detection) < 1:
            raise InputError(f"detection must be in (0, 1), got {self.detection!r}")

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "sigma_m": Real(0.01, 0.15, log=True),
            "sigma_rad": Real(0.02, 0.5, log=True),
            "detection": Real(0.02, 0.98),
            "density_per_m": Real(0.05, 10.0, log=True),
        }

    def layers(self, scene: Scene) -> Layers:
        """Return log-odds of 0, and no cell seen."""
        return {"log_odds": np.zeros(scene.size), "seen": np.zeros(scene.size, bool)}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the end of the Gaussian's tail; the limit without an echo."""
        return beams.range_m + np.where(beams.echo, _REACH * self.sigma_m, 0.0)

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Add the logarithm of the ratio."""
        from sonarmap.kernels.layers import add_gaussian  # numba: loaded when mapping

        half_angle_rad = scene.half_angle_rad
        sigma_rad = half_angle_rad / 2 if self.sigma_rad is None else self.sigma_rad
        add_gaussian(
            layers["log_odds"],
            layers["seen"],
            cells.first,
            cells.cell,
            cells.range_m,
            cells.share,
            beams.range_m,
            beams.echo,
            self.sigma_m,
            sigma_rad / half_angle_rad,
            self.detection,
            self.density_per_m,
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map of the log-odds."""
        return self.from_log_odds(scene.grid, layers["log_odds"], layers["seen"])
