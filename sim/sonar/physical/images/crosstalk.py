"""Compiled: the sounds of a sonar that other sonars may detect, from an image."""

from __future__ import annotations

import math

from sim.sonar.physical.fresnel import FOCUS_DB
from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.echoes import edge_seen
from sim.sonar.physical.images.paths import EDGE_ON_M, bearing, in_window
from sim.sonar.physical.images.shares import face_share, mirrors_share
from sim.sonar.physical.levels import (
    beam_bound_db,
    beam_db,
    loudest_other_db,
    mirror_echo_db,
    others_tvg_db,
    power_db,
)
from sim.sonar.physical.turning import edge_share_db, pillar_share_db, turning_place
from sonarmap.kernels.jit import njit

__all__ = ["find_crosstalk"]


@njit(error_model="numpy", makes_arrays=False)
def find_crosstalk(
    scene, acoustics, limits, stack, level, sonar, xy, axis, gain_db, until_m, spread_m, most_db,
    start, found,
):  # fmt: skip
    """Find paths from an image over a face, or over a pillar or an edge, to other sonars.

    Parameters
    ----------
    start : int
        Number of things of the image that were looked at before.
    found : ndarray, shape (ring, ECHO_COLUMNS)
        Set in place: the paths over one thing; their IS_STRAIGHT is the listener.

    Returns
    -------
    tuple of int
        Number of things looked at, and how many paths were found; none means there are no more.
    """
    faces, points, arms, stops, before, is_listed, _ = scene
    mirror = int(stack[level, c.FACE])
    listed = level > 0 and is_listed
    first, last = 0, len(faces) + len(points)
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
            if level > 0:
                break  # points pass sound on without mirrors only
            vx, vy = points[i - len(faces), c.POINT_X] - ix, points[i - len(faces), c.POINT_Y] - iy
            radius_m = points[i - len(faces), c.RADIUS]
            apart_2 = vx * vx + vy * vy
            far_m = limits.edge_reach_m if radius_m == 0 else limits.reach_m + radius_m
            if 4 * apart_2 < nearest_2 or apart_2 > (far_m + spread_m) ** 2:
                continue
            count = _over_point(
                faces, points, arms, acoustics, limits, stack, sonar, xy, axis, gain_db, until_m,
                spread_m, most_db, i - len(faces), found,
            )  # fmt: skip
            if count > 0:
                return k - first + 1, count
            continue
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
            at = ((px - x0) * ex + (py - y0) * ey) / length_2
            if not (0 <= at <= 1 and in_window(stack, level, px, py)):
                continue
            # Each mirror is passed once on such a path.
            level_db = mirror_echo_db(acoustics, path_m) + stack[level, c.LOSS] + faces[i, c.MIRROR]
            level_db += beam_db(acoustics, math.atan2(oy, ox) - axis[listener])
            level_db += gain_db[listener]
            rise_db = others_tvg_db(acoustics, path_m)
            if level_db + FOCUS_DB + rise_db <= 0:
                continue
            level_db += beam_db(acoustics, bearing(stack, level, px, py))
            if level_db + FOCUS_DB + rise_db <= 0:
                continue
            cos = min(other_m / max(back * path_m, 1e-12), 1.0)
            length_m = math.sqrt(length_2)
            foot_m = ((ix - x0) * ex + (iy - y0) * ey) / length_m
            share = face_share(
                faces, stops, acoustics, i, height, foot_m, at * length_m, cos,
                (1 - back) * path_m, back * path_m,
            )  # fmt: skip
            if level > 0:
                share *= mirrors_share(faces, stops, acoustics, stack, level, px, py, path_m)
            level_db += power_db(share)
            if level_db + rise_db <= 0:
                continue
            found[count, c.PATH], found[count, c.LEVEL] = path_m, level_db
            found[count, c.ECHO_SURFACE] = faces[i, c.SURFACE]
            found[count, c.INCIDENCE] = math.acos(cos)
            found[count, c.AT_X], found[count, c.AT_Y] = px, py
            found[count, c.IS_STRAIGHT] = listener
            count += 1
        if count > 0:
            return k - first + 1, count
    return 0, 0


