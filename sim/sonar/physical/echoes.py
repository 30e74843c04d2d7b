"""Compiled: the sounds that faces send back, and whether their paths are free."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical import columns as t
from sim.sonar.physical.levels import (
    beam_bound_db,
    beam_db,
    loudest_echo_db,
    mirror_echo_db,
    tvg_db,
)
from sim.sonar.physical.tracing import OFF_SURFACE_M, are_square, bearing_to, distance_to
from sonarmap.kernels.jit import njit

__all__ = ["Found", "confirmed", "find_sounds"]

# A ray that shall see a point sees it if its length agrees so well, metres.
_SAME_LENGTH_M = 1e-3
# Rays of checks go so much farther than they need to, metres.
_BEYOND_M = 0.1
# Step of the search along a scattering face, radians.
_SCATTER_STEP_RAD = math.radians(0.1)


class Found(NamedTuple):
    """Sounds, rays that check whether their paths are free, and how many there are of both."""

    sounds: NDArray[np.float64]
    checks: NDArray[np.float64]
    counts: NDArray[np.int64]


@njit()
def find_sounds(tracing, sent_s, monostatic, surfaces, limits, acoustics):
    """Return (sounds, checks): the sounds of the traced faces that may be detected.

    Parameters
    ----------
    tracing : Tracing
        That asks for no more rays.
    sent_s : float
        When its sonars fired.
    monostatic : bool
        Whether each sonar receives its own sound only.
    surfaces, limits, acoustics
        See `sim.sonar.physical.tracing.advance`.
    """
    faces, links = tracing.faces, tracing.links
    listeners = 1 if monostatic else tracing.axis_rad.size
    most = len(faces) * (2 + listeners) + len(tracing.corners) + len(tracing.edges)
    most += len(tracing.ends)
    found = Found(
        np.empty((most, t.SOUND_COLUMNS)),
        np.empty((most * (limits.max_bounces + 2), t.CHECK_COLUMNS)),
        np.zeros(2, np.int64),
    )
    for p in range(len(faces)):
        if surfaces[links[p, t.LINK_SURFACE], t.SURFACE_RADIUS] > 0:
            _add_pillar(found, tracing, p, surfaces, limits, acoustics)
            continue
        half_m, foot = _foot(faces[p])
        _add_mirror(found, tracing, p, half_m, foot, surfaces, limits, acoustics)
        _add_scatter(found, tracing, p, half_m, foot, surfaces, limits, acoustics)
        _add_bistatic(found, tracing, p, half_m, monostatic, surfaces, limits, acoustics)
    for corner in tracing.corners:
        p = int(corner[t.CORNER_FACE])
        level = surfaces[links[int(corner[t.CORNER_OTHER]), t.LINK_SURFACE], t.SURFACE_MIRROR]
        x, y = corner[t.CORNER_X], corner[t.CORNER_Y]
        _add_point(found, tracing, p, x, y, level, surfaces, limits, acoustics)
    for edge in tracing.edges:
        p, x, y = int(edge[t.EDGE_FACE]), edge[t.EDGE_X], edge[t.EDGE_Y]
        _add_edge(found, tracing, p, x, y, surfaces, limits, acoustics)
    for end in tracing.ends:
        p = int(end[t.END_FACE])
        # A pillar has no edge: its outline is where rays graze it.
        if surfaces[links[p, t.LINK_SURFACE], t.SURFACE_RADIUS] == 0:
            sonar = links[p, t.LINK_SONAR]
            angle = tracing.axis_rad[sonar] + end[t.END_INSIDE]
            x = tracing.sensor_xy_m[sonar, 0] + end[t.END_LENGTH] * math.cos(angle)
            y = tracing.sensor_xy_m[sonar, 1] + end[t.END_LENGTH] * math.sin(angle)
            _add_edge(found, tracing, p, x, y, surfaces, limits, acoustics)
    sounds = found.sounds[: found.counts[0]]
    sounds[:, t.SOUND_SENT] = sent_s
    return sounds, found.checks[: found.counts[1]]


@njit()
def confirmed(sounds, checks, leg_m):
    """Return the sounds all of whose checks met something where they must.

    Parameters
    ----------
    sounds, checks : ndarray
        See `find_sounds`.
    leg_m : ndarray
        Where the rays of the checks met something.
    """
    free = np.ones(len(sounds), np.bool_)
    for i in range(len(checks)):
        if not abs(leg_m[i] - checks[i, t.CHECK_LENGTH]) < _SAME_LENGTH_M:
            free[int(checks[i, t.CHECK_SOUND])] = False
    return sounds[free]


@njit()
def _add(found, tracing, p, listener, path_m, level_db, incidence_rad):
    sound = found.sounds[found.counts[0]]
    sound[t.SOUND_SOURCE], sound[t.SOUND_LISTENER] = tracing.links[p, t.LINK_SONAR], listener
    sound[t.SOUND_PATH], sound[t.SOUND_LEVEL] = path_m, level_db
    sound[t.SOUND_SURFACE], sound[t.SOUND_INCIDENCE] = (
        tracing.links[p, t.LINK_SURFACE],
        incidence_rad,
    )
    sound[t.SOUND_BOUNCES] = tracing.links[p, t.LINK_MIRRORS]
    found.counts[0] += 1


@njit()
def _check(found, x, y, dx, dy, length_m):
    """Ask for a ray that belongs to the next sound to be added."""
    check = found.checks[found.counts[1]]
    check[t.CHECK_X], check[t.CHECK_Y], check[t.CHECK_DX], check[t.CHECK_DY] = x, y, dx, dy
    check[t.CHECK_REACH], check[t.CHECK_LENGTH] = length_m + _BEYOND_M, length_m
    check[t.CHECK_SOUND] = found.counts[0]
    found.counts[1] += 1


@njit()
def _check_unseen(found, tracing, p, theta, path_m):
    """Ask for the rays that go out at a bearing, over the mirrors of a face, so far in all.

    Between the limits of the face its neighbouring rays have seen the path already.
    """
    if tracing.faces[p, t.FACE_LOW] <= theta <= tracing.faces[p, t.FACE_HIGH]:
        return
    mirrors = tracing.links[p, t.LINK_MIRRORS]
    over = np.empty(mirrors, np.int64)
    for k in range(mirrors - 1, -1, -1):
        p = over[k] = tracing.links[p, t.LINK_MIRROR]
    sonar = tracing.links[p, t.LINK_SONAR]
    x, y = tracing.sensor_xy_m[sonar]
    angle = tracing.axis_rad[sonar] + theta
    dx, dy = math.cos(angle), math.sin(angle)
    for k in range(mirrors):
        mirror = tracing.faces[over[k]]
        nx, ny = mirror[t.FACE_NX], mirror[t.FACE_NY]
        along = dx * nx + dy * ny
        # A path that grazes its mirror has none.
        leg_m = ((mirror[t.FACE_X] - x) * nx + (mirror[t.FACE_Y] - y) * ny) / min(along, -1e-9)
        leg_m = min(max(leg_m, 0.0), path_m)
        _check(found, x, y, dx, dy, leg_m)
        x, y = x + leg_m * dx + OFF_SURFACE_M * nx, y + leg_m * dy + OFF_SURFACE_M * ny
        dx, dy = dx - 2 * along * nx, dy - 2 * along * ny
        path_m -= leg_m
    _check(found, x, y, dx, dy, path_m)


@njit()
def _foot(face):
    """Return distance and bearing of the foot of the perpendicular on a flat face."""
    nx, ny = face[t.FACE_NX], face[t.FACE_NY]
    half_m = (face[t.FACE_IX] - face[t.FACE_X]) * nx + (face[t.FACE_IY] - face[t.FACE_Y]) * ny
    return half_m, bearing_to(face, face[t.FACE_IX] - nx, face[t.FACE_IY] - ny)


@njit()
def _is_detectable(acoustics, limits, half_m, level_db):
    """Return whether a sonar detects an echo of its own from so far away."""
    return (
        half_m <= limits.reach_m
        and level_db + tvg_db(acoustics, 2 * half_m / acoustics.speed_mps) > 0
    )


@njit()
def _echo_db(tracing, p, half_m, theta, surfaces, acoustics):
    """Return the level of what a mirror in the place of a face would send back."""
    loss_db = 2 * tracing.faces[p, t.FACE_LOSS]
    loss_db += surfaces[tracing.links[p, t.LINK_SURFACE], t.SURFACE_MIRROR]
    return mirror_echo_db(acoustics, 2 * half_m) + 2 * beam_db(acoustics, theta) + loss_db


@njit()
def _add_pillar(found, tracing, p, surfaces, limits, acoustics):
    """Add a pillar's echo: the foot of the perpendicular lies on the line to its centre."""
    face, like = tracing.faces[p], surfaces[tracing.links[p, t.LINK_SURFACE]]
    radius_m = like[t.SURFACE_RADIUS]
    x, y = face[t.FACE_X] - radius_m * face[t.FACE_NX], face[t.FACE_Y] - radius_m * face[t.FACE_NY]
    half_m, theta = distance_to(face, x, y) - radius_m, bearing_to(face, x, y)
    share_db = 10 * math.log10(radius_m / (radius_m + max(half_m, 0.0)))
    level_db = _echo_db(tracing, p, half_m, theta, surfaces, acoustics)
    level_db += max(share_db, like[t.SURFACE_FLOOR])
    if _is_detectable(acoustics, limits, half_m, level_db):
        _check_unseen(found, tracing, p, theta, half_m)
        _add(found, tracing, p, tracing.links[p, t.LINK_SONAR], 2 * half_m, level_db, 0.0)


