"""Compiled: how far flat faces go on, on each of their sides, until something ends them.

A face goes on over joints with flush ones. It ends where nothing follows it or what follows turns
away; and where another face stands on it. That one, in a right-angled or sharper corner, mirrors
the face on as far as it is high: a wall beside a large wall ends nowhere, and the back of a flat
recess ends where the recess does.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical.images import columns as c
from sonarmap.kernels.jit import njit

__all__ = ["Joints", "arm_reaches", "extent", "face_stops"]

# A walk along flush faces takes so many steps at most. Farther from a face's ends than this its
# extent is not followed: at 5 m the zone that matters ends before.
_MOST_STEPS, _FAR_M = 100, 1.0
# A stop so little beyond a place still lies on its own side of it.
_AT_M = 1e-7


class Joints(NamedTuple):
    """Where faces end, meet or cross, all such places, flush joints among them.

    Parameters
    ----------
    at_m : ndarray, shape (places, 2)
        Where they are.
    start, arms, arm_face : ndarray
        Their arms, see `sim.sonar.physical.images.room.ImageRoom`.
    face_start : ndarray of int64, shape (faces + 1,)
        Where the places on each face begin.
    along_m : ndarray
        How far from the face's begin each of them lies, rising.
    place : ndarray of int64
        Which each is.
    """

    at_m: NDArray[np.float64]
    start: NDArray[np.int64]
    arms: NDArray[np.float64]
    arm_face: NDArray[np.int64]
    face_start: NDArray[np.int64]
    along_m: NDArray[np.float64]
    place: NDArray[np.int64]


@njit(error_model="numpy", makes_arrays=False)
def extent(faces, stops, i, height, foot_m, at_m):
    """Return how far a face goes on before and behind a place of it, metres, <= 0 and >= 0.

    Parameters
    ----------
    i : int
        The face.
    height : float
        Of who sees it, over the face: the sign tells the side.
    foot_m, at_m : float
        Their foot of the perpendicular, and the place, from the face's begin.
    """
    first, last = int(faces[i, c.FIRST_STOP]), int(faces[i, c.MIDDLE_STOP])
    if height < 0:
        first, last = last, int(faces[i, c.LAST_STOP])
    low_m, high_m, low_depth_m, high_depth_m = -math.inf, math.inf, 0.0, 0.0
    for k in range(first, last):
        stop_m = stops[k, c.STOP_AT]
        if stops[k, c.STOP_SIDE] > 0:
            if at_m - _AT_M <= stop_m < high_m:
                high_m, high_depth_m = stop_m, stops[k, c.STOP_DEPTH]
        elif low_m < stop_m <= at_m + _AT_M:
            low_m, low_depth_m = stop_m, stops[k, c.STOP_DEPTH]
    low_m = foot_m - _mirrored_on(foot_m - low_m, low_depth_m, abs(height))
    high_m = foot_m + _mirrored_on(high_m - foot_m, high_depth_m, abs(height))
    return min(low_m - at_m, 0.0), max(high_m - at_m, 0.0)


@njit(error_model="numpy", makes_arrays=False)
def _mirrored_on(gap_m, depth_m, height_m):
    """Return how far a face goes on that ends at another one so high, seen from a height."""
    if gap_m <= 0 or depth_m == 0:
        return gap_m
    return gap_m * height_m / (height_m - depth_m) if depth_m < height_m else math.inf


@njit()
def face_stops(joints, normals, outward, right_angle, flush):
    """Return (stops, first, middle and last of each face): those on the side of its normal first.

    Parameters
    ----------
    joints : Joints
    normals, outward : ndarray, shapes (faces, 2), (faces,)
        Of the faces; on the inside of a solid nobody stands.
    right_angle, flush : float
        Sines of angles that are as good as none.
    """
    ranges = np.zeros((len(normals), 3), np.int64)
    stops = np.empty((64, c.STOP_COLUMNS))
    count = 0
    for i in range(len(normals)):
        first, last = joints.face_start[i], joints.face_start[i + 1]
        for side in (1.0, -1.0):
            ranges[i, 0 if side > 0 else 1] = count
            if outward[i] * side < 0:
                continue
            for way in (1.0, -1.0):
                dx, dy = -normals[i, 1] * way, normals[i, 0] * way
                end = last - 1 if way > 0 else first
                for k in range(first, last):
                    v, at_m = joints.place[k], joints.along_m[k]
                    arm, angle = _next_arm(joints, v, dx, dy, side * way)
                    if _goes_on(arm, angle, flush):
                        if k != end:
                            continue
                        beyond_m, arm, angle, is_found = _walk(joints, v, arm, side * way, flush)
                        if not is_found:
                            continue
                        at_m += way * beyond_m
                    if count == len(stops):
                        more = np.empty((2 * count, c.STOP_COLUMNS))
                        more[:count] = stops
                        stops = more
                    stops[count, c.STOP_AT], stops[count, c.STOP_SIDE] = at_m, way
                    stops[count, c.STOP_DEPTH] = _depth(
                        joints, arm, angle, side * way, right_angle, flush
                    )
                    count += 1
        ranges[i, 2] = count
    return stops[:count].copy(), ranges


@njit()
def arm_reaches(joints, flush):
    """Return how far each arm goes on, seen from the left of it and from the right, metres."""
    reaches = np.empty((len(joints.arms), 2))
    for v in range(len(joints.start) - 1):
        for arm in range(joints.start[v], joints.start[v + 1]):
            for side in range(2):
                far_m, _, _, _ = _walk(joints, v, arm, -1.0 if side == 0 else 1.0, flush)
                reaches[arm, side] = far_m
    return reaches


@njit()
def _next_arm(joints, v, dx, dy, turn):
    """Return (arm or -1, angle): what follows at a place to which one comes in a direction.

    It is the first arm after the one that one came by, counter-clockwise if `turn` is 1, clockwise
    if it is -1; the side of the face that is looked at lies between the two.
    """
    first, least = -1, 2 * math.pi - 1e-6
    for k in range(joints.start[v], joints.start[v + 1]):
        ax, ay = joints.arms[k, 0], joints.arms[k, 1]
        angle = math.atan2(turn * (dy * ax - dx * ay), -(dx * ax + dy * ay))
        if angle < 0:
            angle += 2 * math.pi
        if 1e-6 < angle < least:
            first, least = k, angle
    return first, least


@njit()
def _goes_on(arm, angle, flush):
    return arm >= 0 and abs(angle - math.pi) < flush


@njit()
def _walk(joints, v, arm, turn, flush):
    """Return (how far, arm that follows there or -1, its angle, whether that is an end).

    One goes along an arm of a place, and on over flush ones.
    """
    far_m = 0.0
    for _ in range(_MOST_STEPS):
        i, dx, dy = joints.arm_face[arm], joints.arms[arm, 0], joints.arms[arm, 1]
        v, step_m = _next_place(joints, i, v, dx, dy)
        far_m += step_m
        arm, angle = _next_arm(joints, v, dx, dy, turn)
        if not _goes_on(arm, angle, flush):
            return far_m, arm, angle, True
        if far_m > _FAR_M:
            break
    return math.inf, -1, 0.0, False


@njit()
def _next_place(joints, i, v, dx, dy):
    """Return (place, how far away) of the next place on a face in a direction; or the same, 0."""
    first, last = joints.face_start[i], joints.face_start[i + 1]
    for k in range(first, last):
        if joints.place[k] == v:
            for way in (1, -1):
                m = k + way
                if first <= m < last:
                    w = joints.place[m]
                    px = joints.at_m[w, 0] - joints.at_m[v, 0]
                    py = joints.at_m[w, 1] - joints.at_m[v, 1]
                    if px * dx + py * dy > 0:
                        return w, abs(joints.along_m[m] - joints.along_m[k])
    return v, 0.0


@njit()
def _depth(joints, arm, angle, turn, right_angle, flush):
    """Return how high over a face the one is that ends it, if the corner mirrors; else 0."""
    if arm < 0 or angle > math.pi / 2 + right_angle:
        return 0.0
    v = np.searchsorted(joints.start, arm, side="right") - 1
    far_m, _, _, _ = _walk(joints, v, arm, turn, flush)
    return far_m * math.sin(angle)
