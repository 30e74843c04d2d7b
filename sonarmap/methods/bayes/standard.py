"""Bayesian updating with the standard sensor model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from sonarmap.methods.bayes.models import THESIS_UNIT_M, StandardModel
from sonarmap.methods.bayes.updating import BayesUpdating
from sonarmap.parameters import Real, Space
from sonarmap.rings import AMIGOBOT, SonarRing

__all__ = ["BayesStandard"]


@dataclass(frozen=True)
class BayesStandard(BayesUpdating):
    """Bayesian updating with `StandardModel`; the defaults are the thesis's (figure 5.8 a).

    Parameters
    ----------
    beta_rad : float, optional
        Half-angle of the cone, in (0, pi/3]. By default the ring's.
    max_occupied : float
        No cell is ever believed to be occupied with more than this, in (0.5, 1].
    tolerance_m : float
        Half of the thickness of region 1, metres, > 0.
    max_range_m : float, optional
        R, the longest range that the sonar can sense; longer readings are taken as no echo. By
        default the ring's maximum range.
    no_echo, log_odds_limit
        See `BayesUpdating`.
    """

    name: ClassVar[str] = "bayes-standard"
    source: ClassVar[str] = (
        "Rashid 2006, equations 4.9 to 4.14, after Murphy, Introduction to AI Robotics, 2000, "
        "chapter 11."
    )

    beta_rad: float | None = None
    max_occupied: float = 0.98
    tolerance_m: float = THESIS_UNIT_M

    def __post_init__(self) -> None:
        super().__post_init__()
        self.sensor_model(AMIGOBOT)  # its rules are the parameters'

    def sensor_model(self, ring: SonarRing) -> StandardModel:
        """Return the sensor model for a ring."""
        return StandardModel(
            ring.half_angle_rad if self.beta_rad is None else self.beta_rad,
            ring.range_max_m if self.max_range_m is None else self.max_range_m,
            self.max_occupied,
            self.tolerance_m,
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            # From 25 mm: a region thinner than a cell of 5 cm falls between the centres of cells.
            "tolerance_m": Real(0.025, 0.15),
            "max_occupied": Real(0.51, 0.99),
            "beta_rad": Real(math.radians(3), math.radians(40)),
        }