@njit()
def _add_mirror(found, tracing, p, half_m, foot, surfaces, limits, acoustics):
    """Add the mirror's echo of a flat face: it comes from the foot of the perpendicular."""
    face, like = tracing.faces[p], surfaces[tracing.links[p, t.LINK_SURFACE]]
    if not face[t.FACE_LOW] - limits.margin_rad < foot < face[t.FACE_HIGH] + limits.margin_rad:
        return
    plane_db = _echo_db(tracing, p, half_m, foot, surfaces, acoustics)
    level_db = 10 * math.log10(
        10 ** (plane_db / 10) + 10 ** ((plane_db + like[t.SURFACE_FLOOR]) / 10)
    )
    if _is_detectable(acoustics, limits, half_m, level_db):
        _check_unseen(found, tracing, p, foot, half_m)
        _add(found, tracing, p, tracing.links[p, t.LINK_SONAR], 2 * half_m, level_db, 0.0)


@njit()
def _add_scatter(found, tracing, p, half_m, foot, surfaces, limits, acoustics):
    """Add what a flat face scatters: the first moment at which some place is loud enough."""
    face, like = tracing.faces[p], surfaces[tracing.links[p, t.LINK_SURFACE]]
    loss_db = 2 * face[t.FACE_LOSS] + like[t.SURFACE_MIRROR] + like[t.SURFACE_FLOOR]
    low, high = face[t.FACE_LOW], face[t.FACE_HIGH]
    nearest = min(max(foot, low), high)
    # A bound that is quickly found spares most faces and places the rest.
    most_db = _best_between_db(face, half_m, foot, nearest, limits, acoustics) + loss_db
    if most_db + 2 * beam_bound_db(acoustics, low, high) <= 0:
        return
    pulse_m = acoustics.pulse_s * acoustics.speed_mps / 2
    first_m, place, loudness_db = math.inf, 0.0, 0.0
    steps = max(1, math.ceil((high - low) / _SCATTER_STEP_RAD))
    for k in range(-1, steps + 1):
        theta = nearest if k < 0 else low + (high - low) * k / steps
        sent_db = beam_db(acoustics, theta)
        if most_db + 2 * sent_db <= 0:
            continue
        cos = math.cos(theta - foot)
        if cos < 1e-3:
            continue
        r = half_m / cos
        if r > limits.reach_m or r >= first_m:
            continue
        level_db = mirror_echo_db(acoustics, 2 * r) + 2 * sent_db + loss_db
        level_db += 20 * math.log10(cos)
        over_db = level_db + tvg_db(acoustics, 2 * r / acoustics.speed_mps)
        if over_db > 0:
            crossing_m = r + pulse_m * 10 ** (-over_db / 20)
            if crossing_m < first_m:
                first_m, place, loudness_db = crossing_m, theta, level_db
    if first_m < math.inf:
        path_m = 2 * half_m / math.cos(place - foot)
        own = tracing.links[p, t.LINK_SONAR]
        _add(found, tracing, p, own, path_m, loudness_db, abs(place - foot))


