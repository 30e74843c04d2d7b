"""Compiled: mirror images of a transducer, what they see, and whether their paths are free.

The images over one mirror, two and so on lie on a stack, one row each: row 0 is the transducer
itself. An image sees through its window, the part of its mirror that the image before it sees.
"""

from __future__ import annotations

import math

from sim.sonar.physical.fresnel import FOCUS_DB
from sim.sonar.physical.images import columns as c
from sim.sonar.physical.levels import beam_bound_db, loudest_echo_db, loudest_other_db
from sonarmap.kernels.jit import njit
from worlds.raycast import first_hit

__all__ = [
    "EDGE_ON_M",
    "OFF_M",
    "bearing",
    "blocked_at",
    "in_window",
    "is_leg_free",
    "length_of_ray",
    "next_image",
    "seen_part",
    "set_transducer",
]

EDGE_ON_M = 1e-9
"""A face whose line passes so near to a sonar is seen edge-on."""
OFF_M = 1e-6
"""A mirrored leg begins this far off its mirror, so that it does not meet it again."""
# A leg is free if it meets nothing until so far before its end, metres: its end may lie that deep
# in a face that is drawn to touch another one.
_SHORT_M = 2e-4
# Whether a face is hidden is decided at so many places of it.
_HIDDEN_PARTS = 8


@njit(error_model="numpy", makes_arrays=False)
def set_transducer(stack, wide_rad, x, y, axis, gain_db):
    """Let a stack begin with the transducer itself: its window is as wide as its sound."""
    ax, ay = math.cos(axis), math.sin(axis)
    cos, sin = math.cos(wide_rad), math.sin(wide_rad)
    stack[0, c.IMAGE_X], stack[0, c.IMAGE_Y] = x, y
    stack[0, c.AXIS_X], stack[0, c.AXIS_Y] = ax, ay
    stack[0, c.SIGN], stack[0, c.LOSS] = 1.0, gain_db
    stack[0, c.RIGHT_X], stack[0, c.RIGHT_Y] = ax * cos + ay * sin, ay * cos - ax * sin
    stack[0, c.LEFT_X], stack[0, c.LEFT_Y] = ax * cos - ay * sin, ay * cos + ax * sin
    stack[0, c.WINDOW_X] = stack[0, c.WINDOW_Y] = stack[0, c.ON_X] = stack[0, c.ON_Y] = 0.0
    stack[0, c.FACE], stack[0, c.NEXT] = -1.0, 0.0


@njit(error_model="numpy", makes_arrays=False)
def _push_image(stack, level, faces, i, loss_db, height, low, high):
    """Set the image over a face, one level up, that looks out between two shares of the face.

    The old image lies at a height over the face.
    """
    nx, ny = faces[i, c.NORMAL_X], faces[i, c.NORMAL_Y]
    ix, iy = stack[level, c.IMAGE_X] - 2 * height * nx, stack[level, c.IMAGE_Y] - 2 * height * ny
    along = stack[level, c.AXIS_X] * nx + stack[level, c.AXIS_Y] * ny
    new = level + 1
    stack[new, c.IMAGE_X], stack[new, c.IMAGE_Y] = ix, iy
    stack[new, c.AXIS_X] = stack[level, c.AXIS_X] - 2 * along * nx
    stack[new, c.AXIS_Y] = stack[level, c.AXIS_Y] - 2 * along * ny
    stack[new, c.SIGN], stack[new, c.LOSS] = -stack[level, c.SIGN], loss_db
    mx, my = faces[i, c.X0], faces[i, c.Y0]
    ex, ey = faces[i, c.X1] - mx, faces[i, c.Y1] - my
    px, py = mx + low * ex - ix, my + low * ey - iy
    qx, qy = mx + high * ex - ix, my + high * ey - iy
    if px * qy - py * qx < 0:
        px, py, qx, qy = qx, qy, px, py
    stack[new, c.RIGHT_X], stack[new, c.RIGHT_Y] = px, py
    stack[new, c.LEFT_X], stack[new, c.LEFT_Y] = qx, qy
    if height < 0:
        nx, ny = -nx, -ny
    stack[new, c.WINDOW_X], stack[new, c.WINDOW_Y] = nx, ny
    stack[new, c.ON_X], stack[new, c.ON_Y] = mx, my
    stack[new, c.FACE], stack[new, c.NEXT] = i, 0.0


