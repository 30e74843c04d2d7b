"""The standing robot: how far repeats of one reading move a map beyond what one pose can tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import sonarmap as sm
from sonarmap.errors import InputError
from sonarmap.methods.remedies import Remedied

__all__ = ["REPEATS", "Standing", "standing_robot"]

REPEATS = 1000
"""Of one reading, from one pose."""
_RANGE_M = 1.5
_CELL_M = 0.05
# Each remedy at its usual strength: 15 degrees and half a metre, 5 cm of travel.
_REMEDIES = {
    "pose buckets": {"bucket_rad": float(np.deg2rad(15.0)), "bucket_m": 0.5},
    "one vote a travel": {"travel_m": 0.05},
}


@dataclass(frozen=True)
class Standing:
    """How far a thousand repeats move the cells of a method's map.

    Parameters
    ----------
    method : str
        Its name.
    moved : float
        Largest change of P(occupied) from one reading to a thousand of the same.
    remedied : mapping of str to float or None
        The same with each remedy; None where the method takes none.
    """

    method: str
    moved: float
    remedied: dict[str, float | None]


def standing_robot(method: str) -> Standing:
    """Return what a method makes of a robot that stands and reads one thing again and again."""
    plain = sm.method(method)
    remedied: dict[str, float | None] = {}
    for name, parameters in _REMEDIES.items():
        try:
            remedied[name] = _moved(Remedied(method=plain, **parameters))
        except InputError:
            remedied[name] = None
    return Standing(method, _moved(plain), remedied)


def _moved(method: sm.MappingMethod) -> float:
    grid = sm.GridSpec.covering(-0.5, -1.5, 2.5, 1.5, _CELL_M)
    one, many = (method.map(_log(count), grid).probability for count in (1, REPEATS))
    return float(np.abs(many - one).max())


def _log(count: int) -> sm.SonarLog:
    """Return the log of a robot that stands at the origin, with an echo ahead."""
    zeros = np.zeros(count)
    ring = sm.SonarRing(
        "ahead", np.zeros(1), np.zeros(1), np.zeros(1), float(np.deg2rad(15.0)), 0.1, 3.0
    )
    return sm.SonarLog(
        ring=ring,
        scan=np.arange(count, dtype=np.int32),
        sonar=np.zeros(count, np.int16),
        time_s=np.linspace(0.0, 0.1 * count, count),
        x_m=zeros,
        y_m=zeros,
        heading_rad=zeros,
        range_m=np.full(count, _RANGE_M),
    )
