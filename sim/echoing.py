"""Compiled steps of the physical sonar: faces seen by a fan of rays, and the sounds they return.

A fan is followed in unfolded space: behind a mirror its rays come from the transducer's mirror
image, and every rule for a face seen straight holds for one seen by way of mirrors.

Columns of the float tables:

rays    see `RAY_*`: one row a ray of a fan on its present leg.
pieces  see `PIECE_*`: one row a run of neighbouring rays on the same flat face or pillar.
sounds  see `SOUND_*`: one row a way that sound may come to a sonar.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

# Rays: bearing off the axis at departure, begin of the leg, direction, image of the transducer,
# way so far, sign of the bearings after mirroring, sum of one-way mirror losses, last mirror's
# normal.
RAY_THETA, RAY_X, RAY_Y, RAY_DX, RAY_DY, RAY_IX, RAY_IY = range(7)
RAY_WAY, RAY_SIGN, RAY_LOSS, RAY_MX, RAY_MY, RAY_COLUMNS = range(7, 13)
# Pieces: bearings between which it is seen, a point of the face, its normal; rays of either end.
PIECE_LOW, PIECE_HIGH, PIECE_X, PIECE_Y, PIECE_NX, PIECE_NY, PIECE_COLUMNS = range(7)
# Sounds: way, level over threshold without gain, bearing of departure, distance to check along
# that bearing (0: seen already), point to check from the listener (NaN: none) and its distance,
# angle of incidence.
SOUND_WAY, SOUND_LEVEL, SOUND_THETA, SOUND_SEEN, SOUND_QX, SOUND_QY = range(6)
SOUND_BACK, SOUND_INCIDENCE, SOUND_COLUMNS = range(6, 9)

# Two hits lie on one flat face if their normals and their distances from it agree so well.
_SAME_NORMAL = 1e-5
_SAME_PLANE_M = 1e-4
# A corner sends back like a mirror if it is a right angle to this; assumed.
_RIGHT_ANGLE = math.sin(math.radians(2.0))
# A mirrored ray begins this far off the surface, so that it does not meet it again; metres.
_OFF_SURFACE_M = 1e-6
# Of mirrored rays that can only end at another bearing than they began, or at another sonar, one
# in so many is followed: such ways need large faces, whose place they only have to show.
_THINNED = 3
# Step of the search along a scattering face, radians.
_SCATTER_STEP_RAD = math.radians(0.1)


@njit(cache=True)
def _wrapped(angle):
    return angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)


@njit(cache=True)
def _beam(table, angle):
    """Return the one-way level at an angle; `table` goes in even steps from 0 to pi."""
    place = abs(_wrapped(angle)) / math.pi * (table.size - 1)
    low = min(int(place), table.size - 2)
    return table[low] + (place - low) * (table[low + 1] - table[low])


@njit(cache=True)
def gain_db(air, time_s):
    """Return what the receiver adds `time_s` after its firing.

    `air` is (speed, absorption per metre, dynamic range, share of the gain, nominal speed,
    nominal absorption, listening time, head start of other sonars).
    """
    half = max(air[4] * time_s / 2, 0.01)
    return air[3] * (20 * math.log10(half) + 2 * air[5] * (half - 1))


@njit(cache=True)
def way_db(air, way_m):
    """Return the level of a perfect mirror's echo over the threshold, without gain."""
    return air[2] - 20 * math.log10(max(way_m, 0.01) / 2) - air[1] * way_m + 2 * air[5]


@njit(cache=True)
def best_db(air, way_m):
    """Return the level over the threshold of a perfect mirror's echo for whoever may hear it."""
    return way_db(air, way_m) + gain_db(air, min(way_m / air[0] + air[7], air[6]))