@njit(error_model="numpy", forceinline=True)
def bearing(stack, level, x, y):
    """Return the bearing of departure at which an image sees a place."""
    vx, vy = x - stack[level, c.IMAGE_X], y - stack[level, c.IMAGE_Y]
    ax, ay = stack[level, c.AXIS_X], stack[level, c.AXIS_Y]
    return stack[level, c.SIGN] * math.atan2(ax * vy - ay * vx, ax * vx + ay * vy)


@njit(error_model="numpy", forceinline=True)
def in_window(stack, level, x, y):
    """Return whether an image sees a place through its window, if nothing is in the way."""
    vx, vy = x - stack[level, c.IMAGE_X], y - stack[level, c.IMAGE_Y]
    if stack[level, c.RIGHT_X] * vy - stack[level, c.RIGHT_Y] * vx < 0:
        return False
    if vx * stack[level, c.LEFT_Y] - vy * stack[level, c.LEFT_X] < 0:
        return False
    if level == 0:
        return True
    height = (x - stack[level, c.ON_X]) * stack[level, c.WINDOW_X]
    return height + (y - stack[level, c.ON_Y]) * stack[level, c.WINDOW_Y] > OFF_M


@njit(error_model="numpy", makes_arrays=False)
def seen_part(stack, level, ax, ay, ex, ey):
    """Return the shares of a face between which it lies in the window; (1, 0) if nowhere.

    The face goes from (ax, ay), seen from the image, along (ex, ey).
    """
    low, high = 0.0, 1.0
    for side in range(3):
        if side == 0:
            begin = stack[level, c.RIGHT_X] * ay - stack[level, c.RIGHT_Y] * ax
            change = stack[level, c.RIGHT_X] * ey - stack[level, c.RIGHT_Y] * ex
        elif side == 1:
            begin = ax * stack[level, c.LEFT_Y] - ay * stack[level, c.LEFT_X]
            change = ex * stack[level, c.LEFT_Y] - ey * stack[level, c.LEFT_X]
        elif level > 0:
            begin = (ax + stack[level, c.IMAGE_X] - stack[level, c.ON_X]) * stack[
                level, c.WINDOW_X
            ] - OFF_M
            begin += (ay + stack[level, c.IMAGE_Y] - stack[level, c.ON_Y]) * stack[
                level, c.WINDOW_Y
            ]
            change = ex * stack[level, c.WINDOW_X] + ey * stack[level, c.WINDOW_Y]
        else:
            break
        if begin < 0.0:
            if begin + change <= 0.0:
                return 1.0, 0.0
            low = max(low, -begin / change)
        elif begin + change < 0.0:
            high = min(high, -begin / change)
    return low, high


@njit(error_model="numpy", makes_arrays=False)
def length_of_ray(rays, x, y, dx, dy, reach):
    """Return the length at which a ray meets something, +inf if it does not."""
    segments, circles, grid, shape, cell_start, cell_face = rays
    return first_hit(segments, circles, grid, shape, cell_start, cell_face, 0, x, y, dx, dy, reach)[
        0
    ]


@njit(error_model="numpy", makes_arrays=False)
def blocked_at(rays, stack, level, x, y):
    """Return (leg, face that blocks it) of the path to a place over an image's mirrors.

    (-1, -1) if it is free. Legs are numbered from the transducer.
    """
    segments, circles, grid, shape, cell_start, cell_face = rays
    for leg in range(level, -1, -1):
        ix, iy = stack[leg, c.IMAGE_X], stack[leg, c.IMAGE_Y]
        px, py = ix, iy
        dx, dy = x - px, y - py
        if leg > 0:
            nx, ny = stack[leg, c.WINDOW_X], stack[leg, c.WINDOW_Y]
            behind = (ix - stack[leg, c.ON_X]) * nx + (iy - stack[leg, c.ON_Y]) * ny
            before = (x - stack[leg, c.ON_X]) * nx + (y - stack[leg, c.ON_Y]) * ny
            share = behind / (behind - before)
            px, py = ix + share * dx, iy + share * dy
            dx, dy = x - px - OFF_M * nx, y - py - OFF_M * ny
        length = math.sqrt(dx * dx + dy * dy)
        if length > _SHORT_M:
            _, face = first_hit(
                segments, circles, grid, shape, cell_start, cell_face, 0, x - dx, y - dy,
                dx / length, dy / length, length - _SHORT_M,
            )  # fmt: skip
            if face >= 0:
                return leg, face
        x, y = px, py
    return -1, -1