@njit()
def _best_between_db(face, half_m, foot, nearest, limits, acoustics):
    """Return a level that no echo from within the limits of a flat face exceeds."""
    near_m = half_m / max(math.cos(nearest - foot), 1e-3)
    least_cos = min(math.cos(face[t.FACE_LOW] - foot), math.cos(face[t.FACE_HIGH] - foot))
    far_m = min(half_m / max(least_cos, 1e-3), limits.reach_m)
    if near_m > limits.reach_m:
        return -math.inf
    # In dry air the time-varied gain more than makes up for distance; but it is loudest at an end.
    return max(loudest_echo_db(acoustics, 2 * near_m), loudest_echo_db(acoustics, 2 * far_m))


@njit()
def _add_bistatic(found, tracing, p, half_m, monostatic, surfaces, limits, acoustics):
    """Add the paths over a flat face that end elsewhere than they began."""
    face, own = tracing.faces[p], tracing.links[p, t.LINK_SONAR]
    nx, ny = face[t.FACE_NX], face[t.FACE_NY]
    # Of two faces at a right angle the corner is added already.
    is_added = tracing.links[p, t.LINK_MIRRORS] == 0 or are_square(
        face[t.FACE_MX], face[t.FACE_MY], nx, ny
    )
    if half_m <= 0 or (monostatic and is_added):
        return
    # The wedge in which the face may turn sound; most paths fail it.
    middle = (face[t.FACE_LOW] + face[t.FACE_HIGH]) / 2 - face[t.FACE_THETA]
    middle = face[t.FACE_ALONG] + face[t.FACE_SIGN] * middle
    wedge_x, wedge_y = math.cos(middle), math.sin(middle)
    least_cos = math.cos((face[t.FACE_HIGH] - face[t.FACE_LOW]) / 2 + limits.margin_rad) - 1e-9
    for sonar in range(own if monostatic else 0, own + 1 if monostatic else tracing.axis_rad.size):
        if sonar == own and is_added:
            continue
        x, y = tracing.sensor_xy_m[sonar]
        height_m = (x - face[t.FACE_X]) * nx + (y - face[t.FACE_Y]) * ny
        if height_m <= 0:
            continue
        # The listener sees the image's image by way of the point where the face turns the sound.
        ox, oy = face[t.FACE_IX] - 2 * half_m * nx - x, face[t.FACE_IY] - 2 * half_m * ny - y
        share = height_m / (height_m + half_m)
        tx, ty = x + share * ox - face[t.FACE_IX], y + share * oy - face[t.FACE_IY]
        if tx * wedge_x + ty * wedge_y >= least_cos * math.sqrt(tx * tx + ty * ty):
            _add_path(found, tracing, p, sonar, ox, oy, share, surfaces, limits, acoustics)


