"""Compiled: a sonar's own echoes from an image, in the order in which they would be detected.

Row 0 of a table of echoes is the best so far: the first that the sonar detects. An echo that
comes later is left out by arithmetic; of those that come before it, the first with a free path
takes its place. Only where the sonar fires again while its sound lasts, later ones count, too.
"""

from __future__ import annotations

import math

from sim.sonar.physical.fresnel import FOCUS_DB
from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.paths import (
    EDGE_ON_M,
    OFF_M,
    bearing,
    blocked_at,
    in_window,
    is_leg_free,
)
from sim.sonar.physical.images.room import FLUSH, RIGHT_ANGLE
from sim.sonar.physical.images.shares import corner_share, face_share, mirrors_share
from sim.sonar.physical.levels import (
    ABOUT_DB,
    ABOUT_FROM_M,
    about_own_db,
    amplitude,
    beam_db,
    mirror_echo_db,
    power_db,
    tvg_db,
)
from sim.sonar.physical.turning import edge_share_db, pillar_share_db
from sonarmap.kernels.jit import njit

__all__ = [
    "crossing_s",
    "edge_seen",
    "far_left_m",
    "find_of_faces",
    "find_of_points",
    "has_late",
    "is_free",
    "take_first",
]

# Feet may lie this share of a face's length beyond its ends, so that none is lost at a joint.
_OVERHANG = 1e-9


@njit(error_model="numpy", forceinline=True)
def crossing_s(acoustics, path_m, level_db):
    """Return when a sonar detects its own sound, seconds since it was sent; +inf if never."""
    arrival_s = path_m / acoustics.speed_mps
    if arrival_s <= 0 or arrival_s > acoustics.window_s or arrival_s > acoustics.life_s:
        return math.inf
    over_db = level_db + tvg_db(acoustics, arrival_s)
    if over_db <= 0:
        return math.inf
    at_s = arrival_s + acoustics.pulse_s * amplitude(-over_db)
    if at_s < acoustics.blanking_s:
        if arrival_s + acoustics.pulse_s < acoustics.blanking_s:
            return math.inf
        at_s = acoustics.blanking_s
    return at_s if at_s <= acoustics.window_s else math.inf


@njit(error_model="numpy", forceinline=True)
def far_left_m(acoustics, limits, echoes):
    """Return from how far away something may still come before the best echo, or be heard late."""
    if limits.is_late:
        return limits.reach_m
    return min(limits.reach_m, echoes[0, c.CROSSING] * acoustics.speed_mps / 2)


