"""What may be searched: ranges of parameters, and the pipeline that a point of them means.

The ranges are those that a method and a filter state themselves (`space`), angles in degrees. They
are a box, as every sampler wants it; where a rule binds two parameters, the part has coordinates
of its own and makes itself of a point (`at`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType
from typing import Any

import sonarmap as sm
from sonarmap.goodness import thesis_parameter_sets
from sonarmap.parameters import Real, at_point

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
RING = sm.AMIGOBOT
"""The ring of the simulated robot."""

_METHODS = MappingProxyType({"parameterized": "bayes-parameterized", "standard": "bayes-standard"})
MODELS = tuple(_METHODS)
_HSR = "hsr"
# Forgets the rounding of an angle that was turned into radians and back.
_DIGITS = 12


@dataclass(frozen=True)
class Candidate:
    """A way from a log to a map that may be better than another.

    Parameters
    ----------
    pipeline : Pipeline
        The way.
    """

    pipeline: sm.Pipeline

    def to_dict(self) -> dict[str, Any]:
        """Return the parameters by name as JSON-able values, angles in degrees."""
        method: Any = self.pipeline.method
        parameters = asdict(method.sensor_model(RING))
        for each in self.pipeline.filters:
            parameters |= asdict(each)  # type: ignore[call-overload]  # a filter is a dataclass
        return {_in_degrees(name): _degrees(name, value) for name, value in parameters.items()}


def ranges(target: str, model: str) -> dict[str, tuple[float, float]]:
    """Return the lowest and highest value of each coordinate that a target searches."""
    searched: dict[str, tuple[float, float]] = {}
    for part in _parts(target, model):
        for name, each in part.space().items():
            assert isinstance(each, Real), f"{name} is no real number"
            searched[_in_degrees(name)] = _degrees(name, each.low), _degrees(name, each.high)
    return searched


def candidate(
    point: Mapping[str, float], model: str, max_range_m: float | None = None
) -> Candidate:
    """Return the candidate that a point of the search means.

    What is not searched is the thesis's: the sensor model when there is no coordinate of one, and
    no HSR at all when there is none of HSR.

    Parameters
    ----------
    point : mapping of str to float
        A value of each coordinate.
    model : str
        One of `MODELS`.
    max_range_m : float, optional
        Longer readings are taken as no echo.
    """
    method, hsr = sm.methods()[_METHODS[model]], sm.filters()[_HSR]
    radians = {_in_radians(name): _radians(name, value) for name, value in point.items()}
    own, of_hsr = (
        {name: value for name, value in radians.items() if name in part.space()}
        for part in (method, hsr)
    )
    made: Any = at_point(method, own)
    return Candidate(
        sm.Pipeline(
            [at_point(hsr, of_hsr)] if of_hsr else [],
            made if max_range_m is None else made.replace(max_range_m=max_range_m),
        )
    )


def thesis_candidates(
    target: str, model: str, max_range_m: float | None = None
) -> dict[str, Candidate]:
    """Return what the best candidate is held against, by name."""
    without = candidate({}, model, max_range_m)
    if target == "model":
        return {"thesis": without}
    closed_room = sm.HsrParams.thesis(RING)
    hsr = sm.filter(_HSR, **asdict(closed_room))
    return {
        "thesis": Candidate(sm.Pipeline([hsr], without.pipeline.method)),
        "no HSR": without,
    }


def thesis_points() -> list[dict[str, float]]:
    """Return the 1440 sets of the thesis's search as points, in their order."""
    return [
        {
            "p2_share": model.p2 / (model.p4 - 0.5),
            "p3_m": model.p3_m,
            "p4": model.p4,
            "p5_deg": _degrees("p5_rad", model.p5_rad),
        }
        for model in thesis_parameter_sets()
    ]


def _parts(target: str, model: str) -> list[Any]:
    """Return the classes of what a target searches."""
    method = [sm.methods()[_METHODS[model]]] if target in ("model", "both") else []
    hsr = [sm.filters()[_HSR]] if target in ("hsr", "both") else []
    return [*method, *hsr]


def _in_degrees(name: str) -> str:
    return name.removesuffix("_rad") + "_deg" if name.endswith("_rad") else name


def _in_radians(name: str) -> str:
    return name.removesuffix("_deg") + "_rad" if name.endswith("_deg") else name


def _degrees(name: str, value: Any) -> Any:
    return round(math.degrees(value), _DIGITS) if name.endswith("_rad") else value


def _radians(name: str, value: float) -> float:
    return math.radians(value) if name.endswith("_deg") else value
