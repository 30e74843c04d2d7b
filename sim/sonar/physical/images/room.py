"""`ImageRoom`: what a room offers to image sources, prepared once and kept with its faces.

Beside the faces themselves: on which side each of them can be met, the vertices where faces end,
meet or cross, and which things stand before which mirror.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical.images import columns as c
from sim.sonar.physical.images.extents import Joints, arm_reaches, face_stops
from sonarmap.kernels.jit import njit
from worlds import World
from worlds.faces import Faces
from worlds.facetable import FaceTable

__all__ = ["FLUSH", "RIGHT_ANGLE", "SAME_PLACE_M", "ImageRoom", "Scene", "image_room", "scene_of"]

SAME_PLACE_M = 1e-4
"""Places so near to each other are one: walls that are drawn to touch may miss by rounding."""
RIGHT_ANGLE = math.sin(math.radians(2.0))
"""Two faces send back like a mirror if they make a right angle to this; assumed."""
FLUSH = 1e-3
"""Two faces at a vertex are flush if the sine of the angle between them is smaller."""
# A room of more things than this has no lists of what stands before a mirror: they would grow
# with the square of it.
_MOST_LISTED = 2000


class Scene(NamedTuple):
    """A room and what it is made of, as compiled image sources take it.

    Parameters
    ----------
    faces, points, arms, stops : ndarray
        Segments; pillars and vertices, pillars first; arms of vertices; stops of segments: see the
        columns.
    before : ndarray of int32
        Numbers of the things that stand before each mirror: segments first, then points.
    is_listed : bool
        Whether there are such lists.
    rays : tuple of ndarray
        Of the face table, what a ray needs: segments, circles, grid, shape, cells.
    """

    faces: NDArray[np.float64]
    points: NDArray[np.float64]
    arms: NDArray[np.float64]
    stops: NDArray[np.float64]
    before: NDArray[np.int32]
    is_listed: bool
    rays: tuple[NDArray[np.generic], ...]


class ImageRoom(NamedTuple):
    """What a room offers to image sources, whatever it is made of.

    Things are numbered segments first, then circles, then vertices.

    Parameters
    ----------
    outward : ndarray of int8, shape (s,)
        Side on which a segment's outside lies: 1 that of its normal, -1 the other, 0 unknown.
    vertices : ndarray, shape (v, 2)
        Places where flat faces end, meet or cross, but for those in the middle of flush faces.
    arm_start : ndarray of int64, shape (v + 1,)
        Where the arms of each vertex begin.
    arms : ndarray, shape (n, 2)
        Unit vectors from a vertex along the faces that touch it, counter-clockwise.
    arm_face : ndarray of int64, shape (n,)
        The segment of each arm.
    arm_reach_m : ndarray, shape (n, 2)
        How far it goes on, seen from its left and from its right; +inf for far.
    stops : ndarray, shape (m, STOP_COLUMNS)
        Where segments end, see `sim.sonar.physical.images.extents`.
    stop_ranges : ndarray of int64, shape (s, 3)
        Where those of each segment begin, those on its other side, and where these end.
    before_start : ndarray of int64, shape (s + 1,)
        Where the list of each mirror begins in `before`; empty if `is_listed` is False.
    before : ndarray of int32
        Numbers of the things that stand before each mirror, mirror by mirror.
    is_listed : bool
        Whether there are lists.
    """

    outward: NDArray[np.int8]
    vertices: NDArray[np.float64]
    arm_start: NDArray[np.int64]
    arms: NDArray[np.float64]
    arm_face: NDArray[np.int64]
    arm_reach_m: NDArray[np.float64]
    stops: NDArray[np.float64]
    stop_ranges: NDArray[np.int64]
    before_start: NDArray[np.int64]
    before: NDArray[np.int32]
    is_listed: bool


def image_room(faces: Faces) -> ImageRoom:
    """Return what a room offers; it is computed once and kept with the faces."""
    kept: ImageRoom | None = faces.__dict__.get("image_room")
    if kept is None:
        kept = faces.__dict__["image_room"] = _prepare(faces)
    return kept


def scene_of(faces: Faces, world: World) -> Scene:
    """Return faces, made of what a world's surfaces are made of, for compiled code."""
    room, table = image_room(faces), faces.table
    mirror_db = 20 * np.log10(np.maximum(world.reflectivity, 1e-10))
    flat = len(table.segments)
    of_face, of_circle = table.surface[:flat], table.surface[flat:]
    packed = np.empty((flat, c.FACE_COLUMNS))
    packed[:, c.X0 : c.Y1 + 1] = table.segments
    packed[:, c.NORMAL_X : c.NORMAL_Y + 1] = table.normals
    packed[:, c.OUTWARD], packed[:, c.SURFACE] = room.outward, of_face
    packed[:, c.MIRROR], packed[:, c.FLOOR] = mirror_db[of_face], world.diffuse_floor_db[of_face]
    packed[:, c.FIRST], packed[:, c.LAST] = room.before_start[:-1], room.before_start[1:]
    # Segments come first in a list.
    is_flat = np.concatenate([[0], np.cumsum(room.before < flat)])
    packed[:, c.FIRST_POINT] = room.before_start[:-1] + (
        is_flat[room.before_start[1:]] - is_flat[room.before_start[:-1]]
    )
    packed[:, c.FIRST_STOP : c.LAST_STOP + 1] = room.stop_ranges
    round_ = len(table.circles)
    points = np.zeros((round_ + len(room.vertices), c.POINT_COLUMNS))
    points[:round_, c.POINT_X : c.RADIUS + 1] = table.circles
    points[:round_, c.POINT_MIRROR] = mirror_db[of_circle]
    points[:round_, c.POINT_FLOOR] = world.diffuse_floor_db[of_circle]
    points[:round_, c.POINT_SURFACE] = of_circle
    points[round_:, c.POINT_X : c.POINT_Y + 1] = room.vertices
    points[round_:, c.FIRST_ARM], points[round_:, c.LAST_ARM] = (
        room.arm_start[:-1],
        room.arm_start[1:],
    )
    points[round_:, c.IS_CORNER] = _are_corners(room.arm_start, room.arms)
    return Scene(
        packed,
        points,
        np.column_stack([room.arms, room.arm_face, room.arm_reach_m]),
        room.stops,
        room.before,
        room.is_listed,
        (
            table.segments,
            table.circles,
            table.grid,
            table.shape,
            table.cell_start,
            table.cell_face,
        ),
    )