@njit(error_model="numpy", makes_arrays=False)
def find_of_faces(
    faces, stops, before, is_listed, acoustics, limits, x, y, axis, stack, level,
    echoes,
):  # fmt: skip
    """Find the echoes of flat faces that may come before the best so far; return how many rows.

    What rough places scatter is left out.
    """
    mirror = int(stack[level, c.FACE])
    listed = level > 0 and is_listed
    first, last = 0, len(faces)
    if listed:
        first, last = int(faces[mirror, c.FIRST]), int(faces[mirror, c.LAST])
    far_m = far_left_m(acoustics, limits, echoes)
    ix, iy = stack[level, c.IMAGE_X], stack[level, c.IMAGE_Y]
    right_x, right_y = stack[level, c.RIGHT_X], stack[level, c.RIGHT_Y]
    left_x, left_y = stack[level, c.LEFT_X], stack[level, c.LEFT_Y]
    out_x, out_y = stack[level, c.WINDOW_X], stack[level, c.WINDOW_Y]
    on_x, on_y = stack[level, c.ON_X] - ix, stack[level, c.ON_Y] - iy
    count = 1
    # Most things fail a test of a few products: they are made here, because a call costs more.
    for k in range(first, last):
        i = int(before[k]) if listed else k
        if i >= len(faces):
            break
        ax, ay = faces[i, c.X0] - ix, faces[i, c.Y0] - iy
        nx, ny = faces[i, c.NORMAL_X], faces[i, c.NORMAL_Y]
        height = -(ax * nx + ay * ny)
        if faces[i, c.OUTWARD] * height < 0 or i == mirror:
            continue
        half_m = abs(height)
        if half_m < EDGE_ON_M or (half_m >= far_m and level == 0):
            continue
        ex, ey = faces[i, c.X1] - faces[i, c.X0], faces[i, c.Y1] - faces[i, c.Y0]
        length_2 = ex * ex + ey * ey
        along = -(ax * ex + ay * ey)
        px, py = -height * nx, -height * ny
        if (
            half_m < far_m
            and -_OVERHANG * length_2 <= along <= (1 + _OVERHANG) * length_2
            and right_x * py - right_y * px >= 0
            and px * left_y - py * left_x >= 0
            and (level == 0 or (px - on_x) * out_x + (py - on_y) * out_y > OFF_M)
        ):
            level_db = mirror_echo_db(acoustics, 2 * half_m) + faces[i, c.MIRROR]
            sent_db = beam_db(acoustics, bearing(stack, level, ix + px, iy + py))
            level_db += 2 * (stack[level, c.LOSS] + sent_db)
            foot_m = along / math.sqrt(length_2)
            share = face_share(
                faces, stops, acoustics, i, height, foot_m, foot_m, 1.0, half_m, half_m
            )
            passed = mirrors_share(
                faces, stops, acoustics, stack, level, ix + px, iy + py, 2 * half_m
            )
            # What a rough face scatters at its foot adds to the mirror's.
            level_db += power_db(passed * passed * (share + amplitude(faces[i, c.FLOOR]) ** 2))
            count = _with_echo(
                acoustics, limits, echoes, count, 2 * half_m, level_db, faces[i, c.SURFACE], 0.0,
                level, ix + px, iy + py, 0.0,
            )  # fmt: skip
        if level == 0:
            continue
        # Back another way: from the face straight to the sonar.
        side = 1.0 if height > 0 else -1.0
        own_m = ((x - faces[i, c.X0]) * nx + (y - faces[i, c.Y0]) * ny) * side
        if own_m <= 0:
            continue
        ox, oy = ix + 2 * px - x, iy + 2 * py - y
        path_2 = ox * ox + oy * oy
        if path_2 >= 4 * far_m * far_m:
            continue
        # Of two faces at a right angle all comes from their corner.
        if abs(nx * out_x + ny * out_y) < RIGHT_ANGLE:
            continue
        back = own_m / (own_m + half_m)
        qx, qy = x + back * ox - ix, y + back * oy - iy
        at = (qx - ax) * ex + (qy - ay) * ey
        if (
            0 <= at <= length_2
            and right_x * qy - right_y * qx >= 0
            and qx * left_y - qy * left_x >= 0
            and (qx - on_x) * out_x + (qy - on_y) * out_y > OFF_M
        ):
            path_m = math.sqrt(path_2)
            level_db = mirror_echo_db(acoustics, path_m) + stack[level, c.LOSS]
            level_db += beam_db(acoustics, bearing(stack, level, ix + qx, iy + qy))
            level_db += beam_db(acoustics, math.atan2(oy, ox) - axis) + faces[i, c.MIRROR]
            # The transducer sends and receives.
            level_db += stack[0, c.LOSS]
            cos = min(1.0, own_m / max(back * path_m, 1e-12))
            length_m = math.sqrt(length_2)
            share = face_share(
                faces, stops, acoustics, i, height, along / length_m, at / length_m, cos,
                (1 - back) * path_m, back * path_m,
            )  # fmt: skip
            share *= mirrors_share(faces, stops, acoustics, stack, level, ix + qx, iy + qy, path_m)
            level_db += power_db(share)
            incidence_rad = math.acos(cos)
            count = _with_echo(
                acoustics, limits, echoes, count, path_m, level_db, faces[i, c.SURFACE],
                incidence_rad, level, ix + qx, iy + qy, 1.0,
            )  # fmt: skip
    return count


