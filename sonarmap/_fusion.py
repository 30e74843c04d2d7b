"""The compiled loop of occupancy mapping: add the log-odds of readings to the cells they touch.

Work is laid out so that the compiler can use vector instructions: for each reading the cells of
its cone are listed first, their evidence is computed in one straight loop without branches or
library calls, and then it is added row by row. The plain version of the same arithmetic is in
the tests (`tests/sonarmap/test_mapping.py`).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["add_readings", "bearing_polynomial"]

_DEGREE = 12
_LN_2 = math.log(2)
# Bits of sqrt(1/2) as float64: the mantissa is split there, so that it lies around 1.
_SQRT_HALF_BITS = int(np.float64(math.sqrt(0.5)).view(np.int64))
_P_MIN, _P_MAX = 1e-6, 1 - 1e-6
# Keeps the quotient of half-angles defined for a cell centre that is the sonar's own place.
_TINY = 1e-300
# Cells; more than the rounding of the cone's edges and less than shows in the time.
_SLACK = 1e-6
# NaN and infinity never enter the loop, and the order of sums within one cell is kept outside.
_FAST = {"contract", "nsz", "nnan", "ninf", "arcp", "reassoc"}


def bearing_polynomial(half_angle_rad: float) -> NDArray[np.float64]:
    """Return coefficients c with ``bearing / half_angle = t * sum(c[k] * t**(2 k))``.

    Here ``t = tan(|bearing| / 2)``, which needs no inverse function: it is
    ``across / (range + along)``. The fit is a Chebyshev interpolation of atan(t)/t over the cone,
    good to 1e-12 for half-angles up to 60 degrees.
    """
    widest = math.tan(half_angle_rad / 2) ** 2

    def atan_over(z: NDArray[np.float64]) -> NDArray[np.float64]:
        t = np.sqrt(z)
        return np.arctan(t) / t

    fit = np.polynomial.Chebyshev.interpolate(atan_over, _DEGREE, [0, widest])
    powers = fit.convert(kind=np.polynomial.Polynomial).coef
    coefficients = np.zeros(_DEGREE + 1)
    coefficients[: powers.size] = powers
    return coefficients * (2 / half_angle_rad)


@njit(cache=True, inline="always", error_model="numpy")
def _log(x):  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    """Natural logarithm of a positive normal number, good to 1e-15, as plain arithmetic."""
    bits = np.float64(x).view(np.int64)
    exponent = (bits - _SQRT_HALF_BITS) >> 52
    mantissa = np.int64(bits - (exponent << 52)).view(np.float64)
    # ln m = 2 atanh((m - 1) / (m + 1)), its series in z <= 0.0295.
    s = (mantissa - 1.0) / (mantissa + 1.0)
    z = s * s
    tail = 2.0 / 15 + z * (2.0 / 17)
    tail = 2.0 / 13 + z * tail
    tail = 2.0 / 11 + z * tail
    tail = 2.0 / 9 + z * tail
    tail = 2.0 / 7 + z * tail
    tail = 2.0 / 5 + z * tail
    tail = 2.0 / 3 + z * tail
    return exponent * _LN_2 + s * (2.0 + z * tail)


@njit(cache=True, fastmath=_FAST, error_model="numpy")
def _evidence(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    dx, dy, out, axis_x, axis_y, border, axis, edge, c
):
    """Write the log-odds of cells at (dx, dy) from the sonar into `out`; 0 where silent."""
    near, middle, reach = border[0], border[1], border[2]
    axis0, axis0_slope, edge0, edge0_slope = axis[0, 0], axis[0, 1], edge[0, 0], edge[0, 1]
    axis1, axis1_slope, edge1, edge1_slope = axis[1, 0], axis[1, 1], edge[1, 0], edge[1, 1]
    axis2, axis2_slope, edge2, edge2_slope = axis[2, 0], axis[2, 1], edge[2, 0], edge[2, 1]
    for j in range(out.size):
        r = math.sqrt(dx[j] * dx[j] + dy[j] * dy[j])
        along = dx[j] * axis_x + dy[j] * axis_y
        across = abs(dx[j] * axis_y - dy[j] * axis_x)
        # Behind the sonar, where r + along comes down to 0, any finite number will do.
        ahead = along if along > 0.0 else 0.0
        t = across / (r + ahead + _TINY)
        z = t * t
        # Horner's rule, written out: a loop here would keep the outer one from being vectorised.
        poly = c[11] + z * c[12]
        poly = c[10] + z * poly
        poly = c[9] + z * poly
        poly = c[8] + z * poly
        poly = c[7] + z * poly
        poly = c[6] + z * poly
        poly = c[5] + z * poly
        poly = c[4] + z * poly
        poly = c[3] + z * poly
        poly = c[2] + z * poly
        poly = c[1] + z * poly
        share = t * (c[0] + z * poly)
        in_first, in_second = r < near, r < middle
        on_axis = (
            axis0 + axis0_slope * r
            if in_first
            else (axis1 + axis1_slope * r if in_second else axis2 + axis2_slope * r)
        )
        at_edge = (
            edge0 + edge0_slope * r
            if in_first
            else (edge1 + edge1_slope * r if in_second else edge2 + edge2_slope * r)
        )
        p = on_axis + (at_edge - on_axis) * share
        p = p if p > _P_MIN else _P_MIN
        p = p if p < _P_MAX else _P_MAX
        log_odds = _log(p / (1.0 - p))
        speaks = (share <= 1.0) & (r <= reach) & (along >= 0.0)
        out[j] = log_odds if speaks else 0.0


@njit(cache=True, error_model="numpy")
def add_readings(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    log_odds,
    origin_x,
    origin_y,
    resolution,
    sensor_xy,
    axis_rad,
    half_angle,
    border,
    axis,
    edge,
    bearing,
    limit,
):
    """Add the evidence of n readings to `log_odds` (rows, cols) in place.

    Parameters
    ----------
    log_odds : ndarray, shape (rows, cols)
        The map, changed in place.
    origin_x, origin_y, resolution : float
        The grid, metres.
    sensor_xy : ndarray, shape (n, 2)
        Sonar positions, metres.
    axis_rad : ndarray, shape (n,)
        Acoustic axes, radians.
    half_angle : float
        Half-angle of the cone, radians.
    border, axis, edge : ndarray, shapes (n, 3), (n, 3, 2), (n, 3, 2)
        The readings' `Regions`.
    bearing : ndarray
        `bearing_polynomial` of the half-angle.
    limit : float
        Bound on the sum in each cell, inf for none.
    """
    rows, cols = log_odds.shape
    # At most this many cells lie within reach of a sonar: half a disc, in its bounding box.
    room = 0
    for i in range(axis_rad.size):
        across = int(2 * border[i, 2] / resolution) + 3
        room = max(room, min(rows, across) * min(cols, across))
    dx, dy, evidence = np.empty(room), np.empty(room), np.empty(room)
    first, count = np.empty(rows, np.int64), np.empty(rows, np.int64)
    cos_half, sin_half = math.cos(half_angle), math.sin(half_angle)

    for i in range(axis_rad.size):
        axis_x, axis_y = math.cos(axis_rad[i]), math.sin(axis_rad[i])
        # Directions of the cone's left and right edge.
        left_x = axis_x * cos_half - axis_y * sin_half
        left_y = axis_y * cos_half + axis_x * sin_half
        right_x = axis_x * cos_half + axis_y * sin_half
        right_y = axis_y * cos_half - axis_x * sin_half
        reach = border[i, 2]
        # The sonar's place relative to the centre of cell (0, 0).
        start_x = sensor_xy[i, 0] - origin_x - 0.5 * resolution
        start_y = sensor_xy[i, 1] - origin_y - 0.5 * resolution

        # Rows of the cone: between its corners, or up to the arc where it holds the y direction.
        top = reach if axis_y > cos_half else reach * max(0.0, left_y, right_y)
        bottom = -reach if axis_y < -cos_half else reach * min(0.0, left_y, right_y)
        # Here and below a cell of slack: `_evidence` decides exactly, this only saves it work.
        row_begin = max(0, math.floor((start_y + bottom) / resolution))
        row_end = min(rows, math.ceil((start_y + top) / resolution) + 1)

        # List the cells: in each row those between the cone's edges and within reach.
        n = 0
        for row in range(row_begin, row_end):
            first[row], count[row] = 0, 0
            v = row * resolution - start_y
            half_chord_squared = reach * reach - v * v
            if half_chord_squared < 0:
                continue
            high = math.sqrt(half_chord_squared)
            low = -high
            if left_y > _TINY:
                low = max(low, v * left_x / left_y)
            elif left_y < -_TINY:
                high = min(high, v * left_x / left_y)
            if right_y > _TINY:
                high = min(high, v * right_x / right_y)
            elif right_y < -_TINY:
                low = max(low, v * right_x / right_y)
            begin = max(0, math.floor((start_x + low) / resolution - _SLACK))
            end = min(cols, math.ceil((start_x + high) / resolution + _SLACK) + 1)
            if end <= begin:
                continue
            first[row], count[row] = begin, end - begin
            for k in range(end - begin):
                dx[n + k] = (begin + k) * resolution - start_x
                dy[n + k] = v
            n += end - begin

        _evidence(
            dx[:n], dy[:n], evidence[:n], axis_x, axis_y, border[i], axis[i], edge[i], bearing
        )

        n = 0
        for row in range(row_begin, row_end):
            line = log_odds[row, first[row] : first[row] + count[row]]
            added = evidence[n : n + count[row]]
            for k in range(line.size):
                total = line[k] + added[k]
                total = total if total < limit else limit
                line[k] = total if total > -limit else -limit
            n += count[row]
