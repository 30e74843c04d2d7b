"""How a face lies in a beam: between which slopes, how far along a ray, and how it is met.

Faces are rows of numbers in the frame of the beam. The *sine* of a ray at a face is that of its
signed angle of incidence; along a straight face, and along a pillar as seen from outside, it
rises or falls all the way, and the way is shortest where it is 0.
"""

from __future__ import annotations

import math

from sim.sonar.cone.exact.beam import (
    BEGIN_NX,
    BEGIN_NY,
    BEGIN_OFF,
    BOUNCES,
    FACE,
    HIGH,
    LOW,
    NARROWEST,
    ON_PILLAR,
    PILLARS,
    PLACE_X,
    PLACE_Y,
    STEPS,
    X_OF_X,
    X_OF_Y,
    Y_OF_X,
    Y_OF_Y,
    between,
    ray_of,
    slope_through,
)
from sonarmap.kernels.jit import njit
from worlds.raycast import NEAREST as TOUCHING_M

__all__ = [
    "COLUMNS",
    "E_X",
    "E_Y",
    "FROM",
    "FROM_INSIDE",
    "HEIGHT",
    "KIND",
    "LENGTH",
    "NEAREST_M",
    "NEAR_0",
    "NEAR_1",
    "NUMBER",
    "PILLAR",
    "RADIUS",
    "SEGMENT",
    "TO",
    "X",
    "Y",
    "beyond_mirror",
    "circle_in",
    "crossings",
    "in_frame",
    "lie_straight",
    "nearest_straight",
    "nearness",
    "outside_of_pillar",
    "returning_straight",
    "segment_behind_pillar",
    "slope_at_sine",
    "way",
]  # fmt: skip

SEGMENT, PILLAR, FROM_INSIDE = 0.0, 1.0, 2.0
# Columns of a face: what it is, the slopes between which it lies, its number, the shortest way.
KIND, FROM, TO, NUMBER, NEAREST_M, X, Y = range(7)
# A segment: (X, Y) is its right end, (E_X, E_Y) the way to its left end; its length; and its
# distance from the origin times its length.
E_X, E_Y, LENGTH, HEIGHT = range(7, 11)
# A circle: (X, Y) is its centre; its radius, and the square of its tangents' length.
RADIUS, TANGENT_2 = 7, 8
# Straight along a beam the nearness of a segment is NEAR_0 + NEAR_1 * slope.
NEAR_0, NEAR_1 = 11, 12
COLUMNS = 13

# A face that lies in the line of the mirror, or ends there, is not behind it.
_BEHIND_M = 1e-9


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def lie_straight(ax, ay, bx, by, low, high):
    """Return how a segment lies in a beam that no pillar has mirrored, all numbers, no arrays.

    Parameters
    ----------
    ax, ay, bx, by : float
        Its ends in the frame of the beam.
    low, high : float
        Slopes of the beam.

    Returns
    -------
    start, end, x, y, ex, ey, length, height : float
        Columns of a face; start > end if no ray meets it.
    """
    height = ax * by - ay * bx
    if height < 0.0:
        ax, ay, bx, by, height = bx, by, ax, ay, -height
    ex, ey = bx - ax, by - ay
    length = math.sqrt(ex * ex + ey * ey)
    # The right end may be right of the beam, or in it; but not left of it, nor behind the sonar.
    start, end = 1.0, 0.0
    if ay < low * ax:
        start = low
    elif ay <= high * ax:
        start = ay / ax
    else:
        height = 0.0
    if by > high * bx:
        end = high
    elif by >= low * bx:
        end = by / bx
    else:
        height = 0.0
    # A face through the sonar is not met, as `worlds.raycast` has it.
    if height <= TOUCHING_M * length:
        start, end = 1.0, 0.0
    return start, end, ax, ay, ex, ey, length, height


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def nearest_straight(x, y, ex, ey, length, height, low, high):
    """Return the shortest way to a segment between two slopes, and the sine there, positive."""
    leans_low, leans_high = ex + low * ey, ex + high * ey
    if leans_low < 0.0 <= leans_high:
        # The distance of a line from the origin, not by way of a rounded slope.
        return (x * ey - y * ex) / length, 0.0
    slope, leans = (low, leans_low) if leans_low >= 0.0 else (high, leans_high)
    root = math.sqrt(1.0 + slope * slope)
    return height * root / (ey - slope * ex), abs(leans) / (length * root)


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def returning_straight(ex, ey, low, high, critical_cos):
    """Return the slopes between two at which a segment is met within its critical angle.

    One interval, empty at the end of (low, high) that is nearer to it if there is none.
    """
    sine = math.sqrt(max(1.0 - critical_cos * critical_cos, 0.0))
    right_x, right_y = critical_cos * ey - sine * ex, -critical_cos * ex - sine * ey
    left_x, left_y = critical_cos * ey + sine * ex, -critical_cos * ex + sine * ey
    # A direction that leads back is beyond one end of the beam or the other: any ray tells which.
    most = sine * math.sqrt((ex * ex + ey * ey) * (1.0 + low * low))
    right, left = -math.inf, math.inf
    if right_x > 0.0:
        right = right_y / right_x
    elif ex + low * ey < -most:
        right = math.inf
    if left_x > 0.0:
        left = left_y / left_x
    elif ex + low * ey > most:
        left = -math.inf
    if right >= high:
        return high, high
    if left <= low:
        return low, low
    return max(right, low), min(left, high)