@njit(error_model="numpy", makes_arrays=False)
def _over_point(
    faces, points, arms, acoustics, limits, stack, sonar, xy, axis, gain_db, until_m, spread_m,
    most_db, k, found,
):  # fmt: skip
    """Find paths over a pillar or an edge, without mirrors; return how many."""
    own_x, own_y = xy[sonar, 0], xy[sonar, 1]
    radius_m = points[k, c.RADIUS]
    vx, vy = points[k, c.POINT_X] - own_x, points[k, c.POINT_Y] - own_y
    apart_m = math.sqrt(vx * vx + vy * vy)
    near_m = apart_m - radius_m
    if (
        near_m < EDGE_ON_M
        or 2 * apart_m + spread_m < limits.least_cross_path_m
        or near_m - spread_m > limits.reach_m
        or stack[0, c.RIGHT_X] * vy - stack[0, c.RIGHT_Y] * vx < 0
        or vx * stack[0, c.LEFT_Y] - vy * stack[0, c.LEFT_X] < 0
    ):
        return 0
    # No listener is nearer than this, and none of what turns sound is louder there.
    least_m = max(near_m - spread_m, 1e-6)
    face, turned_db = -1, 0.0
    if radius_m > 0:
        surface, turned_db = points[k, c.POINT_SURFACE], points[k, c.POINT_MIRROR]
        most_share_db = pillar_share_db(radius_m, 1.0, least_m, least_m)
        most_share_db = max(most_share_db, points[k, c.POINT_FLOOR])
        aside = math.asin(radius_m / apart_m)
    else:
        face, turned_db = edge_seen(
            faces, arms, int(points[k, c.FIRST_ARM]), int(points[k, c.LAST_ARM]), -vx, -vy
        )
        if face < 0:
            return 0
        surface = faces[face, c.SURFACE]
        most_share_db = edge_share_db(acoustics.edge_db, least_m, least_m)
        aside = 0.0
    towards = bearing(stack, 0, own_x + vx, own_y + vy)
    least_path_m = max(near_m + least_m, limits.least_cross_path_m)
    loudest_db = loudest_other_db(acoustics, least_path_m) + stack[0, c.LOSS] + turned_db
    loudest_db += most_db + most_share_db
    if loudest_db + beam_bound_db(acoustics, towards - aside, towards + aside) <= 0:
        return 0
    count = 0
    for listener in range(len(axis)):
        if listener == sonar:
            continue
        x, y = xy[listener, 0], xy[listener, 1]
        px, py, cos = own_x + vx, own_y + vy, 1.0
        if radius_m > 0:
            px, py, cos = turning_place(px, py, radius_m, own_x, own_y, x, y)
        one_m, other_m = math.hypot(px - own_x, py - own_y), math.hypot(px - x, py - y)
        path_m = one_m + other_m
        if path_m > 2 * limits.reach_m or path_m < limits.least_cross_path_m:
            continue
        if until_m[listener] <= path_m < limits.least_late_path_m:
            continue
        if radius_m > 0:
            share_db = max(pillar_share_db(radius_m, cos, one_m, other_m), points[k, c.POINT_FLOOR])
        else:
            share_db = edge_share_db(acoustics.edge_db, one_m, other_m)
            nx, ny = faces[face, c.NORMAL_X], faces[face, c.NORMAL_Y]
            cos = abs((px - x) * nx + (py - y) * ny) / other_m
        level_db = mirror_echo_db(acoustics, path_m) + stack[0, c.LOSS] + gain_db[listener]
        level_db += turned_db + share_db + beam_db(acoustics, bearing(stack, 0, px, py))
        level_db += beam_db(acoustics, math.atan2(py - y, px - x) - axis[listener])
        if level_db + others_tvg_db(acoustics, path_m) <= 0:
            continue
        found[count, c.PATH], found[count, c.LEVEL] = path_m, level_db
        found[count, c.ECHO_SURFACE], found[count, c.INCIDENCE] = surface, math.acos(min(cos, 1.0))
        found[count, c.AT_X], found[count, c.AT_Y] = px, py
        found[count, c.IS_STRAIGHT] = listener
        count += 1
    return count