@njit(error_model="numpy", makes_arrays=False)
def find_of_points(
    faces, points, arms, stops, before, is_listed, acoustics, limits, stack, level, echoes
):
    """Find the echoes of pillars, corners and edges, as `find_of_faces`."""
    mirror = int(stack[level, c.FACE])
    listed = level > 0 and is_listed
    first, last = len(faces), len(faces) + len(points)
    if listed:
        first, last = int(faces[mirror, c.FIRST_POINT]), int(faces[mirror, c.LAST])
    far_m = far_left_m(acoustics, limits, echoes)
    edge_m = min(far_m, limits.edge_reach_m)
    ix, iy = stack[level, c.IMAGE_X], stack[level, c.IMAGE_Y]
    right_x, right_y = stack[level, c.RIGHT_X], stack[level, c.RIGHT_Y]
    left_x, left_y = stack[level, c.LEFT_X], stack[level, c.LEFT_Y]
    count = 1
    for k in range(first, last):
        j = (int(before[k]) if listed else k) - len(faces)
        px, py = points[j, c.POINT_X] - ix, points[j, c.POINT_Y] - iy
        radius_m = points[j, c.RADIUS]
        is_edge = radius_m == 0 and points[j, c.IS_CORNER] == 0
        most_m = edge_m if is_edge else far_m + radius_m
        if (
            px * px + py * py < most_m * most_m
            # The way to a pillar's foot is the way to its centre.
            and right_x * py - right_y * px >= 0
            and px * left_y - py * left_x >= 0
            and (
                limits.is_late or _may_be_heard(acoustics, stack, level, px, py, radius_m, is_edge)
            )
        ):
            count = _find_of_point(
                faces, points, arms, stops, acoustics, limits, stack, level, j, echoes, count
            )
    return count


@njit(error_model="numpy", forceinline=True)
def _may_be_heard(acoustics, stack, level, px, py, radius_m, is_edge):
    """Return whether what a place sends back may cross the threshold, by tables of levels.

    Most places do not, and the exact level costs more.
    """
    half_m = math.sqrt(px * px + py * py) - radius_m
    if 2 * half_m < ABOUT_FROM_M:
        return True
    ax, ay = stack[level, c.AXIS_X], stack[level, c.AXIS_Y]
    sent_db = beam_db(acoustics, math.atan2(ax * py - ay * px, ax * px + ay * py))
    most_db = about_own_db(acoustics, 2 * half_m) + 2 * (stack[level, c.LOSS] + sent_db)
    if is_edge:
        most_db += edge_share_db(acoustics.edge_db, half_m, half_m)
    return most_db + FOCUS_DB + ABOUT_DB > 0


