"""How the cause of a reading follows from the truth."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sonarmap import Cause
from sonarmap.kernels.jit import njit

__all__ = ["SAME_POINT_M", "cause_of"]

SAME_POINT_M = 0.06
"""Ranges that differ by less denote the same point: Rashid 2006, p. 55 (TDTh, between the axis
and the edge of the cone at 2 m)."""

# The causes as compiled code knows them.
_DIRECT, _OFF_AXIS, _OUT_OF_RANGE, _BOUNCE, _DROPOUT = (
    int(cause)
    for cause in (
        Cause.DIRECT,
        Cause.OFF_AXIS,
        Cause.OUT_OF_RANGE,
        Cause.BOUNCE,
        Cause.DROPOUT,
    )
)


@njit()  # a scan has a few readings: numpy's own calls would cost more than they do
def cause_of(
    echo_m: NDArray[np.float64],
    bounces: NDArray[np.int16],
    axis_range_m: NDArray[np.float64],
    cone_range_m: NDArray[np.float64],
) -> NDArray[np.int8]:
    """Return the `Cause` of readings that come from a sonar's own sound.

    Parameters
    ----------
    echo_m : ndarray
        Range of the echo before noise, metres; +inf for none.
    bounces : ndarray of int
        Mirroring surfaces on its path.
    axis_range_m, cone_range_m : ndarray
        True ranges on the axis and of the nearest surface in the cone; +inf beyond the maximum.

    Notes
    -----
    A straight echo is right when it comes from no farther than the axis truly reaches: DIRECT
    within `SAME_POINT_M` of it, OFF_AXIS nearer. A straight echo from farther says that what
    stands on the axis was not detected, so it is a DROPOUT, as is silence with something in range.
    """
    cause = np.empty(echo_m.size, np.int8)
    for i in range(echo_m.size):
        if math.isinf(echo_m[i]):
            cause[i] = _OUT_OF_RANGE if math.isinf(cone_range_m[i]) else _DROPOUT
        elif bounces[i] > 0:
            cause[i] = _BOUNCE
        elif echo_m[i] > axis_range_m[i] + SAME_POINT_M:
            cause[i] = _DROPOUT
        elif echo_m[i] >= axis_range_m[i] - SAME_POINT_M:
            cause[i] = _DIRECT
        else:
            cause[i] = _OFF_AXIS
    return cause
