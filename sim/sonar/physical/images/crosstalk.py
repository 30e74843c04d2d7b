"""Compiled: the sounds of a sonar that other sonars may detect, from an image over flat faces."""

from __future__ import annotations

import math

from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.paths import EDGE_ON_M, bearing, in_window
from sim.sonar.physical.levels import beam_db, mirror_echo_db, tvg_db
from sonarmap.kernels.jit import njit

__all__ = ["find_crosstalk"]


@njit(error_model="numpy")
def find_crosstalk(
    faces, before, is_listed, acoustics, limits, stack, level, sonar, xy, axis, until_m, spread_m,
    start, found,
):  # fmt: skip
    """Find paths from an image over a face to other sonars, as far as levels go.

    Parameters
    ----------
    start : int
        Number of things of the image that were looked at before.
    found : ndarray, shape (ring, ECHO_COLUMNS)
        Set in place: the paths over one face; their IS_STRAIGHT is the listener.

    Returns
    -------
    tuple of int
        Number of things looked at, and how many paths were found; none means there are no more.
    """
    mirror = int(stack[level, c.FACE])
    listed = level > 0 and is_listed
    first, last = 0, len(faces)
    if listed:
        first, last = int(faces[mirror, c.FIRST]), int(faces[mirror, c.LAST])
    ix, iy = stack[level, c.IMAGE_X], stack[level, c.IMAGE_Y]
    own_x, own_y = xy[sonar, 0], xy[sonar, 1]
    most_m = 2 * limits.reach_m
    nearest_m = max(limits.least_cross_path_m - spread_m, 0.0)
    nearest_2, farthest_2 = nearest_m * nearest_m, (most_m + spread_m) * (most_m + spread_m)
    count = 0
    for k in range(first + start, last):
        i = int(before[k]) if listed else k
        if i >= len(faces):
            break
        x0, y0 = faces[i, c.X0], faces[i, c.Y0]
        nx, ny = faces[i, c.NORMAL_X], faces[i, c.NORMAL_Y]
        height = (ix - x0) * nx + (iy - y0) * ny
        half_m = abs(height)
        if faces[i, c.OUTWARD] * height < 0 or half_m < EDGE_ON_M or i == mirror:
            continue
        if height < 0:
            nx, ny = -nx, -ny
        # The image of the image, and how far it is from the sonar, near which the others are.
        jx, jy = ix - 2 * half_m * nx, iy - 2 * half_m * ny
        apart_2 = (jx - own_x) * (jx - own_x) + (jy - own_y) * (jy - own_y)
        if apart_2 < nearest_2 or apart_2 > farthest_2:
            continue
        ex, ey = faces[i, c.X1] - x0, faces[i, c.Y1] - y0
        length_2 = ex * ex + ey * ey
        for listener in range(len(axis)):
            if listener == sonar:
                continue
            x, y = xy[listener, 0], xy[listener, 1]
            ox, oy = jx - x, jy - y
            path_m = math.sqrt(ox * ox + oy * oy)
            if path_m > most_m or path_m < limits.least_cross_path_m:
                continue
            if until_m[listener] <= path_m < limits.least_late_path_m:
                continue
            other_m = (x - x0) * nx + (y - y0) * ny
            if other_m <= 0:
                continue
            back = other_m / (other_m + half_m)
            px, py = x + back * ox, y + back * oy
            share = ((px - x0) * ex + (py - y0) * ey) / length_2
            if not (0 <= share <= 1 and in_window(stack, level, px, py)):
                continue
            # Each mirror is passed once on such a path.
            level_db = mirror_echo_db(acoustics, path_m) + stack[level, c.LOSS] + faces[i, c.MIRROR]
            level_db += beam_db(acoustics, math.atan2(oy, ox) - axis[listener])
            latest_s = path_m / acoustics.speed_mps + acoustics.head_start_s
            gain_db = tvg_db(acoustics, min(latest_s, acoustics.window_s))
            if level_db + gain_db <= 0:
                continue
            level_db += beam_db(acoustics, bearing(stack, level, px, py))
            if level_db + gain_db <= 0:
                continue
            found[count, c.PATH], found[count, c.LEVEL] = path_m, level_db
            found[count, c.ECHO_SURFACE] = faces[i, c.SURFACE]
            cos = other_m / max(back * path_m, 1e-12)
            found[count, c.INCIDENCE] = math.acos(min(1.0, cos))
            found[count, c.AT_X], found[count, c.AT_Y] = px, py
            found[count, c.IS_STRAIGHT] = listener
            count += 1
        if count > 0:
            return k - first + 1, count
    return 0, 0
