"""Compiled: the sounds that faces send back, and whether their ways are free."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from sim.sonar.physical import columns as t
from sim.sonar.physical.levels import beam_db, best_db, gain_db, loudest_db, way_db
from sim.sonar.physical.tracing import OFF_SURFACE_M, are_square, bearing_to, distance_to

__all__ = ["Found", "confirmed", "find_sounds"]

# A ray that shall see a point sees it if its length agrees so well, metres.
_SAME_LENGTH_M = 1e-3
# Rays of checks go so much farther than they need to, metres.
_BEYOND_M = 0.1
# Step of the search along a scattering face, radians.
_SCATTER_STEP_RAD = math.radians(0.1)


class Found(NamedTuple):
    """Sounds, rays that check whether their ways are free, and how many there are of both."""

    sounds: NDArray[np.float64]
    checks: NDArray[np.float64]
    counts: NDArray[np.int64]


@njit(cache=True)
def find_sounds(survey, sent_s, alone, surfaces, rules, acoustics):
    """Return (sounds, checks): the sounds of a survey's faces that may be heard.

    Parameters
    ----------
    survey : Survey
        That asks for no more rays.
    sent_s : float
        When its sonars fired.
    alone : bool
        Whether each sonar hears itself only.
    surfaces, rules, acoustics
        See `sim.sonar.physical.tracing.advance`.
    """
    faces, links = survey.faces, survey.links
    listeners = 1 if alone else survey.axis_rad.size
    most = len(faces) * (2 + listeners) + len(survey.corners) + len(survey.edges)
    most += len(survey.ends)
    found = Found(
        np.empty((most, t.SOUND_COLUMNS)),
        np.empty((most * (rules.max_bounces + 2), t.CHECK_COLUMNS)),
        np.zeros(2, np.int64),
    )
    for p in range(len(faces)):
        if surfaces[links[p, t.TO_SURFACE], t.SURFACE_RADIUS] > 0:
            _add_pillar(found, survey, p, surfaces, rules, acoustics)
            continue
        half_m, foot = _foot(faces[p])
        _add_mirror(found, survey, p, half_m, foot, surfaces, rules, acoustics)
        _add_scatter(found, survey, p, half_m, foot, surfaces, rules, acoustics)
        _add_elsewhere(found, survey, p, half_m, alone, surfaces, rules, acoustics)
    for corner in survey.corners:
        p = int(corner[t.CORNER_FACE])
        level = surfaces[links[int(corner[t.CORNER_OTHER]), t.TO_SURFACE], t.SURFACE_MIRROR]
        x, y = corner[t.CORNER_X], corner[t.CORNER_Y]
        _add_point(found, survey, p, x, y, level, surfaces, rules, acoustics)
    for edge in survey.edges:
        p, x, y = int(edge[t.EDGE_FACE]), edge[t.EDGE_X], edge[t.EDGE_Y]
        _add_edge(found, survey, p, x, y, surfaces, rules, acoustics)
    for end in survey.ends:
        p = int(end[t.END_FACE])
        # A pillar has no edge: its outline is where rays graze it.
        if surfaces[links[p, t.TO_SURFACE], t.SURFACE_RADIUS] == 0:
            sonar = links[p, t.TO_SONAR]
            angle = survey.axis_rad[sonar] + end[t.END_INSIDE]
            x = survey.sensor_xy_m[sonar, 0] + end[t.END_LENGTH] * math.cos(angle)
            y = survey.sensor_xy_m[sonar, 1] + end[t.END_LENGTH] * math.sin(angle)
            _add_edge(found, survey, p, x, y, surfaces, rules, acoustics)
    sounds = found.sounds[: found.counts[0]]
    sounds[:, t.SOUND_SENT] = sent_s
    return sounds, found.checks[: found.counts[1]]


@njit(cache=True)
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


@njit(cache=True)
def _add(found, survey, p, listener, way_m, level_db, incidence_rad):
    sound = found.sounds[found.counts[0]]
    sound[t.SOUND_SOURCE], sound[t.SOUND_LISTENER] = survey.links[p, t.TO_SONAR], listener
    sound[t.SOUND_WAY], sound[t.SOUND_LEVEL] = way_m, level_db
    sound[t.SOUND_SURFACE], sound[t.SOUND_INCIDENCE] = survey.links[p, t.TO_SURFACE], incidence_rad
    sound[t.SOUND_BOUNCES] = survey.links[p, t.TO_MIRRORS]
    found.counts[0] += 1


@njit(cache=True)
def _check(found, x, y, dx, dy, length_m):
    """Ask for a ray that belongs to the next sound to be added."""
    check = found.checks[found.counts[1]]
    check[t.CHECK_X], check[t.CHECK_Y], check[t.CHECK_DX], check[t.CHECK_DY] = x, y, dx, dy
    check[t.CHECK_REACH], check[t.CHECK_LENGTH] = length_m + _BEYOND_M, length_m
    check[t.CHECK_SOUND] = found.counts[0]
    found.counts[1] += 1


@njit(cache=True)
def _check_unseen(found, survey, p, theta, way_m):
    """Ask for the rays that go out at a bearing, over the mirrors of a face, so far in all.

    Between the limits of the face its neighbouring rays have seen the way already.
    """
    if survey.faces[p, t.FACE_LOW] <= theta <= survey.faces[p, t.FACE_HIGH]:
        return
    mirrors = survey.links[p, t.TO_MIRRORS]
    over = np.empty(mirrors, np.int64)
    for k in range(mirrors - 1, -1, -1):
        p = over[k] = survey.links[p, t.TO_MIRROR]
    sonar = survey.links[p, t.TO_SONAR]
    x, y = survey.sensor_xy_m[sonar]
    angle = survey.axis_rad[sonar] + theta
    dx, dy = math.cos(angle), math.sin(angle)
    for k in range(mirrors):
        mirror = survey.faces[over[k]]
        nx, ny = mirror[t.FACE_NX], mirror[t.FACE_NY]
        along = dx * nx + dy * ny
        # A way that grazes its mirror has none.
        leg_m = ((mirror[t.FACE_X] - x) * nx + (mirror[t.FACE_Y] - y) * ny) / min(along, -1e-9)
        leg_m = min(max(leg_m, 0.0), way_m)
        _check(found, x, y, dx, dy, leg_m)
        x, y = x + leg_m * dx + OFF_SURFACE_M * nx, y + leg_m * dy + OFF_SURFACE_M * ny
        dx, dy = dx - 2 * along * nx, dy - 2 * along * ny
        way_m -= leg_m
    _check(found, x, y, dx, dy, way_m)


@njit(cache=True)
def _foot(face):
    """Return distance and bearing of the foot of the perpendicular on a flat face."""
    nx, ny = face[t.FACE_NX], face[t.FACE_NY]
    half_m = (face[t.FACE_IX] - face[t.FACE_X]) * nx + (face[t.FACE_IY] - face[t.FACE_Y]) * ny
    return half_m, bearing_to(face, face[t.FACE_IX] - nx, face[t.FACE_IY] - ny)


@njit(cache=True)
def _is_heard(acoustics, rules, half_m, level_db):
    """Return whether a sonar hears an echo of its own from so far away."""
    return (
        half_m <= rules.reach_m
        and level_db + gain_db(acoustics, 2 * half_m / acoustics.speed_mps) > 0
    )


@njit(cache=True)
def _echo_db(survey, p, half_m, theta, surfaces, acoustics):
    """Return the level of what a mirror in the place of a face would send back."""
    loss_db = 2 * survey.faces[p, t.FACE_LOSS]
    loss_db += surfaces[survey.links[p, t.TO_SURFACE], t.SURFACE_MIRROR]
    return way_db(acoustics, 2 * half_m) + 2 * beam_db(acoustics, theta) + loss_db


@njit(cache=True)
def _add_pillar(found, survey, p, surfaces, rules, acoustics):
    """Add a pillar's echo: the foot of the perpendicular lies on the line to its centre."""
    face, like = survey.faces[p], surfaces[survey.links[p, t.TO_SURFACE]]
    radius_m = like[t.SURFACE_RADIUS]
    x, y = face[t.FACE_X] - radius_m * face[t.FACE_NX], face[t.FACE_Y] - radius_m * face[t.FACE_NY]
    half_m, theta = distance_to(face, x, y) - radius_m, bearing_to(face, x, y)
    share_db = 10 * math.log10(radius_m / (radius_m + max(half_m, 0.0)))
    level_db = _echo_db(survey, p, half_m, theta, surfaces, acoustics)
    level_db += max(share_db, like[t.SURFACE_FLOOR])
    if _is_heard(acoustics, rules, half_m, level_db):
        _check_unseen(found, survey, p, theta, half_m)
        _add(found, survey, p, survey.links[p, t.TO_SONAR], 2 * half_m, level_db, 0.0)