@njit(error_model="numpy", forceinline=True)
def _find_of_point(faces, points, arms, stops, acoustics, limits, stack, level, k, echoes, count):
    """Find the echo of a pillar, a corner or an edge."""
    ix, iy = stack[level, c.IMAGE_X], stack[level, c.IMAGE_Y]
    px, py, radius_m = points[k, c.POINT_X], points[k, c.POINT_Y], points[k, c.RADIUS]
    vx, vy = px - ix, py - iy
    apart_m = math.sqrt(vx * vx + vy * vy)
    half_m = apart_m - radius_m
    if half_m < EDGE_ON_M:
        return count  # a sonar inside of a pillar is deaf to it
    if radius_m > 0:
        px, py = ix + vx * half_m / apart_m, iy + vy * half_m / apart_m
    if level > 0 and not in_window(stack, level, px, py):
        return count
    level_db = mirror_echo_db(acoustics, 2 * half_m)
    level_db += 2 * (stack[level, c.LOSS] + beam_db(acoustics, bearing(stack, level, px, py)))
    # Nothing round or pointed is louder than this, and many of them are too quiet.
    at_s = acoustics.window_s if limits.is_late else 2 * half_m / acoustics.speed_mps
    most_db = level_db + tvg_db(acoustics, at_s)
    if radius_m == 0 and points[k, c.IS_CORNER] == 0:
        most_db += edge_share_db(acoustics.edge_db, half_m, half_m)
    if most_db + FOCUS_DB <= 0:
        return count
    if level > 0:
        passed = mirrors_share(faces, stops, acoustics, stack, level, px, py, 2 * half_m)
        level_db += 2 * power_db(passed)
    if radius_m > 0:
        share_db = pillar_share_db(radius_m, 1.0, half_m, half_m)
        level_db += max(share_db, points[k, c.POINT_FLOOR]) + points[k, c.POINT_MIRROR]
        return _with_echo(
            acoustics, limits, echoes, count, 2 * half_m, level_db, points[k, c.POINT_SURFACE],
            0.0, level, px, py, 0.0,
        )  # fmt: skip
    face, share_db = _corner_or_edge(
        faces, arms, acoustics, int(points[k, c.FIRST_ARM]), int(points[k, c.LAST_ARM]), -vx, -vy,
        half_m,
    )  # fmt: skip
    if face < 0:
        return count
    cos = abs(vx * faces[face, c.NORMAL_X] + vy * faces[face, c.NORMAL_Y]) / half_m
    return _with_echo(
        acoustics, limits, echoes, count, 2 * half_m, level_db + share_db, faces[face, c.SURFACE],
        math.acos(min(1.0, cos)), level, px, py, 0.0,
    )  # fmt: skip


@njit(error_model="numpy", makes_arrays=False)
def _corner_or_edge(faces, arms, acoustics, first, last, dx, dy, half_m):
    """Return (face, level against a perfect mirror) of a vertex seen from a direction.

    A hollow corner answers if it is right-angled. Face -1 stands for nothing that answers.
    """
    right, right_rad, left, left_rad = _seen_arms(arms, first, last, dx, dy)
    if right < 0:
        return -1, 0.0
    if right_rad + left_rad >= math.pi:
        face = _edge_face(arms, right, right_rad, left, left_rad)
        edge_db = edge_share_db(acoustics.edge_db, half_m, half_m)
        return face, edge_db + faces[face, c.MIRROR]
    dot = arms[right, c.ARM_X] * arms[left, c.ARM_X] + arms[right, c.ARM_Y] * arms[left, c.ARM_Y]
    if abs(dot) >= RIGHT_ANGLE:
        return -1, 0.0
    one, other = int(arms[right, c.ARM_FACE]), int(arms[left, c.ARM_FACE])
    share = corner_share(arms, acoustics, right, right_rad, left, left_rad, half_m)
    mirrors_db = faces[one, c.MIRROR] + faces[other, c.MIRROR]
    return min(one, other), mirrors_db + power_db(share)


@njit(error_model="numpy", makes_arrays=False)
def edge_seen(faces, arms, first, last, dx, dy):
    """Return (face, level of its mirror) of a vertex that is an edge from a direction, else -1."""
    right, right_rad, left, left_rad = _seen_arms(arms, first, last, dx, dy)
    if right < 0 or right_rad + left_rad < math.pi:
        return -1, 0.0
    face = _edge_face(arms, right, right_rad, left, left_rad)
    return face, faces[face, c.MIRROR]


