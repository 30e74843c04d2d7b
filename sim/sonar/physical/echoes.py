"""Compiled: the sounds that faces send back, and whether their paths are free."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical import columns as t
from sim.sonar.physical.fresnel import strip_share
from sim.sonar.physical.levels import (
    amplitude,
    beam_bound_db,
    beam_db,
    loudest_echo_db,
    mirror_echo_db,
    others_tvg_db,
    power_db,
    tvg_db,
)
from sim.sonar.physical.tracing import OFF_SURFACE_M, are_square, bearing_to, distance_to, foot_of
from sim.sonar.physical.turning import edge_share_db, pillar_share_db, turning_place
from sonarmap.kernels.jit import njit

__all__ = ["Found", "confirmed", "find_sounds"]

# A ray that shall see a point sees it if its length agrees so well, metres.
_SAME_LENGTH_M = 1e-3
# Rays of checks go so much farther than they need to, metres.
_BEYOND_M = 0.1
# So far from an edge a ray shall meet its face, metres.
_ON_FACE_M = 2e-4
# The least of distances and cosines.
_LEAST = 1e-3
# What is seen at such an angle from the perpendicular is as far away as anything.
_LEVEL_RAD = math.radians(89.0)
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
    most = len(faces) * (2 + listeners) + len(tracing.corners)
    most += (len(tracing.edges) + len(tracing.ends)) * listeners
    found = Found(
        np.empty((most, t.SOUND_COLUMNS)),
        np.empty((most * (limits.max_bounces + 2), t.CHECK_COLUMNS)),
        np.zeros(2, np.int64),
    )
    for p in range(len(faces)):
        if surfaces[links[p, t.LINK_SURFACE], t.SURFACE_RADIUS] > 0:
            _add_pillar(found, tracing, p, monostatic, surfaces, limits, acoustics)
            continue
        half_m, foot = foot_of(faces[p])
        _add_mirror(found, tracing, p, half_m, foot, surfaces, limits, acoustics)
        _add_scatter(found, tracing, p, half_m, foot, surfaces, limits, acoustics)
        _add_bistatic(found, tracing, p, half_m, monostatic, surfaces, limits, acoustics)
    for corner in tracing.corners:
        p = int(corner[t.CORNER_FACE])
        q, x, y = int(corner[t.CORNER_OTHER]), corner[t.CORNER_X], corner[t.CORNER_Y]
        share = _corner_share(tracing, p, q, x, y, acoustics)
        level_db = surfaces[links[q, t.LINK_SURFACE], t.SURFACE_MIRROR]
        level_db += power_db(share)
        _add_point(found, tracing, p, x, y, level_db, surfaces, limits, acoustics)
    for edge in tracing.edges:
        p, x, y = int(edge[t.EDGE_FACE]), edge[t.EDGE_X], edge[t.EDGE_Y]
        _add_edge(found, tracing, p, x, y, monostatic, surfaces, limits, acoustics)
    for end in tracing.ends:
        p = int(end[t.END_FACE])
        # A pillar has no edge: its outline is where rays graze it.
        if surfaces[links[p, t.LINK_SURFACE], t.SURFACE_RADIUS] == 0:
            sonar = links[p, t.LINK_SONAR]
            angle = tracing.axis_rad[sonar] + end[t.END_INSIDE]
            x = tracing.sensor_xy_m[sonar, 0] + end[t.END_LENGTH] * math.cos(angle)
            y = tracing.sensor_xy_m[sonar, 1] + end[t.END_LENGTH] * math.sin(angle)
            _add_edge(found, tracing, p, x, y, monostatic, surfaces, limits, acoustics)
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


@njit(makes_arrays=False)
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


@njit(makes_arrays=False)
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


@njit(makes_arrays=False)
def _is_detectable(acoustics, limits, half_m, level_db):
    """Return whether a sonar detects an echo of its own from so far away."""
    return (
        half_m <= limits.reach_m
        and level_db + tvg_db(acoustics, 2 * half_m / acoustics.speed_mps) > 0
    )


@njit(makes_arrays=False)
def _echo_db(tracing, p, half_m, theta, surfaces, acoustics):
    """Return the level of what a mirror in the place of a face would send back."""
    loss_db = 2 * tracing.faces[p, t.FACE_LOSS]
    loss_db += surfaces[tracing.links[p, t.LINK_SURFACE], t.SURFACE_MIRROR]
    passed = _passed_share(tracing, p, theta, 2 * half_m, acoustics)
    loss_db += 2 * power_db(passed)
    return mirror_echo_db(acoustics, 2 * half_m) + 2 * beam_db(acoustics, theta) + loss_db


@njit(makes_arrays=False)
def _turned_share(tracing, p, theta, path_m, acoustics):
    """Return the power that a face turns on a path that meets it at a bearing, by its size."""
    faces = tracing.faces
    half_m, foot = foot_of(faces[p])
    low, high = tracing.links[p, t.LINK_LOW], tracing.links[p, t.LINK_HIGH]
    # In a hollow corner a face is mirrored on to where the other one ends.
    low_rad = high_rad = math.nan
    if low == t.ENDS:
        low_rad = faces[p, t.FACE_LOW]
    elif low >= 0 and tracing.links[low, t.LINK_LOW] != t.GOES_ON:
        low_rad = faces[low, t.FACE_LOW]
    if high == t.ENDS:
        high_rad = faces[p, t.FACE_HIGH]
    elif high >= 0 and tracing.links[high, t.LINK_HIGH] != t.GOES_ON:
        high_rad = faces[high, t.FACE_HIGH]
    at_m = half_m * math.tan(theta - foot)
    low_m, high_m = -math.inf, math.inf
    if abs(low_rad - foot) < _LEVEL_RAD:
        low_m = min(half_m * math.tan(low_rad - foot) - at_m, 0.0)
    if abs(high_rad - foot) < _LEVEL_RAD:
        high_m = max(half_m * math.tan(high_rad - foot) - at_m, 0.0)
    cos = max(math.cos(theta - foot), _LEAST)
    one_m = max(half_m / cos, _LEAST)
    return strip_share(acoustics, low_m, high_m, cos, one_m, path_m - one_m)


@njit(makes_arrays=False)
def _passed_share(tracing, p, theta, path_m, acoustics):
    """Return the power that the mirrors before a face let pass by their sizes, each once."""
    share, mirror = 1.0, tracing.links[p, t.LINK_MIRROR]
    while mirror >= 0:
        share *= min(1.0, _turned_share(tracing, mirror, theta, path_m, acoustics))
        mirror = tracing.links[mirror, t.LINK_MIRROR]
    return share


@njit(makes_arrays=False)
def _corner_share(tracing, p, q, x, y, acoustics):
    """Return the power of a right-angled corner of two faces, by its width across its sound."""
    faces, links = tracing.faces, tracing.links
    theta, half_m = bearing_to(faces[p], x, y), max(distance_to(faces[p], x, y), _LEAST)
    width_m = math.inf
    if links[p, t.LINK_LOW] != t.GOES_ON:
        width_m = min(width_m, _across_m(faces[p], faces[p, t.FACE_LOW], theta))
    if links[q, t.LINK_HIGH] != t.GOES_ON:
        width_m = min(width_m, _across_m(faces[q], faces[q, t.FACE_HIGH], theta))
    return strip_share(acoustics, -width_m, width_m, 1.0, half_m, half_m)


@njit(makes_arrays=False)
def _across_m(face, end_rad, theta):
    """Return how far the end of a face lies off a ray."""
    half_m, foot = foot_of(face)
    return half_m / max(math.cos(end_rad - foot), _LEAST) * math.sin(abs(end_rad - theta))


@njit()
def _add_pillar(found, tracing, p, monostatic, surfaces, limits, acoustics):
    """Add a pillar's echo: the foot of the perpendicular lies on the line to its centre."""
    face, like = tracing.faces[p], surfaces[tracing.links[p, t.LINK_SURFACE]]
    radius_m = like[t.SURFACE_RADIUS]
    x, y = face[t.FACE_X] - radius_m * face[t.FACE_NX], face[t.FACE_Y] - radius_m * face[t.FACE_NY]
    half_m, theta = distance_to(face, x, y) - radius_m, bearing_to(face, x, y)
    share_db = pillar_share_db(radius_m, 1.0, max(half_m, _LEAST), max(half_m, _LEAST))
    level_db = _echo_db(tracing, p, half_m, theta, surfaces, acoustics)
    level_db += max(share_db, like[t.SURFACE_FLOOR])
    if _is_detectable(acoustics, limits, half_m, level_db):
        _check_unseen(found, tracing, p, theta, half_m)
        _add(found, tracing, p, tracing.links[p, t.LINK_SONAR], 2 * half_m, level_db, 0.0)
    if monostatic or tracing.links[p, t.LINK_MIRRORS] > 0:
        return
    own = tracing.links[p, t.LINK_SONAR]
    own_x, own_y = tracing.sensor_xy_m[own]
    for sonar in range(tracing.axis_rad.size):
        if sonar == own:
            continue
        to_x, to_y = tracing.sensor_xy_m[sonar]
        px, py, cos = turning_place(x, y, radius_m, own_x, own_y, to_x, to_y)
        one_m, other_m = math.hypot(px - own_x, py - own_y), math.hypot(px - to_x, py - to_y)
        share_db = max(pillar_share_db(radius_m, cos, one_m, other_m), like[t.SURFACE_FLOOR])
        _add_turned(
            found, tracing, p, sonar, px, py, one_m, other_m, share_db, cos, surfaces, limits,
            acoustics,
        )  # fmt: skip