@njit(error_model="numpy", makes_arrays=False)
def way(beam, faces, k, slope):
    """Return the length of a ray's way up to a face that it meets, and the sine there."""
    if beam[PILLARS] == 0.0:
        root = math.sqrt(1.0 + slope * slope)
        if faces[k, KIND] == SEGMENT:
            length = faces[k, HEIGHT] * root / (faces[k, E_Y] - slope * faces[k, E_X])
            return length, (faces[k, E_X] + slope * faces[k, E_Y]) / (faces[k, LENGTH] * root)
        aside = (faces[k, X] * slope - faces[k, Y]) / root
        along = (faces[k, X] + faces[k, Y] * slope) / root
        path = 0.0
    else:
        x, y, dx, dy, path, _, _ = ray_of(beam, slope)
        to_x, to_y = faces[k, X] - x, faces[k, Y] - y
        if faces[k, KIND] == SEGMENT:
            across = dx * faces[k, E_Y] - dy * faces[k, E_X]
            leg = (to_x * faces[k, E_Y] - to_y * faces[k, E_X]) / across
            return path + leg, (dx * faces[k, E_X] + dy * faces[k, E_Y]) / faces[k, LENGTH]
        aside, along = to_x * dy - to_y * dx, to_x * dx + to_y * dy
    half = math.sqrt(max(faces[k, RADIUS] * faces[k, RADIUS] - aside * aside, 0.0))
    leg = along + half if faces[k, KIND] == FROM_INSIDE else along - half
    return path + leg, aside / faces[k, RADIUS]


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def nearness(beam, faces, k, slope):
    """Return a number that is larger the nearer a face is along a ray that meets it."""
    if beam[PILLARS] == 0.0:
        # One over the distance along the axis: for a segment linear in the slope.
        if faces[k, KIND] == SEGMENT:
            return faces[k, NEAR_0] + slope * faces[k, NEAR_1]
        along = faces[k, X] + faces[k, Y] * slope
        square = along * along - (1.0 + slope * slope) * faces[k, TANGENT_2]
        half = math.sqrt(max(square, 0.0))
        if faces[k, KIND] == PILLAR:
            return (along + half) / faces[k, TANGENT_2]
        return (1.0 + slope * slope) / (along + half)
    return 1.0 / way(beam, faces, k, slope)[0]


