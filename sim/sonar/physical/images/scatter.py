"""Compiled: what the rough places of faces scatter back to a sonar from an image.

It is detected from the place whose sound crosses the threshold first, among those that are seen.
Where something hides the first place, its shadow on the face is left out, and the next is tried.
"""

from __future__ import annotations

import math

import numpy as np

from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.echoes import crossing_s
from sim.sonar.physical.images.paths import EDGE_ON_M, bearing, blocked_at, seen_part
from sim.sonar.physical.levels import (
    ABOUT_DB,
    ABOUT_FROM_M,
    about_own_db,
    beam_db,
    lost_reach_m,
    loudest_echo_db,
    mirror_echo_db,
    widest_rad,
)
from sonarmap.kernels.jit import njit

__all__ = ["find_scatter"]

# Places of a rough face are tried at such bearings, radians. Where all are below the threshold, but
# by less than so many decibels, the loudest between its neighbours is looked for in so many steps.
# Between two such places a beam's lobe rises by less. At last the best is moved by halves of the
# step, so often at most: to 0.0005 degrees, for near the threshold a range changes by centimetres a
# degree; or until what lies beside it comes as early to so much, 5 micrometres.
_COARSE_RAD, _NEARLY_DB, _RISES, _HALVES = math.radians(0.5), 0.5, 10, 10
_SAME_S = 3e-8
_GOLDEN = (math.sqrt(5) - 1) / 2
_LEAST_COS = 1e-3
# So many separate parts of a rough face, and so many places hidden by something, are looked at.
_MOST_PARTS, _MOST_HIDDEN = 16, 40


@njit(error_model="numpy")
def find_scatter(faces, before, is_listed, rays, acoustics, limits, stack, level, echoes):
    """Let the best echo be what a rough place scatters, where that comes first."""
    mirror = int(stack[level, c.FACE])
    listed = level > 0 and is_listed
    first, last = 0, len(faces)
    if listed:
        first, last = int(faces[mirror, c.FIRST]), int(faces[mirror, c.LAST])
    ix, iy = stack[level, c.IMAGE_X], stack[level, c.IMAGE_Y]
    for k in range(first, last):
        i = int(before[k]) if listed else k
        if i >= len(faces):
            break
        ax, ay = faces[i, c.X0] - ix, faces[i, c.Y0] - iy
        height = -(ax * faces[i, c.NORMAL_X] + ay * faces[i, c.NORMAL_Y])
        half_m = abs(height)
        far_m = min(echoes[0, c.CROSSING] * acoustics.speed_mps / 2, limits.reach_m)
        if faces[i, c.OUTWARD] * height < 0 or half_m < EDGE_ON_M or half_m >= far_m or i == mirror:
            continue
        loss_db = 2 * stack[level, c.LOSS] + faces[i, c.MIRROR] + faces[i, c.FLOOR]
        if half_m >= lost_reach_m(acoustics, limits.spare_db - loss_db):
            continue
        ex, ey = faces[i, c.X1] - faces[i, c.X0], faces[i, c.Y1] - faces[i, c.Y0]
        low, high = seen_part(stack, level, ax, ay, ex, ey)
        if low >= high:
            continue
        share = min(max(-(ax * ex + ay * ey) / (ex * ex + ey * ey), low), high)
        nx, ny = ax + share * ex, ay + share * ey
        near_m = math.sqrt(nx * nx + ny * ny)
        if near_m >= far_m:
            continue
        # In dry air the time-varied gain more than makes up for distance; but it is loudest at an
        # end of what may still come first.
        most_db = loss_db + max(
            loudest_echo_db(acoustics, 2 * near_m), loudest_echo_db(acoustics, 2 * far_m)
        )
        if most_db <= 0:
            continue
        one = bearing(stack, level, ix + ax + low * ex, iy + ay + low * ey)
        other = bearing(stack, level, ix + ax + high * ex, iy + ay + high * ey)
        widest = widest_rad(acoustics, most_db)
        one, other = max(min(one, other), -widest), min(max(one, other), widest)
        if one < other:
            side = half_m / height
            foot = bearing(
                stack, level, ix - faces[i, c.NORMAL_X] * side, iy - faces[i, c.NORMAL_Y] * side
            )
            _scatter(
                faces, rays, acoustics, stack, level, i, half_m, foot, one, other, loss_db, most_db,
                echoes,
            )  # fmt: skip


@njit(error_model="numpy", forceinline=True)
def _scatter_at(acoustics, half_m, foot, loss_db, theta):
    """Return (when what the place at a bearing scatters is detected, path, level)."""
    cos = math.cos(theta - foot)
    if cos < _LEAST_COS:
        return math.inf, math.inf, -math.inf
    path_m = 2 * half_m / cos
    level_db = mirror_echo_db(acoustics, path_m) + 2 * beam_db(acoustics, theta) + loss_db
    level_db += 20 * math.log10(cos)
    return crossing_s(acoustics, path_m, level_db), path_m, level_db