@njit()
def _add_path(found, tracing, p, sonar, ox, oy, share, surfaces, limits, acoustics):
    """Add the path over a face to a sonar that sees its image at an offset.

    The face turns the sound after a share of that offset.
    """
    face, links = tracing.faces[p], tracing.links[p]
    path_m = math.hypot(ox, oy)
    is_own = sonar == links[t.LINK_SONAR]
    if path_m > 2 * limits.reach_m or (path_m < limits.least_cross_path_m and not is_own):
        return
    x, y = tracing.sensor_xy_m[sonar]
    qx, qy = x + share * ox, y + share * oy
    theta = bearing_to(face, qx, qy)
    if not face[t.FACE_LOW] - limits.margin_rad < theta < face[t.FACE_HIGH] + limits.margin_rad:
        return
    arrival = math.atan2(oy, ox) - tracing.axis_rad[sonar]
    # Each mirror is passed once on such a path.
    level_db = (
        mirror_echo_db(acoustics, path_m) + beam_db(acoustics, theta) + beam_db(acoustics, arrival)
    )
    level_db += face[t.FACE_LOSS] + surfaces[links[t.LINK_SURFACE], t.SURFACE_MIRROR]
    latest_s = min(path_m / acoustics.speed_mps + acoustics.head_start_s, acoustics.window_s)
    if level_db + tvg_db(acoustics, latest_s) <= 0:
        return
    _check_unseen(found, tracing, p, theta, distance_to(face, qx, qy))
    back_m = share * path_m
    _check(found, x, y, ox / path_m, oy / path_m, back_m)
    cos = ((x - qx) * face[t.FACE_NX] + (y - qy) * face[t.FACE_NY]) / back_m
    _add(found, tracing, p, sonar, path_m, level_db, math.acos(min(1.0, cos)))


@njit()
def _add_edge(found, tracing, p, x, y, surfaces, limits, acoustics):
    """Add the echo of an edge, which falls faster than that of a plane."""
    half_m = distance_to(tracing.faces[p], x, y)
    level_db = acoustics.edge_db - 20 * math.log10(max(half_m, 0.01))
    _add_point(found, tracing, p, x, y, level_db, surfaces, limits, acoustics)


@njit()
def _add_point(found, tracing, p, x, y, share_db, surfaces, limits, acoustics):
    """Add the echo of a corner or an edge, of so much level against a mirror.

    It lies between two neighbouring rays, so its path needs no check.
    """
    face = tracing.faces[p]
    half_m, theta = distance_to(face, x, y), bearing_to(face, x, y)
    level_db = _echo_db(tracing, p, half_m, theta, surfaces, acoustics) + share_db
    if not _is_detectable(acoustics, limits, half_m, level_db):
        return
    cos = (face[t.FACE_IX] - x) * face[t.FACE_NX] + (face[t.FACE_IY] - y) * face[t.FACE_NY]
    incidence_rad = math.acos(min(1.0, max(0.0, cos / max(half_m, 1e-9))))
    _add(found, tracing, p, tracing.links[p, t.LINK_SONAR], 2 * half_m, level_db, incidence_rad)