@njit(cache=True)
def find_pieces(group, number, rays, leg_m, normal, surface, radius_m):
    """Return (piece of each ray, pieces, first ray and last ray of each piece)."""
    n = surface.size
    piece = np.full(n, -1, np.int64)
    pieces = np.empty((n, PIECE_COLUMNS))
    ends = np.empty((n, 2), np.int64)
    count = 0
    for i in range(n):
        s = surface[i]
        if s < 0:
            continue
        x = rays[i, RAY_X] + leg_m[i] * rays[i, RAY_DX]
        y = rays[i, RAY_Y] + leg_m[i] * rays[i, RAY_DY]
        if i > 0 and piece[i - 1] >= 0 and group[i] == group[i - 1] and s == surface[i - 1]:
            p = piece[i - 1]
            nx, ny = pieces[p, PIECE_NX], pieces[p, PIECE_NY]
            off = (x - pieces[p, PIECE_X]) * nx + (y - pieces[p, PIECE_Y]) * ny
            flat = (
                abs(normal[i, 0] - nx) < _SAME_NORMAL
                and abs(normal[i, 1] - ny) < _SAME_NORMAL
                and abs(off) < _SAME_PLANE_M
            )
            if number[i] <= number[i - 1] + _THINNED and (flat or radius_m[s] > 0):
                piece[i] = p
                pieces[p, PIECE_HIGH] = rays[i, RAY_THETA]
                ends[p, 1] = i
                continue
        piece[i] = count
        pieces[count, PIECE_LOW] = pieces[count, PIECE_HIGH] = rays[i, RAY_THETA]
        pieces[count, PIECE_X], pieces[count, PIECE_Y] = x, y
        pieces[count, PIECE_NX], pieces[count, PIECE_NY] = normal[i, 0], normal[i, 1]
        ends[count, 0] = ends[count, 1] = i
        count += 1
    return piece, pieces[:count], ends[:count]


@njit(cache=True)
def _bearing_to(rays, i, x, y):
    """Return the bearing of departure at which the fan of ray `i` sees a point."""
    towards = math.atan2(y - rays[i, RAY_IY], x - rays[i, RAY_IX])
    along = math.atan2(rays[i, RAY_DY], rays[i, RAY_DX])
    return rays[i, RAY_THETA] + rays[i, RAY_SIGN] * _wrapped(towards - along)


@njit(cache=True)
def _distance_to(rays, i, x, y):
    return math.hypot(x - rays[i, RAY_IX], y - rays[i, RAY_IY])


@njit(cache=True)
def find_boundaries(
    group, number, rays, leg_m, surface, piece, pieces, ends, radius_m, reflect_db, floor_db,
    air, beam, edge_db,
):  # fmt: skip
    """Find where one face ends and another begins; set the pieces' limits where two lines meet.

    Returns
    -------
    corners : ndarray, shape (c, 3)
        Ray, and the vertex of each right-angled hollow corner.
    edges : ndarray, shape (e, 3)
        Ray of the nearer side, and the vertex of each edge between two seen faces.
    open_ends : ndarray of int, shape (b, 2)
        Rays on the near and on the far side of ends that must be looked for, because what is
        there may be heard.
    """
    n = surface.size
    corners, edges = np.empty((n, 3)), np.empty((n, 3))
    open_ends = np.empty((n, 2), np.int64)
    c, e, b = 0, 0, 0
    for i in range(n - 1):
        j = i + 1
        if group[i] != group[j] or number[j] > number[i] + _THINNED or piece[i] == piece[j]:
            continue
        if piece[i] >= 0 and piece[j] >= 0:
            p, q = piece[i], piece[j]
            ax, ay = pieces[p, PIECE_NX], pieces[p, PIECE_NY]
            bx, by = pieces[q, PIECE_NX], pieces[q, PIECE_NY]
            cross = ax * by - ay * bx
            off = (pieces[q, PIECE_X] - pieces[p, PIECE_X]) * ax
            off += (pieces[q, PIECE_Y] - pieces[p, PIECE_Y]) * ay
            if abs(cross) < _SAME_NORMAL and abs(off) < _SAME_PLANE_M:
                continue  # two flush faces: no edge
            if radius_m[surface[i]] == 0 and radius_m[surface[j]] == 0 and abs(cross) > 1e-3:
                ac = ax * pieces[p, PIECE_X] + ay * pieces[p, PIECE_Y]
                bc = bx * pieces[q, PIECE_X] + by * pieces[q, PIECE_Y]
                vx, vy = (ac * by - bc * ay) / cross, (ax * bc - bx * ac) / cross
                theta = _bearing_to(rays, i, vx, vy)
                if rays[i, RAY_THETA] - 1e-9 <= theta <= rays[j, RAY_THETA] + 1e-9:
                    pieces[p, PIECE_HIGH] = pieces[q, PIECE_LOW] = theta
                    # Hollow if each face stands before the other; told by their far ends, since
                    # the near ones may be the vertex itself.
                    u, w = ends[p, 0], ends[q, 1]
                    before = (rays[w, RAY_X] + leg_m[w] * rays[w, RAY_DX] - vx) * ax
                    before += (rays[w, RAY_Y] + leg_m[w] * rays[w, RAY_DY] - vy) * ay
                    before += (rays[u, RAY_X] + leg_m[u] * rays[u, RAY_DX] - vx) * bx
                    before += (rays[u, RAY_Y] + leg_m[u] * rays[u, RAY_DY] - vy) * by
                    hollow = before > 0
                    if not hollow:
                        edges[e, 0], edges[e, 1], edges[e, 2] = i, vx, vy
                        e += 1
                    elif abs(ax * bx + ay * by) < _RIGHT_ANGLE:
                        corners[c, 0], corners[c, 1], corners[c, 2] = i, vx, vy
                        c += 1
                    continue
        near, far = i, j
        if piece[i] < 0 or (
            piece[j] >= 0 and rays[j, RAY_WAY] + leg_m[j] < rays[i, RAY_WAY] + leg_m[i]
        ):
            near, far = j, i
        s = surface[near]
        half = rays[near, RAY_WAY] + leg_m[near]
        tx = max(_beam(beam, rays[i, RAY_THETA]), _beam(beam, rays[j, RAY_THETA]))
        loudest = max(edge_db - 20 * math.log10(max(half, 0.01)), floor_db[s])
        # 6 dB, because what is looked for lies between the rays.
        if best_db(air, 2 * half) + 2 * tx + reflect_db[s] + loudest + 6.0 > 0:
            open_ends[b, 0], open_ends[b, 1] = near, far
            b += 1
    return corners[:c], edges[:e], open_ends[:b]


