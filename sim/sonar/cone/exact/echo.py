"""The echo of an exact cone: the nearest place that returns sound, straight or over mirrors.

A beam is cut into the intervals in which one face is seen. Of each, the part that is met within
the critical angle returns sound, from its nearest place; the parts beyond it mirror the beam on.
No beam is followed farther than the nearest echo so far.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.sonar.cone.exact import visible
from sim.sonar.cone.exact.beam import (
    BEGIN_NX,
    BEGIN_NY,
    BEGIN_OFF,
    BOUNCES,
    FACE,
    FIRST_PILLAR,
    HIGH,
    LOW,
    NARROWEST,
    NEAREST,
    ON_PILLAR,
    PILLARS,
    PLACE_X,
    PLACE_Y,
    STRENGTH,
    X_OF_X,
    X_OF_Y,
    Y_OF_X,
    Y_OF_Y,
    first_beam,
    ray_of,
    unfold,
)
from sim.sonar.cone.exact.beam import COLUMNS as BEAM_COLUMNS
from sim.sonar.cone.exact.gathering import first_reach, gather
from sim.sonar.cone.exact.meeting import COLUMNS as FACE_COLUMNS
from sim.sonar.cone.exact.meeting import (
    E_X,
    E_Y,
    FROM,
    FROM_INSIDE,
    HEIGHT,
    KIND,
    LENGTH,
    NEAR_0,
    NEAR_1,
    NEAREST_M,
    NUMBER,
    PILLAR,
    RADIUS,
    SEGMENT,
    TO,
    X,
    Y,
    beyond_mirror,
    circle_in,
    in_frame,
    lie_straight,
    nearest_straight,
    outside_of_pillar,
    returning_straight,
    segment_behind_pillar,
    slope_at_sine,
    way,
)
from sonarmap.kernels.jit import njit

__all__ = ["ExactEchoes", "exact_echoes", "hear_all", "hear_ring"]

# Of paths that differ by less, as those to the corner of two faces do, counts the one over fewer
# mirrors, then that to the face met more steeply.
_SAME_M = 1e-12
# What cannot lie in a beam is farther outside than this; metres, and sines.
_SLACK_M = 1e-6
# The part of a visible piece that returns sound, after the columns of `visible`.
_RETURNS_FROM, _RETURNS_TO = 3, 4


class ExactEchoes(NamedTuple):
    """What k transducers detect, arrays of shape (k,).

    Parameters
    ----------
    echo_m : ndarray
        Range of the first return, inf for none.
    surface, bounces : ndarray of int
        What sent it, -1 for none, and over how many mirrors.
    incidence_rad : ndarray
        Angle of incidence there, NaN for none.
    axis_range_m, cone_range_m : ndarray
        True ranges on the axis and of the nearest surface in the cone, inf for none.
    """

    echo_m: NDArray[np.float64]
    surface: NDArray[np.int32]
    incidence_rad: NDArray[np.float64]
    bounces: NDArray[np.int16]
    axis_range_m: NDArray[np.float64]
    cone_range_m: NDArray[np.float64]


@njit(error_model="numpy")
def exact_echoes(k):
    """Return k echoes of nothing."""
    return ExactEchoes(
        np.full(k, np.inf),
        np.full(k, -1, np.int32),
        np.full(k, np.nan),
        np.zeros(k, np.int16),
        np.full(k, np.inf),
        np.full(k, np.inf),
    )


@njit(error_model="numpy")
def hear_all(table, room, places, axes, half_rad, limits, critical_cos, reflectivity):
    """Return what transducers anywhere in a room detect; see `hear_ring`."""
    echoes = exact_echoes(axes.size)
    for k in range(axes.size):
        x, y = places[k, 0], places[k, 1]
        _hear(
            table, room, x, y, 0.0, places, axes, k, k + 1, half_rad, limits,
            critical_cos, reflectivity, echoes,
        )  # fmt: skip
    return echoes


@njit(error_model="numpy")
def hear_ring(
    table, room, x, y, around_m, places, axes, half_rad, limits, critical_cos, reflectivity
):
    """Return what transducers within `around_m` of a place detect, each by itself.

    Parameters
    ----------
    table, room : FaceTable, int
        The faces.
    x, y, around_m : float
        The place.
    places, axes : ndarray, shapes (k, 2), (k,)
        Of the transducers.
    half_rad : float
        Half angle of the cones.
    limits : tuple
        How far (metres), over how many mirrors and how weak sound is traced.
    critical_cos, reflectivity : ndarray, shape (surfaces,)
        See `sim.sonar.cone.kernel.Surfaces`.
    """
    echoes = exact_echoes(axes.size)
    _hear(
        table, room, x, y, around_m, places, axes, 0, axes.size, half_rad, limits,
        critical_cos, reflectivity, echoes,
    )  # fmt: skip
    return echoes


@njit(error_model="numpy")
def _hear(
    table, room, x, y, around_m, places, axes, first, after, half_rad, limits,
    critical_cos, reflectivity, echoes,
):  # fmt: skip
    """Write the echoes of some transducers, looking farther until nothing nearer can come."""
    far_m, max_bounces, threshold = limits
    half_slope = math.tan(half_rad)
    reach_m = first_reach(table, room, far_m)
    is_known = np.zeros(axes.size, np.bool_)
    beam = np.empty(BEAM_COLUMNS + 3 * max_bounces)
    pieces = np.empty((2, 64, visible.COLUMNS))
    stack = np.empty((32, beam.size))
    while True:
        segments, circles = gather(table, room, x, y, reach_m + around_m)
        faces = np.empty((2 * (segments.shape[1] + circles.shape[1]) + 1, FACE_COLUMNS))
        is_near = np.empty(segments.shape[1], np.bool_)
        order = np.empty(faces.shape[0], np.int64)
        for k in range(first, after):
            if is_known[k]:
                continue
            first_beam(beam, places[k, 0], places[k, 1], axes[k], half_slope)
            found = _echo(
                segments, circles, table[3], beam, reach_m, max_bounces, threshold,
                critical_cos, reflectivity, faces, is_near, pieces, order, stack,
            )  # fmt: skip
            echo_m, surface, bounces, sine, axis_range_m, cone_range_m = found
            # What is within reach stays; there may be more beyond.
            is_known[k] = reach_m >= far_m or max(echo_m, axis_range_m, cone_range_m) < math.inf
            echoes.echo_m[k], echoes.surface[k], echoes.bounces[k] = echo_m, surface, bounces
            echoes.incidence_rad[k] = math.asin(min(sine, 1.0))
            echoes.axis_range_m[k], echoes.cone_range_m[k] = axis_range_m, cone_range_m
        if reach_m >= far_m:
            return
        reach_m = min(2.0 * reach_m, far_m)


@njit(error_model="numpy")
def _echo(
    segments, circles, surface_of, beam, reach_m, max_bounces, threshold,
    critical_cos, reflectivity, faces, is_near, pieces, order, stack,
):  # fmt: skip
    """Return (echo, surface, bounces, sine of incidence, axis range, cone range) of a beam."""
    best_m, best_surface, best_bounces, best_sine = reach_m, -1, 0, math.nan
    axis_m, cone_m = math.inf, math.inf
    waiting = 0
    while True:
        bounces, strength = int(beam[BOUNCES]), beam[STRENGTH]
        is_straight = beam[PILLARS] == 0.0
        _mark_near(segments, beam, best_m, is_near)
        count = _put_segments(segments, beam, is_near, best_m, faces)
        for i in range(circles.shape[1]):
            if not _is_near(circles, i, beam, best_m):
                continue
            for part in range(2):
                if circle_in(circles, i, beam, part, faces, count):
                    low, high = faces[count, FROM], faces[count, TO]
                    faces[count, NEAREST_M], _ = _nearest(beam, faces, count, low, high)
                    if faces[count, NEAREST_M] <= best_m:
                        count += 1
        is_of_use = False
        for k in range(count):
            low, high = faces[k, FROM], faces[k, TO]
            if bounces == 0:
                cone_m = min(cone_m, faces[k, NEAREST_M])
                if low <= 0.0 <= high:
                    ahead_m, _ = way(beam, faces, k, 0.0)
                    if ahead_m <= reach_m:
                        axis_m = min(axis_m, ahead_m)
            if not is_of_use:
                surface = surface_of[int(faces[k, NUMBER])]
                if strength * reflectivity[surface] >= threshold:
                    is_of_use = bounces < max_bounces
                    if not is_of_use:
                        begin, end = _returning(beam, faces, k, low, high, critical_cos[surface])
                        is_of_use = end > begin

        shown, now = 0, 0
        if is_of_use:
            pieces, now, shown = visible.look(beam, faces, count, pieces, order)
        for p in range(shown):
            k = int(pieces[now, p, visible.OF_FACE])
            low, high = pieces[now, p, visible.BEGIN], pieces[now, p, visible.END]
            surface = surface_of[int(faces[k, NUMBER])]
            if strength * reflectivity[surface] < threshold:
                pieces[now, p, _RETURNS_FROM], pieces[now, p, _RETURNS_TO] = low, high
                continue
            if is_straight and faces[k, KIND] == SEGMENT:
                begin, end = returning_straight(
                    faces[k, E_X], faces[k, E_Y], low, high, critical_cos[surface]
                )
            else:
                begin, end = _returning(beam, faces, k, low, high, critical_cos[surface])
            pieces[now, p, _RETURNS_FROM], pieces[now, p, _RETURNS_TO] = begin, end
            if end - begin <= NARROWEST:
                continue
            path_m, sine = _nearest(beam, faces, k, begin, end)
            # An echo from exactly the maximum range is one.
            is_nearer = path_m < best_m - _SAME_M or (best_surface < 0 and path_m <= best_m)
            if not is_nearer and best_surface >= 0 and path_m <= best_m + _SAME_M:
                is_nearer = bounces < best_bounces or (bounces == best_bounces and sine < best_sine)
            if is_nearer:
                best_m, best_surface, best_bounces, best_sine = path_m, surface, bounces, sine

        for p in range(shown if bounces < max_bounces else 0):
            k = int(pieces[now, p, visible.OF_FACE])
            if faces[k, NEAREST_M] >= best_m or faces[k, KIND] == FROM_INSIDE:
                # Sound that is mirrored within a pillar meets it at the same angle for ever.
                continue
            begin, end = pieces[now, p, _RETURNS_FROM], pieces[now, p, _RETURNS_TO]
            for side in range(2):
                low, high = pieces[now, p, visible.BEGIN], begin
                if side == 1:
                    low, high = end, pieces[now, p, visible.END]
                if high - low <= NARROWEST:
                    continue
                nearest_m, _ = _nearest(beam, faces, k, low, high)
                if nearest_m >= best_m:
                    continue
                if waiting == stack.shape[0]:
                    larger = np.empty((2 * waiting, beam.size))
                    larger[:waiting] = stack
                    stack = larger
                for column in range(beam.size):
                    stack[waiting, column] = beam[column]
                surface = surface_of[int(faces[k, NUMBER])]
                _mirror(stack[waiting], faces, k, low, high)
                stack[waiting, STRENGTH] *= reflectivity[surface]
                stack[waiting, NEAREST] = nearest_m
                waiting += 1
        # The beam that may return first is next: what it finds may spare the others.
        following = 0
        for k in range(1, waiting):
            if stack[k, NEAREST] < stack[following, NEAREST]:
                following = k
        if waiting == 0 or stack[following, NEAREST] >= best_m:
            break
        waiting -= 1
        for column in range(beam.size):
            beam[column] = stack[following, column]
            stack[following, column] = stack[waiting, column]

    echo_m = best_m if best_surface >= 0 else math.inf
    return echo_m, best_surface, best_bounces, best_sine, axis_m, cone_m


@njit(error_model="numpy", makes_arrays=False)
def _is_near(circles, i, beam, best_m):
    """Return whether a circle may lie in a beam nearer than `best_m`."""
    if beam[PILLARS] > 1.0:
        return True
    x, y = in_frame(beam, circles[0, i], circles[1, i])
    radius, low, high = circles[2, i], beam[LOW], beam[HIGH]
    if beam[PILLARS] > 0.0:
        cx, cy, rim, right_x, right_y, left_x, left_y, reach_m = _behind_pillar(beam, best_m)
        x, y, rim, reach_m = x - cx, y - cy, rim + radius, reach_m + radius
        return (
            (right_x * y - right_y * x >= -rim)
            & (left_x * y - left_y * x <= rim)
            & (x * x + y * y <= reach_m * reach_m)
        )
    return (
        (x - radius <= best_m)
        & (y - low * x > -radius * math.sqrt(1.0 + low * low))
        & (y - high * x < radius * math.sqrt(1.0 + high * high))
        & (beam[BEGIN_NX] * x + beam[BEGIN_NY] * y + radius > beam[BEGIN_OFF])
    )


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def _put_segments(segments, beam, is_near, best_m, faces):
    """Write the segments that lie in a beam nearer than `best_m`; return how many."""
    xx, xy, yx, yy = beam[X_OF_X], beam[X_OF_Y], beam[Y_OF_X], beam[Y_OF_Y]
    place_x, place_y, low, high = beam[PLACE_X], beam[PLACE_Y], beam[LOW], beam[HIGH]
    nx, ny, off = beam[BEGIN_NX], beam[BEGIN_NY], beam[BEGIN_OFF]
    mirror, pillars = beam[FACE], int(beam[PILLARS])
    is_on_pillar = beam[ON_PILLAR] > 0.0
    at = FIRST_PILLAR + 3 * (pillars - 1)
    count = 0
    for i in range(is_near.size):
        if not is_near[i] or segments[4, i] == mirror:
            continue
        whole_ax = xx * segments[0, i] + xy * segments[1, i] + place_x
        whole_ay = yx * segments[0, i] + yy * segments[1, i] + place_y
        whole_bx = xx * segments[2, i] + xy * segments[3, i] + place_x
        whole_by = yx * segments[2, i] + yy * segments[3, i] + place_y
        for part in range(2 if is_on_pillar else 1):
            if is_on_pillar:
                ax, ay, bx, by = outside_of_pillar(
                    whole_ax, whole_ay, whole_bx, whole_by,
                    beam[at], beam[at + 1], beam[at + 2], part,
                )  # fmt: skip
            elif mirror >= 0.0:
                ax, ay, bx, by = beyond_mirror(whole_ax, whole_ay, whole_bx, whole_by, nx, ny, off)
            else:
                ax, ay, bx, by = whole_ax, whole_ay, whole_bx, whole_by
            if math.isnan(ax):
                continue
            if pillars == 0:
                start, end, x, y, ex, ey, length, height = lie_straight(ax, ay, bx, by, low, high)
                if not end - start > NARROWEST:
                    continue
                near_0, near_1 = ey / height, -ex / height
                # The way along the axis is shorter than the way: most of what is too far ends here.
                if max(near_0 + start * near_1, near_0 + end * near_1) * best_m < 1.0 - 1e-9:
                    continue
                nearest_m, _ = nearest_straight(x, y, ex, ey, length, height, start, end)
                faces[count, KIND], faces[count, FROM], faces[count, TO] = SEGMENT, start, end
                faces[count, X], faces[count, Y] = x, y
                faces[count, E_X], faces[count, E_Y] = ex, ey
                faces[count, LENGTH], faces[count, HEIGHT] = length, height
                faces[count, NEAR_0], faces[count, NEAR_1] = near_0, near_1
            else:
                if not segment_behind_pillar(ax, ay, bx, by, beam, faces, count):
                    continue
                nearest_m, _ = _nearest(beam, faces, count, faces[count, FROM], faces[count, TO])
            if nearest_m <= best_m:
                faces[count, NUMBER], faces[count, NEAREST_M] = segments[4, i], nearest_m
                count += 1
    return count


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def _mark_near(segments, beam, best_m, is_near):
    """Mark the segments that may lie in a beam nearer than `best_m`: a straight, quick loop."""
    if beam[PILLARS] > 0.0:
        _mark_behind_pillar(segments, beam, best_m, is_near)
        return
    xx, xy, yx, yy = beam[X_OF_X], beam[X_OF_Y], beam[Y_OF_X], beam[Y_OF_Y]
    place_x, place_y, low, high = beam[PLACE_X], beam[PLACE_Y], beam[LOW], beam[HIGH]
    nx, ny, off = beam[BEGIN_NX], beam[BEGIN_NY], beam[BEGIN_OFF]
    for i in range(is_near.size):
        ax = xx * segments[0, i] + xy * segments[1, i] + place_x
        ay = yx * segments[0, i] + yy * segments[1, i] + place_y
        bx = xx * segments[2, i] + xy * segments[3, i] + place_x
        by = yx * segments[2, i] + yy * segments[3, i] + place_y
        is_near[i] = (
            (max(ay - low * ax, by - low * bx) > 0.0)
            & (min(ay - high * ax, by - high * bx) < 0.0)
            & (max(nx * ax + ny * ay, nx * bx + ny * by) > off)
            & (min(ax, bx) <= best_m)
        )


@njit(error_model="numpy")
def _mark_behind_pillar(segments, beam, best_m, is_near):
    """As `_mark_near` for a beam that a pillar has mirrored.

    How a face lies there takes a search, so those that cannot lie in the beam are sorted out first.
    """
    if beam[PILLARS] > 1.0:
        is_near[:] = True
        return
    cx, cy, radius, right_x, right_y, left_x, left_y, reach_m = _behind_pillar(beam, best_m)
    xx, xy, yx, yy = beam[X_OF_X], beam[X_OF_Y], beam[Y_OF_X], beam[Y_OF_Y]
    place_x, place_y = beam[PLACE_X] - cx, beam[PLACE_Y] - cy
    for i in range(is_near.size):
        ax = xx * segments[0, i] + xy * segments[1, i] + place_x
        ay = yx * segments[0, i] + yy * segments[1, i] + place_y
        bx = xx * segments[2, i] + xy * segments[3, i] + place_x
        by = yx * segments[2, i] + yy * segments[3, i] + place_y
        ex, ey = bx - ax, by - ay
        share = -(ax * ex + ay * ey) / max(ex * ex + ey * ey, 1e-300)
        share = min(max(share, 0.0), 1.0)
        foot_x, foot_y = ax + share * ex, ay + share * ey
        is_near[i] = (
            (max(right_x * ay - right_y * ax, right_x * by - right_y * bx) >= -radius)
            & (min(left_x * ay - left_y * ax, left_x * by - left_y * bx) <= radius)
            & (foot_x * foot_x + foot_y * foot_y <= reach_m * reach_m)
        )


@njit(error_model="numpy", makes_arrays=False)
def _behind_pillar(beam, best_m):
    """Return where sound of a beam that one pillar has mirrored may be found.

    Returns
    -------
    x, y, radius : float
        The pillar, a little larger, so that rounding sorts out nothing.
    right_x, right_y, left_x, left_y : float
        Directions between which all rays leave it; zeros where they spread over half a turn.
    reach_m : float
        How far from its centre what is nearer than `best_m` may be.
    """
    x, y, radius = beam[FIRST_PILLAR], beam[FIRST_PILLAR + 1], beam[FIRST_PILLAR + 2] + _SLACK_M
    # A pillar turns left and right around: the lowest slope leaves it leftmost.
    _, _, left_x, left_y, _, _, _ = ray_of(beam, beam[LOW])
    _, _, right_x, right_y, _, _, _ = ray_of(beam, beam[HIGH])
    if not right_x * left_y - right_y * left_x > _SLACK_M:
        right_x = right_y = left_x = left_y = 0.0
    # No way to the pillar is shorter than that to its front, nor one from it than from its rim.
    reach_m = best_m - math.sqrt(x * x + y * y) + 2 * radius
    return x, y, radius, right_x, right_y, left_x, left_y, max(reach_m, 0.0)


@njit(error_model="numpy", makes_arrays=False)
def _nearest(beam, faces, k, low, high):
    """Return the shortest way to a face between two slopes, and the sine there, positive."""
    if faces[k, KIND] == SEGMENT and beam[PILLARS] == 0.0:
        return nearest_straight(
            faces[k, X], faces[k, Y], faces[k, E_X], faces[k, E_Y],
            faces[k, LENGTH], faces[k, HEIGHT], low, high,
        )  # fmt: skip
    at_low_m, sine_low = way(beam, faces, k, low)
    at_high_m, sine_high = way(beam, faces, k, high)
    is_foot = (sine_low < 0.0) != (sine_high < 0.0)
    if is_foot and (faces[k, KIND] == SEGMENT or faces[k, KIND] == PILLAR):
        return _foot(beam, faces, k, low, high), 0.0
    if is_foot:
        foot_m = _foot(beam, faces, k, low, high)
        if foot_m < min(at_low_m, at_high_m):
            return foot_m, 0.0
    if at_low_m <= at_high_m:
        return at_low_m, abs(sine_low)
    return at_high_m, abs(sine_high)


@njit(error_model="numpy", makes_arrays=False)
def _foot(beam, faces, k, low, high):
    """Return the way to the place of a face that is met head-on, between two slopes."""
    if beam[PILLARS] == 0.0 and faces[k, KIND] == PILLAR:
        centre_m = math.sqrt(faces[k, X] * faces[k, X] + faces[k, Y] * faces[k, Y])
        return centre_m - faces[k, RADIUS]
    return way(beam, faces, k, slope_at_sine(beam, faces, k, 0.0, low, high))[0]


@njit(error_model="numpy", makes_arrays=False)
def _returning(beam, faces, k, low, high, critical_cos):
    """As `returning_straight` for any face in any beam."""
    if faces[k, KIND] == SEGMENT and beam[PILLARS] == 0.0:
        return returning_straight(faces[k, E_X], faces[k, E_Y], low, high, critical_cos)
    critical = math.sqrt(max(1.0 - critical_cos * critical_cos, 0.0))
    _, at_low = way(beam, faces, k, low)
    _, at_high = way(beam, faces, k, high)
    right, left = (-critical, critical) if at_low <= at_high else (critical, -critical)
    rising = 1.0 if at_low <= at_high else -1.0
    begin, end = low, high
    if rising * (at_low - right) < 0.0:
        if rising * (at_high - right) <= 0.0:
            return high, high
        begin = slope_at_sine(beam, faces, k, right, low, high)
    if rising * (at_high - left) > 0.0:
        if rising * (at_low - left) >= 0.0:
            return low, low
        end = slope_at_sine(beam, faces, k, left, low, high)
    return begin, end


@njit(error_model="numpy", makes_arrays=False)
def _mirror(beam, faces, k, low, high):
    """Send the rays of a beam between two slopes on over a face."""
    beam[LOW], beam[HIGH] = low, high
    beam[BOUNCES] += 1.0
    beam[FACE] = faces[k, NUMBER]
    if faces[k, KIND] == SEGMENT:
        length = faces[k, LENGTH]
        unfold(beam, faces[k, X], faces[k, Y], faces[k, E_Y] / length, -faces[k, E_X] / length)
        return
    at = FIRST_PILLAR + 3 * int(beam[PILLARS])
    beam[at], beam[at + 1], beam[at + 2] = faces[k, X], faces[k, Y], faces[k, RADIUS]
    beam[PILLARS] += 1.0
    beam[ON_PILLAR] = 1.0
    beam[BEGIN_NX] = beam[BEGIN_NY] = 0.0
    beam[BEGIN_OFF] = -1.0