def _prepare(faces: Faces) -> ImageRoom:
    table = faces.table
    outward = _outward(faces)
    ends = table.segments.reshape(-1, 2)
    places = _distinct(np.concatenate([ends, _crossings(*_grid(table), table.segments)]))
    counts, arms, arm_face = _arms(*_grid(table), table.segments, table.normals, places)
    start = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    joints = _joints(table, places, start, arms, arm_face)
    stops, stop_ranges = face_stops(joints, table.normals, outward, RIGHT_ANGLE, FLUSH)
    reach_m = arm_reaches(joints, FLUSH)
    matters = _matter(start, arms)
    of_arm = np.repeat(matters, counts)
    vertices, arms, arm_face, reach_m = (
        places[matters],
        arms[of_arm],
        arm_face[of_arm],
        reach_m[of_arm],
    )
    start = np.concatenate([[0], np.cumsum(counts[matters])]).astype(np.int64)
    is_listed = len(table.segments) + len(table.circles) + len(vertices) <= _MOST_LISTED
    if is_listed:
        before_start, before = _before(
            table.segments, table.normals, table.circles, outward, vertices
        )
    else:
        before_start, before = np.zeros(len(outward) + 1, np.int64), np.empty(0, np.int32)
    return ImageRoom(
        outward,
        vertices,
        start,
        arms,
        arm_face,
        reach_m,
        stops,
        stop_ranges,
        before_start,
        before,
        is_listed,
    )


def _joints(
    table: FaceTable,
    places: NDArray[np.float64],
    start: NDArray[np.int64],
    arms: NDArray[np.float64],
    arm_face: NDArray[np.int64],
) -> Joints:
    """Return all places with their arms, and the places on each face in their order."""
    pairs = np.unique(
        np.column_stack([arm_face, np.repeat(np.arange(len(places)), np.diff(start))]), axis=0
    )
    face, place = pairs[:, 0], pairs[:, 1]
    begin, normal = table.segments[face, :2], table.normals[face]
    offset = places[place] - begin
    along_m = offset[:, 1] * normal[:, 0] - offset[:, 0] * normal[:, 1]
    order = np.lexsort([along_m, face])
    face_start = np.searchsorted(face, np.arange(len(table.segments) + 1))
    return Joints(
        places,
        start,
        arms,
        arm_face,
        face_start,
        along_m[order],
        np.ascontiguousarray(place[order]),
    )