@njit(error_model="numpy", makes_arrays=False)
def slope_at_sine(beam, faces, k, sine, low, high):
    """Return the slope between two at which a face is met at a sine, which is between theirs."""
    if beam[PILLARS] == 0.0:
        if faces[k, KIND] == SEGMENT:
            cosine = math.sqrt(1.0 - sine * sine)
            dx, dy = (
                sine * faces[k, E_X] + cosine * faces[k, E_Y],
                sine * faces[k, E_Y] - cosine * faces[k, E_X],
            )
        else:
            aside = faces[k, RADIUS] * sine
            square = faces[k, X] * faces[k, X] + faces[k, Y] * faces[k, Y] - aside * aside
            along = math.sqrt(max(square, 0.0))
            if faces[k, X] + faces[k, Y] * 0.5 * (low + high) < 0.0:
                along = -along  # from inside: away from the centre
            dx, dy = (
                along * faces[k, X] - aside * faces[k, Y],
                along * faces[k, Y] + aside * faces[k, X],
            )
        return min(max(dy / dx, low), high)
    at_low, at_high = _sine(beam, faces, k, low) - sine, _sine(beam, faces, k, high) - sine
    rises = at_high > at_low
    slope = low
    for step in range(STEPS):
        slope = between(step, low, high, at_low, at_high)
        if not low < slope < high:
            break
        here = _sine(beam, faces, k, slope) - sine
        if here == 0.0:
            break
        if (here > 0.0) != rises:
            low, at_low, at_high = slope, here, 0.5 * at_high
        else:
            high, at_high, at_low = slope, here, 0.5 * at_low
    return min(max(slope, low), high)


@njit(error_model="numpy", makes_arrays=False)
def _sine(beam, faces, k, slope):
    """Return the sine of a ray, beyond 1 and up to 2 for one that passes a pillar."""
    x, y, dx, dy, _, _, _ = ray_of(beam, slope)
    if faces[k, KIND] == SEGMENT:
        return (dx * faces[k, E_X] + dy * faces[k, E_Y]) / faces[k, LENGTH]
    to_x, to_y = faces[k, X] - x, faces[k, Y] - y
    sine = (to_x * dy - to_y * dx) / faces[k, RADIUS]
    if to_x * dx + to_y * dy <= 0.0:
        return math.copysign(2.0, sine)
    return min(max(sine, -2.0), 2.0)


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def beyond_mirror(ax, ay, bx, by, nx, ny, off):
    """Return the part of a segment that lies behind a line, four numbers; NaN if none does."""
    a_on, b_on = nx * ax + ny * ay - off, nx * bx + ny * by - off
    if max(a_on, b_on) <= _BEHIND_M:
        return math.nan, math.nan, math.nan, math.nan
    if a_on < 0.0:
        share = a_on / (a_on - b_on)
        ax, ay = ax + share * (bx - ax), ay + share * (by - ay)
    elif b_on < 0.0:
        share = b_on / (b_on - a_on)
        bx, by = bx + share * (ax - bx), by + share * (ay - by)
    return ax, ay, bx, by


@njit(error_model="numpy", makes_arrays=False)
def segment_behind_pillar(ax, ay, bx, by, beam, faces, k):
    """Write how a segment of the frame lies in a beam that a pillar has mirrored, if it does.

    The segment is clear of the last mirror, see `beyond_mirror` and `outside_of_pillar`.
    """
    low, high = beam[LOW], beam[HIGH]
    ex, ey = bx - ax, by - ay
    length = math.sqrt(ex * ex + ey * ey)
    if length == 0.0:
        return False
    start, end = math.inf, -math.inf
    for slope in (low, high):
        x, y, dx, dy, _, _, _ = ray_of(beam, slope)
        across = dx * ey - dy * ex
        share = (ax - x) * dy - (ay - y) * dx
        leg = (ax - x) * ey - (ay - y) * ex
        if across < 0.0:
            across, share, leg = -across, -share, -leg
        if across > 0.0 and 0.0 <= share <= across and leg > 0.0:
            start, end = min(start, slope), max(end, slope)
    for x, y in ((ax, ay), (bx, by)):
        slope = slope_through(beam, x, y, low, high)
        if not math.isnan(slope):
            start, end = min(start, slope), max(end, slope)
    if not end - start > NARROWEST:
        return False
    _, _, dx, dy, _, _, _ = ray_of(beam, 0.5 * (start + end))
    if dx * ey - dy * ex < 0.0:
        ax, ay, ex, ey = bx, by, -ex, -ey
    faces[k, KIND], faces[k, FROM], faces[k, TO] = SEGMENT, start, end
    faces[k, X], faces[k, Y], faces[k, E_X], faces[k, E_Y], faces[k, LENGTH] = (
        ax,
        ay,
        ex,
        ey,
        length,
    )
    return True


