"""Compiled image-source tracing: fans of rays, mirrored on, find faces and where they end.

A fan is traced in unfolded space: behind a mirror its rays come from the transducer's mirror
image, and every rule for a face seen straight holds for one seen by way of mirrors.

A tracing asks for rays to be cast, and goes on with what they hit, until it asks for none::

    tracing = begin_tracing(...)
    while len(tracing.rays):
        tracing = advance_tracing(tracing, *cast(tracing.rays), ...)
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical import columns as t
from sim.sonar.physical.fresnel import FOCUS_DB, clearance_per_m
from sim.sonar.physical.levels import beam_db, loudest_echo_db, loudest_other_db, wrapped
from sonarmap.kernels.jit import njit

__all__ = ["Tracing", "TracingLimits", "advance_tracing", "begin_tracing"]

# Two hits lie on one flat face if their normals and their distances from it agree so well.
_SAME_NORMAL = 1e-5
_SAME_PLANE_M = 1e-4
# A corner sends back like a mirror if it is a right angle to this; assumed.
_RIGHT_ANGLE = math.sin(math.radians(2.0))
# A mirrored ray begins this far off the surface, so that it does not meet it again; metres.
OFF_SURFACE_M = 1e-6
# Of mirrored rays that can only end at another bearing than they began, or at another sonar, one
# in so many is traced: such paths need large faces, whose place they only have to show.
_THINNED = 3
# Ends of faces are searched until they lie between rays so close, radians: 1.6 mm at 3 m; each
# search splits the gap into so many parts, because one large batch of rays costs less than many.
_END_RAD, _SPLIT = math.radians(0.03), 10
# Ends so near to a foot, as Fresnel's integrals count, change its level by half a decibel or more.
_NEAR_FOOT = 4.0


class TracingLimits(NamedTuple):
    """How far and how finely faces are traced.

    Parameters
    ----------
    reach_m : float
        Half of the longest path on which any sound is still detected.
    max_bounces : int
        Over how many mirrors.
    margin_rad : float
        So far beyond the rays that meet a face its foot may lie.
    least_cross_path_m : float
        The shortest path on which a sonar that does not fire now may detect a sound.
    axis_number, cone_numbers : int
        Number of the ray on the axis in a fan, and how many on either side lie in the nominal
        cone, for the truths only.
    range_max_m : float
        Nominal range, likewise.
    """

    reach_m: float
    max_bounces: int
    margin_rad: float
    least_cross_path_m: float
    axis_number: int
    cone_numbers: int
    range_max_m: float


class Tracing(NamedTuple):
    """What is known of the faces around the sonars, and the rays that would show more.

    Parameters
    ----------
    sensor_xy_m, axis_rad, gain_db : ndarray, shapes (sonars, 2), (sonars,), (sonars,)
        All transducers of the ring: places, where their beams look, sensitivities.
    axis_range_m, cone_range_m : ndarray, shape (sonars,)
        True ranges of the sonars that fired; +inf beyond the range.
    faces, links : ndarray, shapes (p, FACE_COLUMNS), (p, t.LINK_COLUMNS)
        Faces of all legs.
    corners, edges, ends : ndarray
        Where faces end, see the columns.
    rays : ndarray, shape (n, RAY_COLUMNS)
        Rays to be cast: first those of the fans, then those that search for ends.
    ids : ndarray of int, shape (m, ID_COLUMNS)
        Of the rays of the fans.
    mirrors : int
        Over how many mirrors the rays of the fans go.
    """

    sensor_xy_m: NDArray[np.float64]
    axis_rad: NDArray[np.float64]
    gain_db: NDArray[np.float64]
    axis_range_m: NDArray[np.float64]
    cone_range_m: NDArray[np.float64]
    faces: NDArray[np.float64]
    links: NDArray[np.int64]
    corners: NDArray[np.float64]
    edges: NDArray[np.float64]
    ends: NDArray[np.float64]
    rays: NDArray[np.float64]
    ids: NDArray[np.int64]
    mirrors: int


@njit()
def begin_tracing(sonars, sensor_xy_m, axis_rad, gain_db, lean_rad, bearing_rad, reach_m):
    """Return the tracing that asks for the fans of some sonars.

    Parameters
    ----------
    sonars : ndarray of int
        The sonars that fire.
    sensor_xy_m, axis_rad : ndarray, shapes (sonars of the ring, 2), (sonars of the ring,)
        All transducers.
    gain_db, lean_rad : ndarray, shape (sonars of the ring,)
        See `sim.sonar.physical.spread.Transducers`.
    bearing_rad, reach_m : ndarray
        The rays of a fan, and how far each is of interest.
    """
    count = bearing_rad.size
    beam_rad = axis_rad + lean_rad
    rays = np.zeros((sonars.size * count, t.RAY_COLUMNS))
    ids = np.empty((sonars.size * count, t.ID_COLUMNS), np.int64)
    for i in range(len(rays)):
        k = i % count
        ids[i, t.ID_SONAR], ids[i, t.ID_MIRROR], ids[i, t.ID_NUMBER] = (
            sonars[i // count],
            -1,
            k,
        )
        own = sonars[i // count]
        # The fan is spread about the stated axis; bearings count from where the beam looks.
        _depart(
            rays[i], sensor_xy_m, beam_rad, gain_db, own, bearing_rad[k] - lean_rad[own], reach_m[k]
        )
    unknown_m = np.full(axis_rad.size, math.inf)
    return Tracing(
        sensor_xy_m,
        beam_rad,
        gain_db,
        unknown_m,
        unknown_m.copy(),
        np.empty((0, t.FACE_COLUMNS)),
        np.empty((0, t.LINK_COLUMNS), np.int64),
        np.empty((0, t.CORNER_COLUMNS)),
        np.empty((0, t.EDGE_COLUMNS)),
        np.empty((0, t.END_COLUMNS)),
        rays,
        ids,
        0,
    )


@njit(makes_arrays=False)
def _depart(ray, sensor_xy_m, axis_rad, gain_db, sonar, theta, reach_m):
    """Let a ray leave its transducer."""
    ray[t.RAY_X] = ray[t.RAY_IX] = sensor_xy_m[sonar, 0]
    ray[t.RAY_Y] = ray[t.RAY_IY] = sensor_xy_m[sonar, 1]
    angle = axis_rad[sonar] + theta
    ray[t.RAY_DX], ray[t.RAY_DY] = math.cos(angle), math.sin(angle)
    ray[t.RAY_REACH], ray[t.RAY_THETA], ray[t.RAY_SIGN] = reach_m, theta, 1.0
    ray[t.RAY_LOSS] = gain_db[sonar]


@njit()
def advance_tracing(tracing, leg_m, normal, surface, surfaces, limits, acoustics):
    """Return the tracing after its rays have been cast.

    Parameters
    ----------
    tracing : Tracing
        Its true ranges, its faces' limits and its ends are changed in place.
    leg_m, normal, surface : ndarray, shapes (n,), (n, 2), (n,)
        What its rays met, as `worlds.RayHits`.
    surfaces : ndarray, shape (surfaces + 1, SURFACE_COLUMNS)
        What they are like; the last row stands for no surface.
    limits : TracingLimits
    acoustics : Acoustics
    """
    m = len(tracing.ids)
    _narrow_ends(tracing, leg_m[m:], surface[m:], surfaces)
    leg = _Leg(
        tracing.ids, tracing.rays[:m], leg_m[:m], normal[:m], surface[:m], tracing.faces.shape[0]
    )
    first = tracing.mirrors == 0
    if first:
        _set_true_ranges(tracing, leg, limits)
    face, faces, links, ray_of = _find_faces(leg, surfaces, tracing.mirrors)
    corners, edges, ends = _find_boundaries(leg, face, faces, links, ray_of, surfaces, acoustics)
    if tracing.mirrors < limits.max_bounces:
        ids, rays = _mirrored(leg, face, surfaces, limits, acoustics, tracing.gain_db.max())
    else:
        ids, rays = leg.ids[:0], leg.rays[:0]
    # Behind a mirror an end stays between its two rays: a second-order sound's small error.
    searched = ends if first else tracing.ends
    faces = np.concatenate((tracing.faces, faces))
    links = np.concatenate((tracing.links, links))
    searches = _searching(tracing, searched, links, limits)
    return Tracing(
        tracing.sensor_xy_m,
        tracing.axis_rad,
        tracing.gain_db,
        tracing.axis_range_m,
        tracing.cone_range_m,
        faces,
        links,
        np.concatenate((tracing.corners, corners)),
        np.concatenate((tracing.edges, edges)),
        searched,
        np.concatenate((rays, searches)),
        ids,
        tracing.mirrors + 1,
    )


class _Leg(NamedTuple):
    """Rays of the fans on one leg of their path, and what they met."""

    ids: NDArray[np.int64]
    rays: NDArray[np.float64]
    leg_m: NDArray[np.float64]
    normal: NDArray[np.float64]
    surface: NDArray[np.int32]
    # The number of its first face among all.
    known: int


@njit()
def _set_true_ranges(tracing, leg, limits):
    for i in range(leg.surface.size):
        met_m, number = leg.leg_m[i], leg.ids[i, t.ID_NUMBER]
        if met_m > limits.range_max_m:
            continue
        sonar = leg.ids[i, t.ID_SONAR]
        if number == limits.axis_number:
            tracing.axis_range_m[sonar] = met_m
        if abs(number - limits.axis_number) <= limits.cone_numbers:
            tracing.cone_range_m[sonar] = min(tracing.cone_range_m[sonar], met_m)


@njit(makes_arrays=False)
def _are_neighbours(leg, i):
    """Return whether ray `i` and the one before it left one transducer over the same mirrors."""
    a, b = leg.ids[i - 1], leg.ids[i]
    return (
        a[t.ID_SONAR] == b[t.ID_SONAR]
        and a[t.ID_MIRROR] == b[t.ID_MIRROR]
        and b[t.ID_NUMBER] <= a[t.ID_NUMBER] + _THINNED
    )


@njit()
def _find_faces(leg, surfaces, mirrors):
    """Return (face of each ray, faces, links, first and last ray of each face)."""
    n, rays = leg.surface.size, leg.rays
    face = np.full(n, -1, np.int64)
    faces = np.empty((n, t.FACE_COLUMNS))
    links = np.empty((n, t.LINK_COLUMNS), np.int64)
    ray_of = np.empty((n, 2), np.int64)
    count = 0
    for i in range(n):
        s = leg.surface[i]
        if s < 0:
            continue
        x = rays[i, t.RAY_X] + leg.leg_m[i] * rays[i, t.RAY_DX]
        y = rays[i, t.RAY_Y] + leg.leg_m[i] * rays[i, t.RAY_DY]
        nx, ny = leg.normal[i, 0], leg.normal[i, 1]
        if i > 0 and s == leg.surface[i - 1] and _are_neighbours(leg, i):
            last = faces[face[i - 1]]
            off = (x - last[t.FACE_X]) * last[t.FACE_NX] + (y - last[t.FACE_Y]) * last[t.FACE_NY]
            flat = (
                abs(nx - last[t.FACE_NX]) < _SAME_NORMAL
                and abs(ny - last[t.FACE_NY]) < _SAME_NORMAL
                and abs(off) < _SAME_PLANE_M
            )
            if flat or surfaces[s, t.SURFACE_RADIUS] > 0:
                face[i] = face[i - 1]
                last[t.FACE_HIGH] = rays[i, t.RAY_THETA]
                ray_of[face[i], 1] = i
                continue
        new = faces[count]
        new[t.FACE_LOW] = new[t.FACE_HIGH] = new[t.FACE_THETA] = rays[i, t.RAY_THETA]
        new[t.FACE_X], new[t.FACE_Y], new[t.FACE_NX], new[t.FACE_NY] = x, y, nx, ny
        new[t.FACE_IX], new[t.FACE_IY] = rays[i, t.RAY_IX], rays[i, t.RAY_IY]
        new[t.FACE_ALONG] = math.atan2(rays[i, t.RAY_DY], rays[i, t.RAY_DX])
        new[t.FACE_SIGN], new[t.FACE_LOSS] = rays[i, t.RAY_SIGN], rays[i, t.RAY_LOSS]
        new[t.FACE_MX], new[t.FACE_MY] = rays[i, t.RAY_MX], rays[i, t.RAY_MY]
        links[count, t.LINK_SONAR], links[count, t.LINK_SURFACE] = leg.ids[i, t.ID_SONAR], s
        links[count, t.LINK_MIRROR], links[count, t.LINK_MIRRORS] = leg.ids[i, t.ID_MIRROR], mirrors
        links[count, t.LINK_LOW] = links[count, t.LINK_HIGH] = t.GOES_ON
        ray_of[count, 0] = ray_of[count, 1] = i
        face[i] = count
        count += 1
    return face, faces[:count], links[:count], ray_of[:count]


@njit(makes_arrays=False)
def bearing_to(face, x, y):
    """Return the bearing of departure at which a point is seen over the mirrors of a face."""
    towards = math.atan2(y - face[t.FACE_IY], x - face[t.FACE_IX])
    return face[t.FACE_THETA] + face[t.FACE_SIGN] * wrapped(towards - face[t.FACE_ALONG])


@njit(makes_arrays=False)
def foot_of(face):
    """Return distance and bearing of the foot of the perpendicular on a flat face."""
    nx, ny = face[t.FACE_NX], face[t.FACE_NY]
    half_m = (face[t.FACE_IX] - face[t.FACE_X]) * nx + (face[t.FACE_IY] - face[t.FACE_Y]) * ny
    return half_m, bearing_to(face, face[t.FACE_IX] - nx, face[t.FACE_IY] - ny)


@njit(makes_arrays=False)
def distance_to(face, x, y):
    """Return the length of the path from the transducer to a point over the mirrors of a face."""
    return math.hypot(x - face[t.FACE_IX], y - face[t.FACE_IY])


@njit()
def _find_boundaries(leg, face, faces, links, ray_of, surfaces, acoustics):
    """Return corners, edges and ends to look for; set faces' limits where two lines meet.

    It also sets what is at the limits.

    An end is looked for if what is there may be detected.
    """
    n, rays = leg.surface.size, leg.rays
    corners = np.empty((n, t.CORNER_COLUMNS))
    edges = np.empty((n, t.EDGE_COLUMNS))
    ends = np.empty((n, t.END_COLUMNS))
    c, e, b = 0, 0, 0
    for j in range(1, n):
        i = j - 1
        p, q = face[i], face[j]
        if p == q or not _are_neighbours(leg, j):
            continue
        if p >= 0 and q >= 0:
            one, other = faces[p], faces[q]
            cross = one[t.FACE_NX] * other[t.FACE_NY] - one[t.FACE_NY] * other[t.FACE_NX]
            off = (other[t.FACE_X] - one[t.FACE_X]) * one[t.FACE_NX]
            off += (other[t.FACE_Y] - one[t.FACE_Y]) * one[t.FACE_NY]
            if abs(cross) < _SAME_NORMAL and abs(off) < _SAME_PLANE_M:
                continue  # two flush faces: no edge
            are_flat = (
                surfaces[leg.surface[i], t.SURFACE_RADIUS] == 0
                and surfaces[leg.surface[j], t.SURFACE_RADIUS] == 0
            )
            if are_flat and abs(cross) > 1e-3:
                x, y = _meeting(one, other, cross)
                theta = bearing_to(one, x, y)
                if rays[i, t.RAY_THETA] - 1e-9 <= theta <= rays[j, t.RAY_THETA] + 1e-9:
                    one[t.FACE_HIGH] = other[t.FACE_LOW] = theta
                    links[p, t.LINK_HIGH] = links[q, t.LINK_LOW] = t.ENDS
                    if not _is_hollow(leg, ray_of[p, 0], ray_of[q, 1], one, other, x, y):
                        edges[e, t.EDGE_FACE] = leg.known + p
                        edges[e, t.EDGE_X], edges[e, t.EDGE_Y] = x, y
                        e += 1
                        continue
                    dot = one[t.FACE_NX] * other[t.FACE_NX] + one[t.FACE_NY] * other[t.FACE_NY]
                    if dot < _RIGHT_ANGLE:
                        links[p, t.LINK_HIGH], links[q, t.LINK_LOW] = leg.known + q, leg.known + p
                    if abs(dot) < _RIGHT_ANGLE:
                        corners[c, t.CORNER_FACE] = leg.known + p
                        corners[c, t.CORNER_OTHER] = leg.known + q
                        corners[c, t.CORNER_X], corners[c, t.CORNER_Y] = x, y
                        c += 1
                    continue
        near, far = i, j
        if p < 0 or (q >= 0 and _path_m(leg, j) < _path_m(leg, i)):
            near, far = j, i
        if leg.surface[far] >= 0 or _reaches_plane(leg, far, faces[face[near]]):
            links[face[near], t.LINK_HIGH if near < far else t.LINK_LOW] = t.ENDS
        if _is_end_detectable(leg, near, far, surfaces, acoustics) or _is_end_near_foot(
            leg, near, faces[face[near]], surfaces, acoustics
        ):
            ends[b, t.END_FACE], ends[b, t.END_SIDE] = leg.known + face[near], far - near
            ends[b, t.END_INSIDE] = rays[near, t.RAY_THETA]
            ends[b, t.END_OUTSIDE] = rays[far, t.RAY_THETA]
            ends[b, t.END_LENGTH] = leg.leg_m[near]
            b += 1
    return corners[:c], edges[:e], ends[:b]


@njit(makes_arrays=False)
def _reaches_plane(leg, i, face):
    """Return whether a ray goes so far that it would meet a face that went on."""
    ray, nx, ny = leg.rays[i], face[t.FACE_NX], face[t.FACE_NY]
    towards = -(ray[t.RAY_DX] * nx + ray[t.RAY_DY] * ny)
    height = (ray[t.RAY_X] - face[t.FACE_X]) * nx + (ray[t.RAY_Y] - face[t.FACE_Y]) * ny
    return towards * ray[t.RAY_REACH] > height


@njit(makes_arrays=False)
def _path_m(leg, i):
    return leg.rays[i, t.RAY_PATH] + leg.leg_m[i]


@njit(makes_arrays=False)
def _meeting(one, other, cross):
    """Return the point where the lines of two faces meet."""
    a = one[t.FACE_NX] * one[t.FACE_X] + one[t.FACE_NY] * one[t.FACE_Y]
    b = other[t.FACE_NX] * other[t.FACE_X] + other[t.FACE_NY] * other[t.FACE_Y]
    return (
        (a * other[t.FACE_NY] - b * one[t.FACE_NY]) / cross,
        (b * one[t.FACE_NX] - a * other[t.FACE_NX]) / cross,
    )


@njit(makes_arrays=False)
def _is_hollow(leg, u, w, one, other, x, y):
    """Return whether each face stands before the other.

    Decided by their far ends, met by the rays `u` and `w`: the near ones may be the vertex itself.
    """
    rays, leg_m = leg.rays, leg.leg_m
    before = (rays[w, t.RAY_X] + leg_m[w] * rays[w, t.RAY_DX] - x) * one[t.FACE_NX]
    before += (rays[w, t.RAY_Y] + leg_m[w] * rays[w, t.RAY_DY] - y) * one[t.FACE_NY]
    before += (rays[u, t.RAY_X] + leg_m[u] * rays[u, t.RAY_DX] - x) * other[t.FACE_NX]
    before += (rays[u, t.RAY_Y] + leg_m[u] * rays[u, t.RAY_DY] - y) * other[t.FACE_NY]
    return before > 0


@njit(makes_arrays=False)
def are_square(ax, ay, bx, by):
    """Return whether two normals are at a right angle."""
    return abs(ax * bx + ay * by) < _RIGHT_ANGLE


@njit(makes_arrays=False)
def _is_end_detectable(leg, near, far, surfaces, acoustics):
    """Return whether an end of a face between two rays may be detected as an edge or scatter."""
    half = _path_m(leg, near)
    sent_db = max(
        beam_db(acoustics, leg.rays[near, t.RAY_THETA]),
        beam_db(acoustics, leg.rays[far, t.RAY_THETA]),
    )
    like = surfaces[leg.surface[near]]
    returned_db = max(acoustics.edge_db - 20 * math.log10(max(half, 0.01)), like[t.SURFACE_FLOOR])
    # 6 dB, because what is looked for lies between the rays.
    level_db = loudest_echo_db(acoustics, 2 * half) + 2 * (sent_db + leg.rays[near, t.RAY_LOSS])
    return level_db + like[t.SURFACE_MIRROR] + returned_db + 6.0 > 0


@njit(makes_arrays=False)
def _is_end_near_foot(leg, near, face, surfaces, acoustics):
    """Return whether an end lies so near to the foot on its face that the level depends on it."""
    like = surfaces[leg.surface[near]]
    half_m, foot = foot_of(face)
    if like[t.SURFACE_RADIUS] > 0 or half_m < OFF_SURFACE_M:
        return False
    aside_m = half_m * math.tan(min(abs(leg.rays[near, t.RAY_THETA] - foot), 1.5))
    if aside_m * clearance_per_m(acoustics.wavelength_m, half_m, half_m) > _NEAR_FOOT:
        return False
    sent_db = beam_db(acoustics, foot) + leg.rays[near, t.RAY_LOSS]
    level_db = loudest_echo_db(acoustics, 2 * half_m) + FOCUS_DB + 2 * sent_db
    return level_db + like[t.SURFACE_MIRROR] > 0


@njit()
def _mirrored(leg, face, surfaces, limits, acoustics, most_db):
    """Return (ids, rays) of the rays that a flat face mirrors on and that may matter.

    No sonar is more sensitive than `most_db`.
    """
    n = leg.surface.size
    ids = np.empty((n, t.ID_COLUMNS), np.int64)
    rays = np.empty((n, t.RAY_COLUMNS))
    count = 0
    for i in range(n):
        like = surfaces[leg.surface[i]]
        if leg.surface[i] < 0 or like[t.SURFACE_RADIUS] > 0:
            continue  # a pillar spreads the sound too far
        ray, path_m = leg.rays[i], _path_m(leg, i)
        if path_m >= limits.reach_m:
            continue
        loss_db = ray[t.RAY_LOSS] + like[t.SURFACE_MIRROR]
        one_way_db = beam_db(acoustics, ray[t.RAY_THETA])
        # There and back each mirror is passed twice, on the path to another sonar once.
        back_db = loudest_echo_db(acoustics, 2 * path_m) + FOCUS_DB + 2 * (one_way_db + loss_db)
        there_db = (
            loudest_other_db(acoustics, max(2 * path_m, limits.least_cross_path_m))
            + FOCUS_DB
            + one_way_db
            + loss_db
            + most_db
        )
        if back_db <= 0 and (there_db <= 0 or leg.ids[i, t.ID_NUMBER] % _THINNED):
            continue
        ids[count] = leg.ids[i]
        ids[count, t.ID_MIRROR] = leg.known + face[i]
        _mirror(rays[count], ray, leg.leg_m[i], leg.normal[i, 0], leg.normal[i, 1])
        rays[count, t.RAY_REACH] = limits.reach_m - path_m
        rays[count, t.RAY_LOSS] = loss_db
        count += 1
    return ids[:count], rays[:count]


@njit(makes_arrays=False)
def _mirror(new, ray, leg_m, nx, ny):
    """Set the leg of a ray after the mirror that it met with this normal."""
    x, y = ray[t.RAY_X] + leg_m * ray[t.RAY_DX], ray[t.RAY_Y] + leg_m * ray[t.RAY_DY]
    new[t.RAY_X], new[t.RAY_Y] = x + OFF_SURFACE_M * nx, y + OFF_SURFACE_M * ny
    along = ray[t.RAY_DX] * nx + ray[t.RAY_DY] * ny
    new[t.RAY_DX], new[t.RAY_DY] = ray[t.RAY_DX] - 2 * along * nx, ray[t.RAY_DY] - 2 * along * ny
    height = (ray[t.RAY_IX] - x) * nx + (ray[t.RAY_IY] - y) * ny
    new[t.RAY_IX], new[t.RAY_IY] = ray[t.RAY_IX] - 2 * height * nx, ray[t.RAY_IY] - 2 * height * ny
    new[t.RAY_THETA], new[t.RAY_PATH], new[t.RAY_SIGN] = (
        ray[t.RAY_THETA],
        ray[t.RAY_PATH] + leg_m,
        -ray[t.RAY_SIGN],
    )
    new[t.RAY_MX], new[t.RAY_MY] = nx, ny


@njit(makes_arrays=False)
def _is_open(end):
    return abs(end[t.END_OUTSIDE] - end[t.END_INSIDE]) > _END_RAD


@njit()
def _searching(tracing, ends, links, limits):
    """Return the rays that split the gaps in which faces end."""
    rays = np.zeros((len(ends) * (_SPLIT - 1), t.RAY_COLUMNS))
    count = 0
    for end in ends:
        if not _is_open(end):
            continue
        sonar = links[int(end[t.END_FACE]), t.LINK_SONAR]
        for k in range(1, _SPLIT):
            theta = end[t.END_INSIDE] + (end[t.END_OUTSIDE] - end[t.END_INSIDE]) * (k / _SPLIT)
            _depart(
                rays[count], tracing.sensor_xy_m, tracing.axis_rad, tracing.gain_db, sonar, theta,
                limits.reach_m,
            )  # fmt: skip
            count += 1
    return rays[:count]


@njit()
def _narrow_ends(tracing, leg_m, surface, surfaces):
    """Let ends lie between the last ray that still meets the face and the one after it.

    Once an end is found, its face is limited by it.
    """
    rays, m = tracing.rays, len(tracing.ids)
    i = 0
    for end in tracing.ends:
        if not _is_open(end):
            continue
        number = int(end[t.END_FACE])
        face, wanted = tracing.faces[number], tracing.links[number, t.LINK_SURFACE]
        last = 0
        for k in range(_SPLIT - 1):
            if surface[i + k] != wanted or last < k:
                continue
            ray = rays[m + i + k]
            off = (ray[t.RAY_X] + leg_m[i + k] * ray[t.RAY_DX] - face[t.FACE_X]) * face[t.FACE_NX]
            off += (ray[t.RAY_Y] + leg_m[i + k] * ray[t.RAY_DY] - face[t.FACE_Y]) * face[t.FACE_NY]
            if surfaces[wanted, t.SURFACE_RADIUS] == 0 and abs(off) >= _SAME_PLANE_M:
                continue
            last = k + 1
            end[t.END_LENGTH] = leg_m[i + k]
        i += _SPLIT - 1
        inside, gap = end[t.END_INSIDE], end[t.END_OUTSIDE] - end[t.END_INSIDE]
        end[t.END_INSIDE] = inside + gap * last / _SPLIT
        end[t.END_OUTSIDE] = inside + gap * (last + 1) / _SPLIT
        if not _is_open(end):
            face[t.FACE_HIGH if end[t.END_SIDE] > 0 else t.FACE_LOW] = end[t.END_INSIDE]