@njit(error_model="numpy", forceinline=True)
def _over_db(acoustics, half_m, foot, loss_db, theta):
    """Return the level over the threshold of what the place at a bearing scatters."""
    cos = math.cos(theta - foot)
    if cos < _LEAST_COS:
        return -math.inf
    over_db = loudest_echo_db(acoustics, 2 * half_m / cos) + loss_db
    return over_db + 2 * beam_db(acoustics, theta) + 20 * math.log10(cos)


@njit(error_model="numpy", makes_arrays=False)
def _first_place(acoustics, half_m, foot, loss_db, most_db, low, high, until_s):
    """Return (bearing, when) of the first sound from between two bearings, if before a time.

    On the axis nothing is louder than `most_db`.
    """
    place, first_s = math.nan, until_s
    loudest, loudest_db = math.nan, -_NEARLY_DB
    speed_mps = acoustics.speed_mps
    begin = math.ceil(low / _COARSE_RAD)
    end = math.floor(high / _COARSE_RAD)
    # The ends, the foot, and even steps, from the axis on: a mirrored room gives mirrored ones.
    for k in range(begin - 3, end + 1):
        theta = k * _COARSE_RAD
        if k < begin:
            theta = low if k == begin - 1 else high if k == begin - 2 else foot
            if not low <= theta <= high:
                continue
        # Most places are too quiet or too far: rough levels tell.
        sent_db = 2 * beam_db(acoustics, theta)
        if sent_db + most_db <= -_NEARLY_DB:
            continue
        cos = math.cos(theta - foot)
        if cos < _LEAST_COS or 2 * half_m >= first_s * speed_mps * cos:
            continue
        about_db = about_own_db(acoustics, 2 * half_m / cos) + sent_db + loss_db
        if 2 * half_m > ABOUT_FROM_M and about_db + ABOUT_DB <= -_NEARLY_DB:
            continue
        at_s = _scatter_at(acoustics, half_m, foot, loss_db, theta)[0]
        if at_s < first_s:
            place, first_s = theta, at_s
        elif first_s == until_s and at_s == math.inf:
            over_db = _over_db(acoustics, half_m, foot, loss_db, theta)
            if over_db > loudest_db:
                loudest, loudest_db = theta, over_db
    if first_s == until_s:
        if math.isnan(loudest):
            return place, first_s
        # Between two places just below the threshold one may lie above it.
        place = _loudest(
            acoustics, half_m, foot, loss_db,
            max(low, loudest - _COARSE_RAD), min(high, loudest + _COARSE_RAD),
        )  # fmt: skip
        at_s = _scatter_at(acoustics, half_m, foot, loss_db, place)[0]
        if at_s >= until_s:
            return math.nan, until_s
        first_s = at_s
    step = _COARSE_RAD
    for _ in range(_HALVES):
        step /= 2
        middle, bend_s = place, -2 * first_s
        for side in range(2):
            theta = middle - step if side == 0 else middle + step
            if low <= theta <= high:
                at_s = _scatter_at(acoustics, half_m, foot, loss_db, theta)[0]
                bend_s += at_s
                if at_s < first_s:
                    place, first_s = theta, at_s
            else:
                bend_s = math.inf
        # Between places so much alike no other is earlier by more.
        if place == middle and bend_s < _SAME_S:
            break
    return place, first_s


@njit(error_model="numpy", makes_arrays=False)
def _loudest(acoustics, half_m, foot, loss_db, low, high):
    """Return the bearing between two at which what is scattered is loudest: a golden section."""
    one, other = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    one_db = _over_db(acoustics, half_m, foot, loss_db, one)
    other_db = _over_db(acoustics, half_m, foot, loss_db, other)
    for _ in range(_RISES):
        if one_db > other_db:
            high, other, other_db = other, one, one_db
            one = high - _GOLDEN * (high - low)
            one_db = _over_db(acoustics, half_m, foot, loss_db, one)
        else:
            low, one, one_db = one, other, other_db
            other = low + _GOLDEN * (high - low)
            other_db = _over_db(acoustics, half_m, foot, loss_db, other)
    return (low + high) / 2