def _outward(faces: Faces) -> NDArray[np.int8]:
    """Return the side of each segment's outside; the rings of solids tell it.

    A solid's first ring is its outline, the others are its holes. The normal of a segment lies on
    the right of its way, so outside of a ring that runs counter-clockwise.
    """
    segments, surface = faces.segments_m, faces.segment_surface
    outward = np.zeros(len(segments), np.int8)
    first, last_surface, is_hole = 0, -1, False
    for i in range(len(segments)):
        ends = i + 1 == len(segments) or surface[i + 1] != surface[i]
        if not ends and (segments[i, 2:] == segments[i + 1, :2]).all():
            continue
        ring = segments[first : i + 1]
        is_hole = bool(surface[i] == last_surface)
        if (ring[-1, 2:] == ring[0, :2]).all():
            area = (ring[:, 0] * ring[:, 3] - ring[:, 2] * ring[:, 1]).sum()
            outward[first : i + 1] = np.sign(area) * (-1 if is_hole else 1)
        first, last_surface = i + 1, int(surface[i])
    return outward


def _distinct(places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return places without those that are the same as an earlier one, in their order."""
    order = np.argsort(places[:, 0], kind="stable")
    distinct: NDArray[np.float64] = places[_first_of_each(places, order)]
    return distinct


def _grid(table: FaceTable) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64],
                                     NDArray[np.int64]]:  # fmt: skip
    return table.grid, table.shape, table.cell_start, table.cell_face


@njit()
def _first_of_each(places, order):
    n = len(order)
    same_as = np.arange(n)
    for a in range(n):
        i = order[a]
        for b in range(a + 1, n):
            j = order[b]
            if places[j, 0] - places[i, 0] > SAME_PLACE_M:
                break
            if abs(places[j, 1] - places[i, 1]) <= SAME_PLACE_M:
                low, high = min(same_as[i], same_as[j]), max(i, j)
                same_as[high] = min(same_as[high], low)
    return same_as == np.arange(n)


@njit()
def _crossings(grid, shape, cell_start, cell_face, segments):
    """Return the places where segments cross."""
    places = np.empty((64, 2))
    count = 0
    for at in range(shape[0, 0] * shape[0, 1]):
        for a in range(cell_start[at], cell_start[at + 1]):
            i = cell_face[a]
            if i >= len(segments):
                continue
            x, y = segments[i, 0], segments[i, 1]
            ex, ey = segments[i, 2] - x, segments[i, 3] - y
            for b in range(a + 1, cell_start[at + 1]):
                j = cell_face[b]
                if j >= len(segments):
                    continue
                fx, fy = segments[j, 2] - segments[j, 0], segments[j, 3] - segments[j, 1]
                cross = ex * fy - ey * fx
                if abs(cross) <= 1e-9 * math.hypot(ex, ey) * math.hypot(fx, fy):
                    continue
                ax, ay = segments[j, 0] - x, segments[j, 1] - y
                one, other = (ax * fy - ay * fx) / cross, (ax * ey - ay * ex) / cross
                if not (0.0 < one < 1.0 and 0.0 < other < 1.0):
                    continue
                if count == len(places):
                    more = np.empty((2 * count, 2))
                    more[:count] = places
                    places = more
                places[count, 0], places[count, 1] = x + one * ex, y + one * ey
                count += 1
    return places[:count]


@njit()
def _arms(grid, shape, cell_start, cell_face, segments, normals, places):
    """Return how many arms each place has, their directions and their faces.

    Directions are sorted counter-clockwise.
    """
    left, bottom, cell = grid[0]
    rows, cols = shape[0, 0], shape[0, 1]
    counts = np.zeros(len(places), np.int64)
    arms, arm_face = np.empty((64, 2)), np.empty(64, np.int64)
    count = 0
    for v in range(len(places)):
        x, y = places[v]
        first = count
        low_col = max(math.floor((x - SAME_PLACE_M - left) / cell), 0)
        high_col = min(math.floor((x + SAME_PLACE_M - left) / cell), cols - 1)
        low_row = max(math.floor((y - SAME_PLACE_M - bottom) / cell), 0)
        high_row = min(math.floor((y + SAME_PLACE_M - bottom) / cell), rows - 1)
        for row in range(low_row, high_row + 1):
            for col in range(low_col, high_col + 1):
                at = row * cols + col
                for k in range(cell_start[at], cell_start[at + 1]):
                    i = cell_face[k]
                    if i >= len(segments) or (arm_face[first:count] == i).any():
                        continue
                    # Along the segment with its normal on the right, and off it.
                    tx, ty = -normals[i, 1], normals[i, 0]
                    ax, ay = x - segments[i, 0], y - segments[i, 1]
                    ex, ey = segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
                    length, along = math.hypot(ex, ey), ax * tx + ay * ty
                    if abs(ax * normals[i, 0] + ay * normals[i, 1]) > SAME_PLACE_M:
                        continue
                    if not -SAME_PLACE_M <= along <= length + SAME_PLACE_M:
                        continue
                    if count + 2 > len(arm_face):
                        more, more_face = np.empty((2 * count, 2)), np.empty(2 * count, np.int64)
                        more[:count], more_face[:count] = arms[:count], arm_face[:count]
                        arms, arm_face = more, more_face
                    if along < length - SAME_PLACE_M:
                        arms[count, 0], arms[count, 1], arm_face[count] = tx, ty, i
                        count += 1
                    if along > SAME_PLACE_M:
                        arms[count, 0], arms[count, 1], arm_face[count] = -tx, -ty, i
                        count += 1
        counts[v] = count - first
        angle = np.arctan2(arms[first:count, 1], arms[first:count, 0])
        order = np.argsort(angle, kind="mergesort")
        arms[first:count] = arms[first:count][order]
        arm_face[first:count] = arm_face[first:count][order]
    return counts, arms[:count].copy(), arm_face[:count].copy()


@njit()
def _matter(start, arms):
    """Return which places are more than the middle of flush faces."""
    matters = np.zeros(len(start) - 1, np.bool_)
    for v in range(len(matters)):
        for a in range(start[v], start[v + 1]):
            sine = arms[start[v], 0] * arms[a, 1] - arms[start[v], 1] * arms[a, 0]
            if abs(sine) > FLUSH:
                matters[v] = True
        # All arms on one line, all to one side: the end of something thin.
        if not matters[v] and start[v + 1] > start[v]:
            along = arms[start[v]]
            alone = True
            for a in range(start[v], start[v + 1]):
                alone = alone and along[0] * arms[a, 0] + along[1] * arms[a, 1] > 0
            matters[v] = alone
    return matters


@njit()
def _are_corners(start, arms):
    """Return which vertices have two arms in a row at a right angle, with nothing between them."""
    are = np.zeros(len(start) - 1, np.bool_)
    for v in range(len(are)):
        count = start[v + 1] - start[v]
        for k in range(count):
            a, b = arms[start[v] + k], arms[start[v] + (k + 1) % count]
            is_left = a[0] * b[1] - a[1] * b[0] > 0
            if count > 1 and is_left and abs(a[0] * b[0] + a[1] * b[1]) < RIGHT_ANGLE:
                are[v] = True
    return are


@njit()
def _before(segments, normals, circles, outward, vertices):
    """Return (where each mirror's list begins, numbers of the things that stand before it).

    A segment stands before a mirror only if the mirror stands before it, too.
    """
    s, c, n = len(segments), len(circles), len(segments) + len(circles) + len(vertices)
    start = np.zeros(s + 1, np.int64)
    before = np.empty(0, np.int32)
    for writes in (False, True):
        count = 0
        for k in range(s):
            for i in range(n):
                if i < s:
                    stands = (
                        i != k
                        and _is_before(segments, normals, outward, k, i)
                        and _is_before(segments, normals, outward, i, k)
                    )
                else:
                    if i < s + c:
                        x, y, beyond = circles[i - s]
                    else:
                        x, y, beyond = vertices[i - s - c, 0], vertices[i - s - c, 1], 0.0
                    height = _height(segments, normals, k, x, y)
                    stands = outward[k] == 0 or outward[k] * height + beyond > SAME_PLACE_M
                if stands:
                    if writes:
                        before[count] = i
                    count += 1
            start[k + 1] = count
        if not writes:
            before = np.empty(count, np.int32)
    return start, before


@njit()
def _height(segments, normals, k, x, y):
    return (x - segments[k, 0]) * normals[k, 0] + (y - segments[k, 1]) * normals[k, 1]


@njit()
def _is_before(segments, normals, outward, k, i):
    """Return whether a part of segment `i` lies on the outside of segment `k`."""
    if outward[k] == 0:
        return True
    one = outward[k] * _height(segments, normals, k, segments[i, 0], segments[i, 1])
    other = outward[k] * _height(segments, normals, k, segments[i, 2], segments[i, 3])
    return max(one, other) > SAME_PLACE_M