@njit(cache=True)
def find_sounds(
    fan, rays, surface, piece, pieces, ends, corners, edges, radius_m, reflect_db, floor_db,
    air, beam, edge_db, reach_m, fan_sonar, sensor_xy_m, axis_rad, margin_rad, mirrors,
    alone, pulse_m,
):  # fmt: skip
    """Return the sounds that may be heard of the faces seen: (sounds, fan, listener, surface)."""
    sonars = axis_rad.size
    most = pieces.shape[0] * (2 + (1 if alone else sonars)) + corners.shape[0] + edges.shape[0]
    sounds = np.empty((most, SOUND_COLUMNS))
    sounds[:, SOUND_SEEN] = 0.0
    sounds[:, SOUND_QX] = sounds[:, SOUND_QY] = sounds[:, SOUND_BACK] = math.nan
    index = np.empty((most, 3), np.int64)
    m = 0

    for p in range(pieces.shape[0]):
        i = ends[p, 0]
        f, s = fan[i], surface[i]
        own = fan_sonar[f]
        loss = 2 * rays[i, RAY_LOSS] + reflect_db[s]
        low, high = pieces[p, PIECE_LOW], pieces[p, PIECE_HIGH]
        nx, ny = pieces[p, PIECE_NX], pieces[p, PIECE_NY]
        if radius_m[s] > 0:
            # A pillar: the foot of the perpendicular lies on the line to its centre.
            cx = pieces[p, PIECE_X] - radius_m[s] * nx
            cy = pieces[p, PIECE_Y] - radius_m[s] * ny
            half = _distance_to(rays, i, cx, cy) - radius_m[s]
            theta = _bearing_to(rays, i, cx, cy)
            share = max(10 * math.log10(radius_m[s] / (radius_m[s] + max(half, 0.0))), floor_db[s])
            level = way_db(air, 2 * half) + 2 * _beam(beam, theta) + loss + share
            if half <= reach_m and level + gain_db(air, 2 * half / air[0]) > 0:
                sounds[m, SOUND_WAY], sounds[m, SOUND_LEVEL] = 2 * half, level
                sounds[m, SOUND_THETA], sounds[m, SOUND_SEEN] = theta, half
                sounds[m, SOUND_INCIDENCE] = 0.0
                index[m, 0], index[m, 1], index[m, 2] = f, own, s
                m += 1
            continue

        # The mirror's echo comes from the foot of the perpendicular.
        half = (rays[i, RAY_IX] - pieces[p, PIECE_X]) * nx
        half += (rays[i, RAY_IY] - pieces[p, PIECE_Y]) * ny
        foot = _bearing_to(rays, i, rays[i, RAY_IX] - nx, rays[i, RAY_IY] - ny)
        plane = way_db(air, 2 * half) + 2 * _beam(beam, foot) + loss
        level = 10 * math.log10(10 ** (plane / 10) + 10 ** ((plane + floor_db[s]) / 10))
        if (
            low - margin_rad < foot < high + margin_rad
            and half <= reach_m
            and level + gain_db(air, 2 * half / air[0]) > 0
        ):
            sounds[m, SOUND_WAY], sounds[m, SOUND_LEVEL] = 2 * half, level
            sounds[m, SOUND_THETA] = foot
            sounds[m, SOUND_SEEN] = 0.0 if low <= foot <= high else half
            sounds[m, SOUND_INCIDENCE] = 0.0
            index[m, 0], index[m, 1], index[m, 2] = f, own, s
            m += 1

        # What the face scatters: the first moment at which some place of it is loud enough.
        nearest = min(max(foot, low), high)
        if best_db(air, 2 * half) + loss + floor_db[s] > 0:
            first, place, loudness = math.inf, 0.0, 0.0
            steps = max(1, math.ceil((high - low) / _SCATTER_STEP_RAD))
            for k in range(-1, steps + 1):
                theta = nearest if k < 0 else low + (high - low) * k / steps
                cos = math.cos(theta - foot)
                if cos < 1e-3:
                    continue
                r = half / cos
                if r > reach_m or r >= first:
                    continue
                level = way_db(air, 2 * r) + 2 * _beam(beam, theta) + loss + floor_db[s]
                level += 20 * math.log10(cos)
                over = level + gain_db(air, 2 * r / air[0])
                if over > 0 and r + pulse_m * 10 ** (-over / 20) < first:
                    first = r + pulse_m * 10 ** (-over / 20)
                    place, loudness = theta, level
            if first < math.inf:
                sounds[m, SOUND_WAY] = 2 * half / math.cos(place - foot)
                sounds[m, SOUND_LEVEL], sounds[m, SOUND_THETA] = loudness, place
                sounds[m, SOUND_INCIDENCE] = abs(place - foot)
                index[m, 0], index[m, 1], index[m, 2] = f, own, s
                m += 1

        # Ways that end elsewhere than they began: the image of the image, seen by the listener.
        ix, iy = rays[i, RAY_IX] - 2 * half * nx, rays[i, RAY_IY] - 2 * half * ny
        for sonar in range(own if alone else 0, own + 1 if alone else sonars):
            if sonar == own:
                # Of two faces at a right angle the corner is told already.
                square = abs(rays[i, RAY_MX] * nx + rays[i, RAY_MY] * ny) < _RIGHT_ANGLE
                if mirrors == 0 or square:
                    continue
            x, y = sensor_xy_m[sonar, 0], sensor_xy_m[sonar, 1]
            height = (x - pieces[p, PIECE_X]) * nx + (y - pieces[p, PIECE_Y]) * ny
            if height <= 0 or half <= 0:
                continue
            way = math.hypot(ix - x, iy - y)
            if way > 2 * reach_m:
                continue
            share = height / (height + half)
            qx, qy = x + share * (ix - x), y + share * (iy - y)
            theta = _bearing_to(rays, i, qx, qy)
            if not low - margin_rad < theta < high + margin_rad:
                continue
            arrival = math.atan2(qy - y, qx - x) - axis_rad[sonar]
            level = way_db(air, way) + _beam(beam, theta) + _beam(beam, arrival)
            # Each mirror is passed once on such a way.
            level += rays[i, RAY_LOSS] + reflect_db[s]
            over = gain_db(air, min(way / air[0] + air[7], air[6]))
            if level + over <= 0:
                continue
            sounds[m, SOUND_WAY], sounds[m, SOUND_LEVEL] = way, level
            sounds[m, SOUND_THETA] = theta
            seen = _distance_to(rays, i, qx, qy)
            sounds[m, SOUND_SEEN] = 0.0 if low <= theta <= high else seen
            sounds[m, SOUND_QX], sounds[m, SOUND_QY] = qx, qy
            sounds[m, SOUND_BACK] = math.hypot(qx - x, qy - y)
            sounds[m, SOUND_INCIDENCE] = math.acos(min(1.0, height / sounds[m, SOUND_BACK]))
            index[m, 0], index[m, 1], index[m, 2] = f, sonar, s
            m += 1

    for hollow in range(2):
        table = corners if hollow else edges
        for k in range(table.shape[0]):
            i = int(table[k, 0])
            x, y = table[k, 1], table[k, 2]
            s, half = surface[i], _distance_to(rays, i, x, y)
            theta = _bearing_to(rays, i, x, y)
            level = way_db(air, 2 * half) + 2 * _beam(beam, theta)
            level += 2 * rays[i, RAY_LOSS] + reflect_db[s]
            if hollow:
                level += reflect_db[surface[i + 1]]
            else:
                level += edge_db - 20 * math.log10(max(half, 0.01))
            if half > reach_m or level + gain_db(air, 2 * half / air[0]) <= 0:
                continue
            sounds[m, SOUND_WAY], sounds[m, SOUND_LEVEL] = 2 * half, level
            sounds[m, SOUND_THETA], sounds[m, SOUND_SEEN] = theta, half
            p = piece[i]
            cos = (rays[i, RAY_IX] - x) * pieces[p, PIECE_NX]
            cos += (rays[i, RAY_IY] - y) * pieces[p, PIECE_NY]
            sounds[m, SOUND_INCIDENCE] = math.acos(min(1.0, max(0.0, cos / max(half, 1e-9))))
            index[m, 0], index[m, 1], index[m, 2] = fan[i], fan_sonar[fan[i]], s
            m += 1
    return sounds[:m], index[:m]


