"""Bayesian updating with the parameterized sensor model of the thesis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sonarmap.methods.bayes.models import THESIS_UNIT_M, ParameterizedModel
from sonarmap.methods.bayes.updating import BayesUpdating
from sonarmap.parameters import Real, Space
from sonarmap.rings import AMIGOBOT, SonarRing

__all__ = ["BayesParameterized"]

# Forgets the rounding of 1 - 0.98, or it is not the thesis's 0.02; of a share likewise.
_DIGITS = 12


@dataclass(frozen=True)
class BayesParameterized(BayesUpdating):
    """Bayesian updating with `ParameterizedModel`; the defaults are the thesis's (figure 5.8 b).

    Parameters
    ----------
    p1 : float, optional
        P(occupied) on the axis at the sonar, in [0, 0.5). By default the thesis's rule, 1 - P4.
    p2 : float
        Gap to 0.5 at the border of regions 2 and 1, in [0, 0.5 - p1] and at most p4 - 0.5.
    p3_m : float
        Tolerance, half of the thickness of region 1, metres, > 0.
    p4 : float
        P(occupied) on the axis at the reading, in (0.5, 1].
    p5_rad : float, optional
        Half-angle of the cone, in (0, pi/3]. By default the ring's.
    no_echo, max_range_m, log_odds_limit
        See `BayesUpdating`.
    """

    name: ClassVar[str] = "bayes-parameterized"
    source: ClassVar[str] = "Rashid 2006, equations 5.1 to 5.5 and 4.14."

    p1: float | None = None
    p2: float = 0.15
    p3_m: float = THESIS_UNIT_M
    p4: float = 0.98
    p5_rad: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        self.sensor_model(AMIGOBOT)  # its rules are the parameters'

    def sensor_model(self, ring: SonarRing) -> ParameterizedModel:
        """Return the sensor model for a ring."""
        return ParameterizedModel(
            p1=round(1 - self.p4, _DIGITS) if self.p1 is None else self.p1,
            p2=self.p2,
            p3_m=self.p3_m,
            p4=self.p4,
            p5_rad=ring.half_angle_rad if self.p5_rad is None else self.p5_rad,
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched; ``p2_share`` is P2 over its largest value, P4 - 0.5."""
        return {
            "p2_share": Real(0.0, 1.0),
            # From 25 mm: a region thinner than a cell of 5 cm falls between the centres of cells.
            "p3_m": Real(0.025, 0.15),
            "p4": Real(0.51, 0.99),
            "p5_rad": Real(math.radians(3), math.radians(40)),
        }

    @classmethod
    def at(cls, point: Mapping[str, float]) -> BayesParameterized:
        """Return the method that a point of `space` stands for."""
        others: dict[str, Any] = dict(point)
        if "p2_share" in others:
            widest = others.get("p4", cls.p4) - 0.5
            others["p2"] = round(others.pop("p2_share") * widest, _DIGITS)
        return cls(**others)