@njit()
def _add_turned(
    found, tracing, p, sonar, x, y, one_m, other_m, share_db, cos, surfaces, limits, acoustics
):
    """Add the path to another sonar over a place of a pillar, or over an edge, if it is detected.

    Paths over mirrors are left out.
    """
    path_m = one_m + other_m
    if path_m > 2 * limits.reach_m or path_m < limits.least_cross_path_m:
        return
    face, to = tracing.faces[p], tracing.sensor_xy_m[sonar]
    theta = bearing_to(face, x, y)
    arrival = math.atan2(y - to[1], x - to[0]) - tracing.axis_rad[sonar]
    level_db = mirror_echo_db(acoustics, path_m) + beam_db(acoustics, theta)
    level_db += beam_db(acoustics, arrival) + face[t.FACE_LOSS] + tracing.gain_db[sonar]
    level_db += share_db + surfaces[tracing.links[p, t.LINK_SURFACE], t.SURFACE_MIRROR]
    if level_db + others_tvg_db(acoustics, path_m) <= 0:
        return
    _check_unseen(found, tracing, p, theta, one_m)
    _check(found, to[0], to[1], (x - to[0]) / other_m, (y - to[1]) / other_m, other_m)
    _add(found, tracing, p, sonar, path_m, level_db, math.acos(min(1.0, max(0.0, cos))))


