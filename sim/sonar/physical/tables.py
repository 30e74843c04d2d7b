"""What the compiled steps of a physical sonar look up, laid out in one array.

An array that is handed to a compiled function costs its count of references, each time: one array
costs less than six.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "BEAM",
    "BEAM_STEPS",
    "BEYOND",
    "FRESNEL",
    "LOST",
    "LOST_STEPS",
    "OTHERS",
    "OWN",
    "PATH_STEPS",
    "packed",
]

BEAM_STEPS, PATH_STEPS, LOST_STEPS = 9001, 1024, 101
"""Entries of the tables by angle from 0 to pi, by path and by whole decibels."""
BEAM = 0
"""Here begins the one-way level by angle."""
BEYOND = BEAM + BEAM_STEPS
"""The highest level at an angle or farther off the axis."""
OWN = BEYOND + BEAM_STEPS
"""The level, with time-varied gain, of a perfect mirror's echo at who sent it, by path."""
OTHERS = OWN + PATH_STEPS
"""The highest such level at a sonar that did not send it, on a path or a longer one."""
LOST = OTHERS + PATH_STEPS
"""How far sound reaches that is so many decibels weaker than a mirror's on the axis."""
FRESNEL = LOST + LOST_STEPS
"""Fresnel's integrals, C and S in turn."""


def packed(
    beam_db: NDArray[np.float64],
    own_db: NDArray[np.float64],
    others_db: NDArray[np.float64],
    lost_reach_m: NDArray[np.float64],
    fresnel: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return the array of all tables; that of the beam beyond an angle is made of the beam's."""
    lengths = [len(part) for part in (beam_db, own_db, others_db, lost_reach_m)]
    assert lengths == [BEAM_STEPS, PATH_STEPS, PATH_STEPS, LOST_STEPS]
    assert math.prod(fresnel.shape) % 2 == 0
    beyond_db = np.maximum.accumulate(beam_db[::-1])[::-1]
    return np.concatenate([beam_db, beyond_db, own_db, others_db, lost_reach_m, fresnel.ravel()])
