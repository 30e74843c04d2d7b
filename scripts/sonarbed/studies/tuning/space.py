"""What may be searched: ranges of parameters, and the candidate that a point of them means.

The ranges are a box, as every sampler wants it. Where a rule binds two parameters, the box has
coordinates of its own: `p2_share` is P2 by its largest value, P4 - 0.5, and `wall_growth_m` is
how much longer the longest estimated wall is than the shortest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sonarmap import AMIGOBOT, HsrParams, ParameterizedModel, SensorModel, StandardModel
from sonarmap.goodness import thesis_parameter_sets

__all__ = [
    "MODELS",
    "RING",
    "TARGETS",
    "Candidate",
    "candidate",
    "ranges",
    "thesis_candidates",
    "thesis_points",
]

TARGETS = ("model", "hsr", "both")
MODELS = ("parameterized", "standard")
RING = AMIGOBOT
"""The ring of the simulated robot."""

# P3 from 25 mm, the thesis's smallest: a region thinner than a cell of 5 cm falls between the
# centres of cells, so that readings mark nothing and a map of no walls at all scores well.
_MODEL_RANGES = {
    "parameterized": {
        "p2_share": (0.0, 1.0),
        "p3_m": (0.025, 0.15),
        "p4": (0.51, 0.99),
        "p5_deg": (3.0, 40.0),
    },
    "standard": {
        "tolerance_m": (0.025, 0.15),
        "max_occupied": (0.51, 0.99),
        "beta_deg": (3.0, 40.0),
    },
}
# Below the lowest threshold no reading of a normal drive vouches for anything: HSR is off.
_HSR_RANGES = {
    "min_wall_m": (0.0, 0.2),
    "wall_growth_m": (0.0, 0.4),
    "threshold_m": (0.2, RING.range_max_m),
    "target_distance_m": (0.0, 0.5),
}
# Forgets the rounding of a share that was divided out and is multiplied back.
_DIGITS = 12


@dataclass(frozen=True)
class Candidate:
    """A way from a log to a map.

    Parameters
    ----------
    model : SensorModel
        The sensor model.
    hsr : HsrParams or None
        HSR before it, or none.
    """

    model: SensorModel
    hsr: HsrParams | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the parameters by name as JSON-able values, angles in degrees."""
        model = self.model
        if isinstance(model, ParameterizedModel):
            parameters = {
                "p1": model.p1,
                "p2": model.p2,
                "p3_m": model.p3_m,
                "p4": model.p4,
                "p5_deg": round(math.degrees(model.p5_rad), _DIGITS),
            }
        else:
            assert isinstance(model, StandardModel)
            parameters = {
                "beta_deg": round(math.degrees(model.beta_rad), _DIGITS),
                "max_range_m": model.max_range_m,
                "max_occupied": model.max_occupied,
                "tolerance_m": model.tolerance_m,
            }
        if self.hsr is not None:
            names = ("min_wall_m", "max_wall_m", "threshold_m", "target_distance_m")
            parameters |= {name: getattr(self.hsr, name) for name in names}
        return parameters


def ranges(target: str, model: str) -> dict[str, tuple[float, float]]:
    """Return the lowest and highest value of each coordinate that a target searches."""
    searched: dict[str, tuple[float, float]] = {}
    if target in ("model", "both"):
        searched |= _MODEL_RANGES[model]
    if target in ("hsr", "both"):
        searched |= _HSR_RANGES
    return searched


def candidate(point: Mapping[str, float], model: str) -> Candidate:
    """Return the candidate that a point of the search means.

    What is not searched is the thesis's: the sensor model when there is no coordinate of one, and
    no HSR at all when there is none of HSR.
    """
    return Candidate(_model(point, model), _hsr(point) if "min_wall_m" in point else None)


def thesis_candidates(target: str, model: str) -> dict[str, Candidate]:
    """Return what the best candidate is held against, by name."""
    thesis = _thesis_model(model)
    if target == "model":
        return {"thesis": Candidate(thesis)}
    return {
        "thesis": Candidate(thesis, HsrParams.thesis(RING)),
        "no HSR": Candidate(thesis),
    }


def thesis_points() -> list[dict[str, float]]:
    """Return the 1440 sets of the thesis's search as points, in their order."""
    return [
        {
            "p2_share": model.p2 / (model.p4 - 0.5),
            "p3_m": model.p3_m,
            "p4": model.p4,
            "p5_deg": round(math.degrees(model.p5_rad), _DIGITS),
        }
        for model in thesis_parameter_sets()
    ]


def _model(point: Mapping[str, float], model: str) -> SensorModel:
    if "p4" in point:
        p4 = point["p4"]
        return ParameterizedModel(
            p1=round(1 - p4, _DIGITS),
            p2=round(point["p2_share"] * (p4 - 0.5), _DIGITS),
            p3_m=point["p3_m"],
            p4=p4,
            p5_rad=math.radians(point["p5_deg"]),
        )
    if "beta_deg" in point:
        return StandardModel(
            beta_rad=math.radians(point["beta_deg"]),
            max_range_m=RING.range_max_m,
            max_occupied=point["max_occupied"],
            tolerance_m=point["tolerance_m"],
        )
    return _thesis_model(model)


def _thesis_model(model: str) -> SensorModel:
    return StandardModel.thesis() if model == "standard" else ParameterizedModel.thesis()


def _hsr(point: Mapping[str, float]) -> HsrParams:
    return HsrParams(
        min_wall_m=point["min_wall_m"],
        max_wall_m=point["min_wall_m"] + point["wall_growth_m"],
        threshold_m=point["threshold_m"],
        target_distance_m=point["target_distance_m"],
    )