@njit()
def _add_mirror(found, tracing, p, half_m, foot, surfaces, limits, acoustics):
    """Add the mirror's echo of a flat face: it comes from the foot of the perpendicular."""
    face, like = tracing.faces[p], surfaces[tracing.links[p, t.LINK_SURFACE]]
    if not face[t.FACE_LOW] - limits.margin_rad < foot < face[t.FACE_HIGH] + limits.margin_rad:
        return
    level_db = _echo_db(tracing, p, half_m, foot, surfaces, acoustics)
    share = _turned_share(tracing, p, foot, 2 * half_m, acoustics)
    level_db += power_db(share + amplitude(like[t.SURFACE_FLOOR]) ** 2)
    if _is_detectable(acoustics, limits, half_m, level_db):
        _check_unseen(found, tracing, p, foot, half_m)
        _add(found, tracing, p, tracing.links[p, t.LINK_SONAR], 2 * half_m, level_db, 0.0)


@njit(makes_arrays=False)
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
            crossing_m = r + pulse_m * amplitude(-over_db)
            if crossing_m < first_m:
                first_m, place, loudness_db = crossing_m, theta, level_db
    if first_m < math.inf:
        path_m = 2 * half_m / math.cos(place - foot)
        own = tracing.links[p, t.LINK_SONAR]
        _add(found, tracing, p, own, path_m, loudness_db, abs(place - foot))


@njit(makes_arrays=False)
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
    power = _turned_share(tracing, p, theta, path_m, acoustics)
    power *= _passed_share(tracing, p, theta, path_m, acoustics)
    level_db += tracing.gain_db[sonar] + power_db(power)
    gain_db = others_tvg_db(acoustics, path_m)
    if is_own:
        gain_db = tvg_db(acoustics, path_m / acoustics.speed_mps)
    if level_db + gain_db <= 0:
        return
    _check_unseen(found, tracing, p, theta, distance_to(face, qx, qy))
    back_m = share * path_m
    _check(found, x, y, ox / path_m, oy / path_m, back_m)
    cos = ((x - qx) * face[t.FACE_NX] + (y - qy) * face[t.FACE_NY]) / back_m
    _add(found, tracing, p, sonar, path_m, level_db, math.acos(min(1.0, cos)))


@njit()
def _add_edge(found, tracing, p, x, y, monostatic, surfaces, limits, acoustics):
    """Add the echo of an edge, which falls faster than that of a plane; to others, too."""
    face, own = tracing.faces[p], tracing.links[p, t.LINK_SONAR]
    half_m = distance_to(face, x, y)
    level_db = edge_share_db(acoustics.edge_db, half_m, half_m)
    _add_point(found, tracing, p, x, y, level_db, surfaces, limits, acoustics)
    if monostatic or tracing.links[p, t.LINK_MIRRORS] > 0:
        return
    # A ray at the very edge may miss it.
    inside_m = max(math.hypot(face[t.FACE_X] - x, face[t.FACE_Y] - y), 1e-9)
    on_x = x + (face[t.FACE_X] - x) * min(1.0, _ON_FACE_M / inside_m)
    on_y = y + (face[t.FACE_Y] - y) * min(1.0, _ON_FACE_M / inside_m)
    for sonar in range(tracing.axis_rad.size):
        if sonar == own:
            continue
        to_x, to_y = tracing.sensor_xy_m[sonar]
        other_m = max(math.hypot(on_x - to_x, on_y - to_y), _LEAST)
        cos = ((to_x - x) * face[t.FACE_NX] + (to_y - y) * face[t.FACE_NY]) / other_m
        _add_turned(
            found, tracing, p, sonar, on_x, on_y, half_m, other_m,
            edge_share_db(acoustics.edge_db, half_m, other_m), cos, surfaces, limits, acoustics,
        )  # fmt: skip


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