@njit(cache=True)
def _add_mirror(found, survey, p, half_m, foot, surfaces, rules, acoustics):
    """Add the mirror's echo of a flat face: it comes from the foot of the perpendicular."""
    face, like = survey.faces[p], surfaces[survey.links[p, t.TO_SURFACE]]
    if not face[t.FACE_LOW] - rules.margin_rad < foot < face[t.FACE_HIGH] + rules.margin_rad:
        return
    plane_db = _echo_db(survey, p, half_m, foot, surfaces, acoustics)
    level_db = 10 * math.log10(
        10 ** (plane_db / 10) + 10 ** ((plane_db + like[t.SURFACE_FLOOR]) / 10)
    )
    if _is_heard(acoustics, rules, half_m, level_db):
        _check_unseen(found, survey, p, foot, half_m)
        _add(found, survey, p, survey.links[p, t.TO_SONAR], 2 * half_m, level_db, 0.0)


@njit(cache=True)
def _add_scatter(found, survey, p, half_m, foot, surfaces, rules, acoustics):
    """Add what a flat face scatters: the first moment at which some place is loud enough."""
    face, like = survey.faces[p], surfaces[survey.links[p, t.TO_SURFACE]]
    loss_db = 2 * face[t.FACE_LOSS] + like[t.SURFACE_MIRROR] + like[t.SURFACE_FLOOR]
    low, high = face[t.FACE_LOW], face[t.FACE_HIGH]
    nearest = min(max(foot, low), high)
    # A bound that is quickly told spares most faces and places the rest.
    most_db = _best_between_db(face, half_m, foot, nearest, rules, acoustics) + loss_db
    if most_db + 2 * loudest_db(acoustics, low, high) <= 0:
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
        if r > rules.reach_m or r >= first_m:
            continue
        level_db = way_db(acoustics, 2 * r) + 2 * sent_db + loss_db
        level_db += 20 * math.log10(cos)
        over_db = level_db + gain_db(acoustics, 2 * r / acoustics.speed_mps)
        if over_db > 0:
            crossing_m = r + pulse_m * 10 ** (-over_db / 20)
            if crossing_m < first_m:
                first_m, place, loudness_db = crossing_m, theta, level_db
    if first_m < math.inf:
        way_m = 2 * half_m / math.cos(place - foot)
        own = survey.links[p, t.TO_SONAR]
        _add(found, survey, p, own, way_m, loudness_db, abs(place - foot))


