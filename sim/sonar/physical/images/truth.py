"""Compiled: true ranges on a sonar's axis and in its cone, exact."""

from __future__ import annotations

import math

from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.paths import length_of_ray
from sonarmap.kernels.jit import njit

__all__ = ["true_ranges"]


@njit(error_model="numpy", makes_arrays=False)
def true_ranges(faces, points, rays, far_m, half, x, y, axis):
    """Return the ranges of the nearest face on the axis and in the cone; +inf beyond the range.

    Parameters
    ----------
    faces, points, rays
        Of the `Scene`.
    far_m, half : float
        Range and half-angle of the cone.
    x, y, axis : float
        Where the sonar is and looks.
    """
    axis_m = length_of_ray(rays, x, y, math.cos(axis), math.sin(axis), far_m)
    right_x, right_y = math.cos(axis - half), math.sin(axis - half)
    left_x, left_y = math.cos(axis + half), math.sin(axis + half)
    cone_m = min(
        axis_m,
        length_of_ray(rays, x, y, right_x, right_y, far_m),
        length_of_ray(rays, x, y, left_x, left_y, far_m),
    )
    # The nearest place lies on the sides, or is a foot or an end of a face between them. What
    # would hide it would be nearer.
    nearest = min(cone_m, far_m)
    nearest_2, is_between = nearest * nearest, False
    for i in range(len(faces)):
        ax, ay = faces[i, c.X0] - x, faces[i, c.Y0] - y
        height = ax * faces[i, c.NORMAL_X] + ay * faces[i, c.NORMAL_Y]
        if height * height > nearest_2:
            continue
        ex, ey = faces[i, c.X1] - faces[i, c.X0], faces[i, c.Y1] - faces[i, c.Y0]
        share = min(max(-(ax * ex + ay * ey) / (ex * ex + ey * ey), 0.0), 1.0)
        for k in range(3):
            if k > 0:
                share = k - 1.0
            px, py = ax + share * ex, ay + share * ey
            apart_2 = px * px + py * py
            if (
                apart_2 <= nearest_2
                and right_x * py - right_y * px >= 0
                and px * left_y - py * left_x >= 0
            ):
                nearest_2, is_between = apart_2, True
    for i in range(len(points)):
        radius_m = points[i, c.RADIUS]
        if radius_m == 0:
            break  # vertices, which are ends of faces
        px, py = points[i, c.POINT_X] - x, points[i, c.POINT_Y] - y
        apart_m = math.sqrt(px * px + py * py)
        if apart_m < radius_m:
            px, py = -px, -py  # from inside, the nearest place is on the other side
        gap_m = abs(apart_m - radius_m)
        if (
            gap_m * gap_m <= nearest_2
            and right_x * py - right_y * px >= 0
            and px * left_y - py * left_x >= 0
        ):
            nearest_2, is_between = gap_m * gap_m, True
    return axis_m, (math.sqrt(nearest_2) if is_between else cone_m)