@njit(error_model="numpy", makes_arrays=False)
def is_leg_free(rays, x, y, to_x, to_y):
    """Return whether nothing stands between two places."""
    dx, dy = to_x - x, to_y - y
    length = math.sqrt(dx * dx + dy * dy)
    if length <= _SHORT_M:
        return True
    return math.isinf(length_of_ray(rays, x, y, dx / length, dy / length, length - _SHORT_M))


@njit(error_model="numpy", makes_arrays=False)
def next_image(
    faces, before, is_listed, rays, acoustics, stack, level, own_m, others_least_m, others_m,
    others_db,
):  # fmt: skip
    """Set the next image over a mirror that an image sees, one level up; return whether there is.

    Mirrors matter if echoes from behind them may be detected from up to `own_m` away, or paths of
    `others_least_m` to twice `others_m` by other sonars, of which none is more sensitive than
    `others_db`.
    """
    mirror = int(stack[level, c.FACE])
    listed = level > 0 and is_listed
    first, last = 0, len(faces)
    if listed:
        first, last = int(faces[mirror, c.FIRST]), int(faces[mirror, c.LAST])
    ix, iy = stack[level, c.IMAGE_X], stack[level, c.IMAGE_Y]
    for k in range(first + int(stack[level, c.NEXT]), last):
        i = int(before[k]) if listed else k
        if i >= len(faces):
            break
        ax, ay = faces[i, c.X0] - ix, faces[i, c.Y0] - iy
        height = -(ax * faces[i, c.NORMAL_X] + ay * faces[i, c.NORMAL_Y])
        half_m = abs(height)
        if faces[i, c.OUTWARD] * height < 0 or half_m < EDGE_ON_M or i == mirror:
            continue
        if half_m >= own_m and half_m >= others_m:
            continue
        ex, ey = faces[i, c.X1] - faces[i, c.X0], faces[i, c.Y1] - faces[i, c.Y0]
        low, high = seen_part(stack, level, ax, ay, ex, ey)
        if low >= high:
            continue
        share = min(max(-(ax * ex + ay * ey) / (ex * ex + ey * ey), low), high)
        nx, ny = ax + share * ex, ay + share * ey
        near_m = math.sqrt(nx * nx + ny * ny)
        if near_m >= own_m and near_m >= others_m:
            continue
        loss_db = stack[level, c.LOSS] + faces[i, c.MIRROR]
        px, py = ix + ax + low * ex, iy + ay + low * ey
        qx, qy = ix + ax + high * ex, iy + ay + high * ey
        one, other = bearing(stack, level, px, py), bearing(stack, level, qx, qy)
        sent_db = beam_bound_db(acoustics, min(one, other), max(one, other)) + loss_db
        own_db = loudest_echo_db(acoustics, 2 * near_m) + FOCUS_DB
        matters = near_m < own_m and own_db + 2 * sent_db > 0
        if not matters and near_m < others_m:
            least_m = max(2 * near_m, others_least_m)
            matters = loudest_other_db(acoustics, least_m) + FOCUS_DB + others_db + sent_db > 0
        # Without lists an image costs much: mirrors that cannot be seen are left out.
        if not matters or (not is_listed and _is_hidden(rays, stack, level, px, py, qx, qy)):
            continue
        stack[level, c.NEXT] = k - first + 1
        _push_image(stack, level, faces, i, loss_db, height, low, high)
        return True
    return False


@njit(error_model="numpy", makes_arrays=False)
def _is_hidden(rays, stack, level, px, py, qx, qy):
    """Return whether a straight face certainly hides another one, given by its ends.

    What meets the ways to both ends, on the same leg, hides all between; places between them only
    end the search early.
    """
    last_leg, last_face = -1, -1
    for k in range(_HIDDEN_PARTS + 1):
        # Not at the very ends, where the face's neighbours meet it.
        share = min(max(k / _HIDDEN_PARTS, 1e-6), 1 - 1e-6)
        leg, face = blocked_at(rays, stack, level, px + share * (qx - px), py + share * (qy - py))
        if leg < 0 or face >= len(rays[0]) or (k > 0 and (leg != last_leg or face != last_face)):
            return False
        last_leg, last_face = leg, face
    return True