@njit(cache=True)
def _best_between_db(face, half_m, foot, nearest, rules, acoustics):
    """Return a level that no echo from within the limits of a flat face exceeds."""
    near_m = half_m / max(math.cos(nearest - foot), 1e-3)
    least_cos = min(math.cos(face[t.FACE_LOW] - foot), math.cos(face[t.FACE_HIGH] - foot))
    far_m = min(half_m / max(least_cos, 1e-3), rules.reach_m)
    if near_m > rules.reach_m:
        return -math.inf
    # In dry air the gain more than makes up for distance; but it is loudest at an end.
    return max(best_db(acoustics, 2 * near_m), best_db(acoustics, 2 * far_m))


@njit(cache=True)
def _add_elsewhere(found, survey, p, half_m, alone, surfaces, rules, acoustics):
    """Add the ways over a flat face that end elsewhere than they began."""
    face, own = survey.faces[p], survey.links[p, t.TO_SONAR]
    nx, ny = face[t.FACE_NX], face[t.FACE_NY]
    # Of two faces at a right angle the corner is told already.
    is_told = survey.links[p, t.TO_MIRRORS] == 0 or are_square(
        face[t.FACE_MX], face[t.FACE_MY], nx, ny
    )
    if half_m <= 0 or (alone and is_told):
        return
    # The wedge in which the face may turn sound; most ways fail it.
    middle = (face[t.FACE_LOW] + face[t.FACE_HIGH]) / 2 - face[t.FACE_THETA]
    middle = face[t.FACE_ALONG] + face[t.FACE_SIGN] * middle
    wedge_x, wedge_y = math.cos(middle), math.sin(middle)
    least_cos = math.cos((face[t.FACE_HIGH] - face[t.FACE_LOW]) / 2 + rules.margin_rad) - 1e-9
    for sonar in range(own if alone else 0, own + 1 if alone else survey.axis_rad.size):
        if sonar == own and is_told:
            continue
        x, y = survey.sensor_xy_m[sonar]
        height_m = (x - face[t.FACE_X]) * nx + (y - face[t.FACE_Y]) * ny
        if height_m <= 0:
            continue
        # The listener sees the image's image by way of the point where the face turns the sound.
        ox, oy = face[t.FACE_IX] - 2 * half_m * nx - x, face[t.FACE_IY] - 2 * half_m * ny - y
        share = height_m / (height_m + half_m)
        tx, ty = x + share * ox - face[t.FACE_IX], y + share * oy - face[t.FACE_IY]
        if tx * wedge_x + ty * wedge_y >= least_cos * math.sqrt(tx * tx + ty * ty):
            _add_way(found, survey, p, sonar, ox, oy, share, surfaces, rules, acoustics)