@njit(error_model="numpy", makes_arrays=False)
def _seen_arms(arms, first, last, dx, dy):
    """Return the two arms of a vertex between which a direction lies, and their angles to it.

    Less than a straight angle between them makes a hollow corner, more an edge; a straight one,
    and no arm at all, -1.
    """
    right, left = -1, -1
    right_rad, left_rad = math.inf, math.inf
    for k in range(first, last):
        ax, ay = arms[k, c.ARM_X], arms[k, c.ARM_Y]
        turn = math.atan2(ax * dy - ay * dx, ax * dx + ay * dy)
        back = turn if turn >= 0 else turn + 2 * math.pi
        if back < right_rad:
            right, right_rad = k, back
        forth = -turn if turn <= 0 else 2 * math.pi - turn
        if forth < left_rad:
            left, left_rad = k, forth
    if right < 0:
        return -1, 0.0, -1, 0.0
    dot = arms[right, c.ARM_X] * arms[left, c.ARM_X] + arms[right, c.ARM_Y] * arms[left, c.ARM_Y]
    cross = arms[right, c.ARM_X] * arms[left, c.ARM_Y] - arms[right, c.ARM_Y] * arms[left, c.ARM_X]
    if dot < 0 and abs(cross) < FLUSH:
        return -1, 0.0, -1, 0.0
    return right, right_rad, left, left_rad


@njit(error_model="numpy", makes_arrays=False)
def _edge_face(arms, right, right_rad, left, left_rad):
    """Return the face of an edge: both of its faces are seen, the first of them counts, or one."""
    one, other = int(arms[right, c.ARM_FACE]), int(arms[left, c.ARM_FACE])
    if right_rad >= math.pi:
        return other
    if left_rad >= math.pi:
        return one
    return min(one, other)


@njit(error_model="numpy", makes_arrays=False, forceinline=True)
def has_late(limits, path_m):
    """Return whether a path is so long that the sonar hears it only after its next firing."""
    return limits.is_late and limits.least_late_path_m <= path_m <= 2 * limits.reach_m


@njit(error_model="numpy", forceinline=True)
def _with_echo(
    acoustics, limits, echoes, count, path_m, level_db, surface, incidence_rad, bounces, x, y,
    is_straight,
):  # fmt: skip
    """Add an echo that may come before the best, or so late that the next firing hears it."""
    at_s = crossing_s(acoustics, path_m, level_db)
    if at_s >= echoes[0, c.CROSSING]:
        if not has_late(limits, path_m) or (level_db + tvg_db(acoustics, acoustics.window_s) <= 0):
            return count
        at_s = math.inf
    echoes[count, c.CROSSING], echoes[count, c.PATH], echoes[count, c.LEVEL] = (
        at_s,
        path_m,
        level_db,
    )
    echoes[count, c.ECHO_SURFACE], echoes[count, c.INCIDENCE] = surface, incidence_rad
    echoes[count, c.BOUNCES], echoes[count, c.IS_STRAIGHT] = bounces, is_straight
    echoes[count, c.AT_X], echoes[count, c.AT_Y] = x, y
    return count + 1


@njit(error_model="numpy", makes_arrays=False)
def take_first(rays, stack, level, x, y, echoes, count):
    """Let the first of the echoes whose path is free be the best; return how many are left."""
    while True:
        first, first_s = 0, echoes[0, c.CROSSING]
        for k in range(1, count):
            if echoes[k, c.CROSSING] < first_s:
                first, first_s = k, echoes[k, c.CROSSING]
        if first == 0:
            return count
        if is_free(rays, stack, level, x, y, echoes, first):
            for column in range(c.ECHO_COLUMNS):
                echoes[0, column] = echoes[first, column]
        count -= 1
        for column in range(c.ECHO_COLUMNS):
            echoes[first, column] = echoes[count, column]


@njit(error_model="numpy", makes_arrays=False)
def is_free(rays, stack, level, x, y, echoes, k):
    """Return whether an echo's path is free, there and back to the sonar at (x, y)."""
    at_x, at_y = echoes[k, c.AT_X], echoes[k, c.AT_Y]
    if blocked_at(rays, stack, level, at_x, at_y)[0] >= 0:
        return False
    return echoes[k, c.IS_STRAIGHT] == 0 or is_leg_free(rays, x, y, at_x, at_y)