@njit(error_model="numpy", makes_arrays=False)
def outside_of_pillar(ax, ay, bx, by, x, y, radius, part):
    """Return one of the two parts of a segment outside of a circle, four numbers; NaN if none."""
    vx, vy, ex, ey = ax - x, ay - y, bx - ax, by - ay
    square = ex * ex + ey * ey
    middle = -(vx * ex + vy * ey) / square
    aside = vx * ey - vy * ex
    half_2 = radius * radius / square - aside * aside / (square * square)
    # Where the line enters the circle and leaves it, as shares of the segment.
    enter, leave = 1.0, 1.0
    if half_2 > 0.0:
        half = math.sqrt(half_2)
        if middle + half > 0.0 and middle - half < 1.0:
            enter, leave = middle - half, middle + half
    first, last = (0.0, enter) if part == 0 else (leave, 1.0)
    if not first < last:
        return math.nan, math.nan, math.nan, math.nan
    cx, cy, fx, fy = ax, ay, bx, by
    if first > 0.0:
        cx, cy = ax + first * ex, ay + first * ey
    if last < 1.0:
        fx, fy = ax + last * ex, ay + last * ey
    return cx, cy, fx, fy


@njit(error_model="numpy", makes_arrays=False)
def circle_in(circles, i, beam, part, faces, k):
    """Write how a circle of the room lies in a beam, if it does.

    From inside it has two parts: on one the sine rises, on the other it falls.
    """
    if circles[3, i] == beam[FACE]:
        return False
    x, y = in_frame(beam, circles[0, i], circles[1, i])
    radius = circles[2, i]
    low, high = beam[LOW], beam[HIGH]
    tangent_2 = x * x + y * y - radius * radius
    faces[k, KIND], faces[k, NUMBER], faces[k, X], faces[k, Y] = PILLAR, circles[3, i], x, y
    faces[k, RADIUS], faces[k, TANGENT_2] = radius, tangent_2
    if beam[PILLARS] > 0.0:
        if part == 1:
            return False
        start, end = _circle_behind_pillar(beam, faces, k)
    else:
        if math.sqrt(x * x + y * y) - radius <= TOUCHING_M:
            # From inside the far side is met; a mirrored ray begins within no pillar.
            across = min(max(-x / y, low), high) if y != 0.0 else low
            start, end = (low, across) if part == 0 else (across, high)
            faces[k, KIND], faces[k, FROM], faces[k, TO] = FROM_INSIDE, start, end
            return beam[BOUNCES] == 0.0 and end - start > NARROWEST
        if part == 1:
            return False
        # Of the tangents the square root of 1 is the length, the radius is the height.
        tangent = math.sqrt(tangent_2)
        right_x, right_y = tangent * x + radius * y, tangent * y - radius * x
        left_x, left_y = tangent * x - radius * y, tangent * y + radius * x
        if (right_x <= 0.0 and right_y >= 0.0) or (left_x <= 0.0 and left_y <= 0.0):
            return False  # all of it is left of the sonar, or right of it
        start = max(low, right_y / right_x) if right_x > 0.0 else low
        end = min(high, left_y / left_x) if left_x > 0.0 else high
    if not end - start > NARROWEST:
        return False
    faces[k, FROM], faces[k, TO] = start, end
    if beam[BOUNCES] > 0.0:
        # A pillar that stands in the line of the mirror: before it or behind?
        slope = 0.5 * (start + end)
        ox, oy, dx, dy, path, _, _ = ray_of(beam, slope)
        leg = way(beam, faces, k, slope)[0] - path
        if beam[ON_PILLAR] > 0.0:
            return leg > 0.0
        hit_x, hit_y = ox + leg * dx, oy + leg * dy
        return beam[BEGIN_NX] * hit_x + beam[BEGIN_NY] * hit_y > beam[BEGIN_OFF]
    return True