@njit(cache=True)
def _add_way(found, survey, p, sonar, ox, oy, share, surfaces, rules, acoustics):
    """Add the way over a face to a sonar that sees its image at an offset.

    The face turns the sound after a share of that offset.
    """
    face, links = survey.faces[p], survey.links[p]
    way_m = math.hypot(ox, oy)
    is_own = sonar == links[t.TO_SONAR]
    if way_m > 2 * rules.reach_m or (way_m < rules.others_m and not is_own):
        return
    x, y = survey.sensor_xy_m[sonar]
    qx, qy = x + share * ox, y + share * oy
    theta = bearing_to(face, qx, qy)
    if not face[t.FACE_LOW] - rules.margin_rad < theta < face[t.FACE_HIGH] + rules.margin_rad:
        return
    arrival = math.atan2(oy, ox) - survey.axis_rad[sonar]
    # Each mirror is passed once on such a way.
    level_db = way_db(acoustics, way_m) + beam_db(acoustics, theta) + beam_db(acoustics, arrival)
    level_db += face[t.FACE_LOSS] + surfaces[links[t.TO_SURFACE], t.SURFACE_MIRROR]
    latest_s = min(way_m / acoustics.speed_mps + acoustics.head_start_s, acoustics.window_s)
    if level_db + gain_db(acoustics, latest_s) <= 0:
        return
    _check_unseen(found, survey, p, theta, distance_to(face, qx, qy))
    back_m = share * way_m
    _check(found, x, y, ox / way_m, oy / way_m, back_m)
    cos = ((x - qx) * face[t.FACE_NX] + (y - qy) * face[t.FACE_NY]) / back_m
    _add(found, survey, p, sonar, way_m, level_db, math.acos(min(1.0, cos)))


@njit(cache=True)
def _add_edge(found, survey, p, x, y, surfaces, rules, acoustics):
    """Add the echo of an edge, which falls faster than that of a plane."""
    half_m = distance_to(survey.faces[p], x, y)
    level_db = acoustics.edge_db - 20 * math.log10(max(half_m, 0.01))
    _add_point(found, survey, p, x, y, level_db, surfaces, rules, acoustics)


@njit(cache=True)
def _add_point(found, survey, p, x, y, share_db, surfaces, rules, acoustics):
    """Add the echo of a corner or an edge, of so much level against a mirror.

    It lies between two neighbouring rays, so its way needs no check.
    """
    face = survey.faces[p]
    half_m, theta = distance_to(face, x, y), bearing_to(face, x, y)
    level_db = _echo_db(survey, p, half_m, theta, surfaces, acoustics) + share_db
    if not _is_heard(acoustics, rules, half_m, level_db):
        return
    cos = (face[t.FACE_IX] - x) * face[t.FACE_NX] + (face[t.FACE_IY] - y) * face[t.FACE_NY]
    incidence_rad = math.acos(min(1.0, max(0.0, cos / max(half_m, 1e-9))))
    _add(found, survey, p, survey.links[p, t.TO_SONAR], 2 * half_m, level_db, incidence_rad)