@njit(error_model="numpy")
def _scatter(
    faces, rays, acoustics, stack, level, face, half_m, foot, low, high, loss_db, most_db, echoes
):
    """Let the best be the first sound of a rough face's places that are seen, if it comes first."""
    parts = np.empty((_MOST_PARTS, 4))
    parts[0, 0], parts[0, 1] = low, high
    parts[0, 2], parts[0, 3] = _first_place(
        acoustics, half_m, foot, loss_db, most_db, low, high, echoes[0, c.CROSSING]
    )
    count = 1
    for _ in range(_MOST_HIDDEN):
        first, first_s = -1, echoes[0, c.CROSSING]
        for k in range(count):
            if parts[k, 3] < first_s:
                first, first_s = k, parts[k, 3]
        if first < 0:
            return
        theta = parts[first, 2]
        x, y = _place(faces, stack, level, face, half_m, theta)
        leg, blocker = blocked_at(rays, stack, level, x, y)
        if leg < 0:
            at_s, path_m, level_db = _scatter_at(acoustics, half_m, foot, loss_db, theta)
            echoes[0, c.CROSSING], echoes[0, c.PATH], echoes[0, c.LEVEL] = at_s, path_m, level_db
            echoes[0, c.ECHO_SURFACE] = faces[face, c.SURFACE]
            echoes[0, c.INCIDENCE], echoes[0, c.BOUNCES] = abs(theta - foot), level
            return
        # Nothing is seen of the part that lies behind what is in the way.
        right, left = _shadow(faces, rays[1], stack, level, leg, blocker, face)
        right, left = min(right, theta - 1e-7), max(left, theta + 1e-7)
        low, high = parts[first, 0], parts[first, 1]
        count -= 1
        parts[first] = parts[count]
        for side in range(2):
            begin, end = (low, right) if side == 0 else (left, high)
            if begin < end and count < _MOST_PARTS:
                parts[count, 0], parts[count, 1] = begin, end
                parts[count, 2], parts[count, 3] = _first_place(
                    acoustics, half_m, foot, loss_db, most_db, begin, end, echoes[0, c.CROSSING]
                )
                count += 1


@njit(error_model="numpy", makes_arrays=False)
def _place(faces, stack, level, face, half_m, theta):
    """Return the place of a face that an image sees at a bearing of departure."""
    turn = stack[level, c.SIGN] * theta
    cos, sin = math.cos(turn), math.sin(turn)
    dx = stack[level, c.AXIS_X] * cos - stack[level, c.AXIS_Y] * sin
    dy = stack[level, c.AXIS_Y] * cos + stack[level, c.AXIS_X] * sin
    across = abs(dx * faces[face, c.NORMAL_X] + dy * faces[face, c.NORMAL_Y])
    return (
        stack[level, c.IMAGE_X] + dx * half_m / across,
        stack[level, c.IMAGE_Y] + dy * half_m / across,
    )


@njit(error_model="numpy", makes_arrays=False)
def _shadow(faces, circles, stack, level, leg, blocker, face):
    """Return the bearings between which something in the way of a leg hides a face.

    It hides only by its part between the leg's mirrors: beyond the one, before the other.
    """
    ix, iy = stack[leg, c.IMAGE_X], stack[leg, c.IMAGE_Y]
    # The line at which the leg ends: the next mirror, or the face itself.
    goal = face if leg == level else int(stack[leg + 1, c.FACE])
    gx, gy = faces[goal, c.NORMAL_X], faces[goal, c.NORMAL_Y]
    side = (ix - faces[goal, c.X0]) * gx + (iy - faces[goal, c.Y0]) * gy
    if side < 0:
        gx, gy = -gx, -gy
    if blocker < len(faces):
        ax, ay = faces[blocker, c.X0], faces[blocker, c.Y0]
        ex, ey = faces[blocker, c.X1] - ax, faces[blocker, c.Y1] - ay
        low, high = 0.0, 1.0
        for k in range(2 if leg > 0 else 1):
            nx, ny = (gx, gy) if k == 0 else (stack[leg, c.WINDOW_X], stack[leg, c.WINDOW_Y])
            mx, my = faces[goal, c.X0], faces[goal, c.Y0]
            if k == 1:
                mx, my = stack[leg, c.ON_X], stack[leg, c.ON_Y]
            begin, change = (ax - mx) * nx + (ay - my) * ny, ex * nx + ey * ny
            if begin < 0 < begin + change:
                low = max(low, -begin / change)
            elif begin + change < 0 < begin:
                high = min(high, -begin / change)
        one = bearing(stack, leg, ax + low * ex, ay + low * ey)
        other = bearing(stack, leg, ax + high * ex, ay + high * ey)
        return min(one, other), max(one, other)
    k = blocker - len(faces)
    vx, vy, radius_m = circles[k, 0] - ix, circles[k, 1] - iy, circles[k, 2]
    apart_m = math.sqrt(vx * vx + vy * vy)
    middle = bearing(stack, leg, circles[k, 0], circles[k, 1])
    if apart_m <= radius_m:
        return middle - math.pi, middle + math.pi
    half = math.asin(radius_m / apart_m)
    one, other = middle - half, middle + half
    # Where it grazes the circle a way may have passed the goal already: then the two meet before.
    depth = (circles[k, 0] - faces[goal, c.X0]) * gx + (circles[k, 1] - faces[goal, c.Y0]) * gy
    if abs(depth) < radius_m:
        reach = math.sqrt(radius_m * radius_m - depth * depth)
        px, py = circles[k, 0] - depth * gx, circles[k, 1] - depth * gy
        touch_m = math.sqrt(apart_m * apart_m - radius_m * radius_m)
        for turn in range(2):
            sign = 1.0 if turn == 0 else -1.0
            qx, qy = px - sign * reach * gy, py + sign * reach * gx
            at = bearing(stack, leg, qx, qy)
            if math.hypot(qx - ix, qy - iy) < touch_m:
                if at < middle:
                    one = max(one, at)
                else:
                    other = min(other, at)
    return one, other