@njit(error_model="numpy", makes_arrays=False)
def _circle_behind_pillar(beam, faces, k):
    """Return the slopes between which a beam that a pillar has mirrored meets a circle."""
    low, high = beam[LOW], beam[HIGH]
    at_low, at_high = _sine(beam, faces, k, low), _sine(beam, faces, k, high)
    middle = slope_through(beam, faces[k, X], faces[k, Y], low, high)
    if math.isnan(middle):
        # At most one side of it, from one end of the beam on.
        if abs(at_low) <= 1.0:
            if abs(at_high) <= 1.0:
                return low, high
            return low, slope_at_sine(beam, faces, k, math.copysign(1.0, at_high), low, high)
        if abs(at_high) <= 1.0:
            return slope_at_sine(beam, faces, k, math.copysign(1.0, at_low), low, high), high
        return 1.0, 0.0
    start, end = low, high
    if abs(at_low) > 1.0:
        start = slope_at_sine(beam, faces, k, math.copysign(1.0, at_low), low, middle)
    if abs(at_high) > 1.0:
        end = slope_at_sine(beam, faces, k, math.copysign(1.0, at_high), middle, high)
    return start, end


@njit(error_model="numpy", makes_arrays=False)
def crossings(beam, faces, i, j, low, high):
    """Return the slopes between two at which faces cross: the lower, then the higher; NaN."""
    first, second = math.nan, math.nan
    if faces[i, KIND] == SEGMENT and faces[j, KIND] == SEGMENT:
        across = faces[i, E_X] * faces[j, E_Y] - faces[i, E_Y] * faces[j, E_X]
        if across != 0.0:
            gap_x, gap_y = faces[j, X] - faces[i, X], faces[j, Y] - faces[i, Y]
            share = (gap_x * faces[j, E_Y] - gap_y * faces[j, E_X]) / across
            x, y = faces[i, X] + share * faces[i, E_X], faces[i, Y] + share * faces[i, E_Y]
            first = slope_through(beam, x, y, low, high)
    elif faces[i, KIND] != SEGMENT and faces[j, KIND] != SEGMENT:
        gap_x, gap_y = faces[j, X] - faces[i, X], faces[j, Y] - faces[i, Y]
        apart_2 = gap_x * gap_x + gap_y * gap_y
        radius_2 = faces[i, RADIUS] * faces[i, RADIUS]
        share = 0.5 * (1.0 + (radius_2 - faces[j, RADIUS] * faces[j, RADIUS]) / apart_2)
        half_2 = radius_2 / apart_2 - share * share
        if half_2 > 0.0:
            half = math.sqrt(half_2)
            x, y = faces[i, X] + share * gap_x, faces[i, Y] + share * gap_y
            first = slope_through(beam, x - half * gap_y, y + half * gap_x, low, high)
            second = slope_through(beam, x + half * gap_y, y - half * gap_x, low, high)
    else:
        f, c = (i, j) if faces[i, KIND] == SEGMENT else (j, i)
        ex, ey = faces[f, E_X] / faces[f, LENGTH], faces[f, E_Y] / faces[f, LENGTH]
        to_x, to_y = faces[c, X] - faces[f, X], faces[c, Y] - faces[f, Y]
        along, aside = to_x * ex + to_y * ey, to_x * ey - to_y * ex
        half_2 = faces[c, RADIUS] * faces[c, RADIUS] - aside * aside
        if half_2 > 0.0:
            half = math.sqrt(half_2)
            x, y = faces[f, X] + along * ex, faces[f, Y] + along * ey
            first = slope_through(beam, x - half * ex, y - half * ey, low, high)
            second = slope_through(beam, x + half * ex, y + half * ey, low, high)
    if math.isnan(first) or second < first:
        first, second = second, first
    return first, second


@njit(error_model="numpy", forceinline=True, makes_arrays=False)
def in_frame(beam, x, y):
    """Return where the frame of a beam sees a point of the room."""
    return (
        beam[X_OF_X] * x + beam[X_OF_Y] * y + beam[PLACE_X],
        beam[Y_OF_X] * x + beam[Y_OF_Y] * y + beam[PLACE_Y],
    )