@njit(cache=True)
def mirrored_rays(fan, number, rays, leg_m, normal, surface, piece, radius_m, reflect_db,
                  air, beam, reach_m):  # fmt: skip
    """Return (fan, group, number, rays) of the rays that a flat face mirrors on and may matter."""
    n = surface.size
    keep = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        s = surface[i]
        if s < 0 or radius_m[s] > 0:
            continue  # a pillar spreads the sound too far
        way = rays[i, RAY_WAY] + leg_m[i]
        loss = rays[i, RAY_LOSS] + reflect_db[s]
        if way >= reach_m:
            continue
        one_way = _beam(beam, rays[i, RAY_THETA])
        left = best_db(air, 2 * way) + one_way + loss
        # There and back each mirror is passed twice.
        if left + one_way + loss > 0 or (left > 0 and number[i] % _THINNED == 0):
            keep[count] = i
            count += 1
    keep = keep[:count]
    out = rays[keep]
    for k in range(count):
        i = keep[k]
        nx, ny = normal[i, 0], normal[i, 1]
        x = rays[i, RAY_X] + leg_m[i] * rays[i, RAY_DX]
        y = rays[i, RAY_Y] + leg_m[i] * rays[i, RAY_DY]
        out[k, RAY_X], out[k, RAY_Y] = x + _OFF_SURFACE_M * nx, y + _OFF_SURFACE_M * ny
        along = rays[i, RAY_DX] * nx + rays[i, RAY_DY] * ny
        out[k, RAY_DX] = rays[i, RAY_DX] - 2 * along * nx
        out[k, RAY_DY] = rays[i, RAY_DY] - 2 * along * ny
        height = (rays[i, RAY_IX] - x) * nx + (rays[i, RAY_IY] - y) * ny
        out[k, RAY_IX] = rays[i, RAY_IX] - 2 * height * nx
        out[k, RAY_IY] = rays[i, RAY_IY] - 2 * height * ny
        out[k, RAY_WAY] = rays[i, RAY_WAY] + leg_m[i]
        out[k, RAY_SIGN] = -rays[i, RAY_SIGN]
        out[k, RAY_LOSS] = rays[i, RAY_LOSS] + reflect_db[surface[i]]
        out[k, RAY_MX], out[k, RAY_MY] = nx, ny
    return fan[keep], piece[keep], number[keep], out


@njit(cache=True)
def first_crossings(
    fired_s, fired_sonar, window_s, sent_s, source, listener, way_m, level_db, life_s,
    air, pulse_s, blanking_s,
):  # fmt: skip
    """Return of each firing (sound that is heard first or -1, time of hearing, its level)."""
    n = fired_s.size
    heard = np.full(n, -1, np.int64)
    time_s, over_db = np.full(n, math.inf), np.full(n, math.nan)
    for r in range(n):
        for k in range(way_m.size):
            if listener[k] != fired_sonar[r]:
                continue
            travel = way_m[k] / air[0]
            if travel > life_s:
                continue
            arrival = sent_s[k] + travel - fired_s[r]
            if arrival <= 0 or arrival > window_s:
                continue
            over = level_db[k] + gain_db(air, arrival)
            if over <= 0:
                continue
            crossing = arrival + pulse_s * 10 ** (-over / 20)
            if crossing < blanking_s:
                if arrival + pulse_s < blanking_s:
                    continue  # over before the receiver opens
                crossing = blanking_s
            if crossing <= window_s and crossing < time_s[r]:
                heard[r], time_s[r], over_db[r] = k, crossing, over
    return heard, time_s, over_db
