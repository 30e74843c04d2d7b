"""The compiled loop of `sonarmap.filters.linear_features`: where cones meet line segments.

The plain version is in the tests (`tests/sonarmap/filters/test_linear_features.py`).
"""

from __future__ import annotations

import math

import numpy as np

from sonarmap.kernels.jit import njit

__all__ = ["nearest_segment"]


@njit(error_model="numpy")
def nearest_segment(  # type: ignore[no-untyped-def]  # pragma: no cover - compiled
    sensor_xy, axis_rad, half_angle, ends
):
    """Return how far the nearest segment in each cone is, and which one.

    Parameters
    ----------
    sensor_xy, axis_rad : ndarray, shapes (n, 2), (n,)
        Places and axes of the sonars, metres and radians.
    half_angle : float
        Half-angle of the cones, radians, below pi/2.
    ends : ndarray, shape (segments, 4)
        x, y of both ends of each segment, metres.

    Returns
    -------
    range_m : ndarray, shape (n,)
        Distance of the nearest point of a segment in the cone; inf for none.
    which : ndarray of int, shape (n,)
        The segment; -1 for none.
    """
    n = axis_rad.size
    range_m, which = np.full(n, np.inf), np.full(n, -1, np.int64)
    slope = math.tan(half_angle)
    for i in range(n):
        cos, sin = math.cos(axis_rad[i]), math.sin(axis_rad[i])
        for j in range(ends.shape[0]):
            ax, ay = ends[j, 0] - sensor_xy[i, 0], ends[j, 1] - sensor_xy[i, 1]
            bx, by = ends[j, 2] - sensor_xy[i, 0], ends[j, 3] - sensor_xy[i, 1]
            # Along and across the axis; in the cone |across| <= along * slope.
            along, across = ax * cos + ay * sin, ay * cos - ax * sin
            d_along, d_across = bx * cos + by * sin - along, by * cos - bx * sin - across
            low, high = 0.0, 1.0
            for side in (-1.0, 1.0):
                inside = along * slope + side * across
                change = d_along * slope + side * d_across
                if change > 0.0:
                    low = max(low, -inside / change)
                elif change < 0.0:
                    high = min(high, -inside / change)
                elif inside < 0.0:
                    high = -1.0
            if low > high:
                continue
            length = d_along * d_along + d_across * d_across
            t = -(along * d_along + across * d_across) / length if length > 0.0 else 0.0
            t = min(max(t, low), high)
            distance = math.hypot(along + t * d_along, across + t * d_across)
            if distance < range_m[i]:
                range_m[i], which[i] = distance, j
    return range_m, which
