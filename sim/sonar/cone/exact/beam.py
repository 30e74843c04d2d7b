"""Beams: the rays between two bearings that have met the same mirrors, as one row of numbers.

A beam lives in the frame of its sonar: the transducer is the origin, the axis is x. A ray is known
by its slope, the tangent of its bearing off the axis, over all of its legs. Behind a flat mirror
the room is unfolded, so that rays stay straight: a beam knows where the frame sees each point of
the room. Pillars cannot be unfolded; a beam knows those on its way, and rays turn there.
"""

from __future__ import annotations

import math

from sonarmap.kernels.jit import njit

__all__ = [
    "BEGIN_NX", "BEGIN_NY", "BEGIN_OFF", "BOUNCES", "COLUMNS", "FACE", "FIRST_PILLAR", "HIGH",
    "LOW", "NARROWEST", "NEAREST", "ON_PILLAR", "PILLARS", "PLACE_X", "PLACE_Y", "STEPS",
    "STRENGTH", "X_OF_X", "X_OF_Y", "Y_OF_X", "Y_OF_Y",
    "between", "first_beam", "ray_of", "side_of", "slope_through", "unfold",
]  # fmt: skip

NARROWEST = 1e-11
"""Intervals of slope that are narrower are rounding errors at the corners of faces."""
STEPS = 100
"""Most steps of a search for a root; see `between`."""

# Columns of a beam. From the room to the frame: x = X_OF_X x + X_OF_Y y + PLACE_X, likewise y.
X_OF_X, X_OF_Y, Y_OF_X, Y_OF_Y, PLACE_X, PLACE_Y = range(6)
# Slopes of its outer rays, the share of the amplitude that is left, and the least path so far.
LOW, HIGH, STRENGTH, NEAREST = range(6, 10)
# The last mirror: its line as a unit normal in the direction of the rays and the origin's offset,
# its number, how many mirrors there were, and whether the last one is a pillar.
BEGIN_NX, BEGIN_NY, BEGIN_OFF, FACE, BOUNCES, ON_PILLAR = range(10, 16)
# Pillars on the way, and of each its centre and radius.
PILLARS, FIRST_PILLAR = 16, 17
COLUMNS = FIRST_PILLAR
"""Columns of a beam that has met no pillar; each takes three more."""


@njit(error_model="numpy", makes_arrays=False)
def between(step, low, high, at_low, at_high):
    """Return where to look for a root next: by the secant, in each third step by the middle."""
    share = at_low / (at_low - at_high) if step % 3 < 2 and at_low != at_high else 0.5
    return low + share * (high - low)


@njit(error_model="numpy", makes_arrays=False)
def first_beam(beam, x, y, axis_rad, half_slope):
    """Write the beam of a sonar's whole cone."""
    cos, sin = math.cos(axis_rad), math.sin(axis_rad)
    beam[X_OF_X], beam[X_OF_Y] = cos, sin
    beam[Y_OF_X], beam[Y_OF_Y] = -sin, cos
    beam[PLACE_X], beam[PLACE_Y] = -(cos * x + sin * y), sin * x - cos * y
    beam[LOW], beam[HIGH] = -half_slope, half_slope
    beam[STRENGTH], beam[NEAREST] = 1.0, 0.0
    # All lies behind a line that is none.
    beam[BEGIN_NX] = beam[BEGIN_NY] = 0.0
    beam[BEGIN_OFF], beam[FACE] = -1.0, -1.0
    beam[BOUNCES] = beam[ON_PILLAR] = beam[PILLARS] = 0.0


@njit(error_model="numpy", makes_arrays=False)
def unfold(beam, x, y, nx, ny):
    """Unfold a beam behind the mirror through a point of its frame, unit normal along the rays."""
    offset = nx * x + ny * y
    for of_x, of_y in ((X_OF_X, Y_OF_X), (X_OF_Y, Y_OF_Y), (PLACE_X, PLACE_Y)):
        apart = nx * beam[of_x] + ny * beam[of_y]
        if of_x == PLACE_X:
            apart -= offset
        beam[of_x] -= 2 * apart * nx
        beam[of_y] -= 2 * apart * ny
    beam[BEGIN_NX], beam[BEGIN_NY], beam[BEGIN_OFF] = nx, ny, offset
    beam[ON_PILLAR] = 0.0


@njit(error_model="numpy", makes_arrays=False)
def ray_of(beam, slope):
    """Return a ray after the last pillar on its way.

    Returns
    -------
    x, y, dx, dy : float
        Where its leg begins and its direction.
    path : float
        Length of its way up to there.
    nx, ny : float
        Normal of the pillar there; zeros where there is none.
    """
    length = math.sqrt(1.0 + slope * slope)
    x, y, dx, dy, path, nx, ny = 0.0, 0.0, 1.0 / length, slope / length, 0.0, 0.0, 0.0
    for k in range(int(beam[PILLARS])):
        at = FIRST_PILLAR + 3 * k
        radius = beam[at + 2]
        to_x, to_y = beam[at] - x, beam[at + 1] - y
        aside = to_x * dy - to_y * dx
        leg = to_x * dx + to_y * dy - math.sqrt(max(radius * radius - aside * aside, 0.0))
        x, y, path = x + leg * dx, y + leg * dy, path + leg
        nx, ny = (x - beam[at]) / radius, (y - beam[at + 1]) / radius
        along = dx * nx + dy * ny
        dx, dy = dx - 2 * along * nx, dy - 2 * along * ny
    return x, y, dx, dy, path, nx, ny


@njit(error_model="numpy", makes_arrays=False)
def side_of(beam, slope, x, y):
    """Return on which side of a ray a point lies: > 0 where rays of a higher slope go.

    Behind a pillar what no ray from there can reach counts as beside the pillar's normal.
    """
    ox, oy, dx, dy, _, nx, ny = ray_of(beam, slope)
    vx, vy = x - ox, y - oy
    pillars = int(beam[PILLARS])
    if pillars == 0:
        return dx * vy - dy * vx
    # Each pillar turns left and right around.
    turn = -1.0 if pillars % 2 else 1.0
    if nx * vx + ny * vy > 0.0:
        return turn * (dx * vy - dy * vx) / math.sqrt(vx * vx + vy * vy)
    return turn * math.copysign(1.0, nx * vy - ny * vx)


@njit(error_model="numpy", makes_arrays=False)
def slope_through(beam, x, y, low, high):
    """Return the slope between two of the ray that meets a point, NaN if there is none."""
    if beam[PILLARS] == 0.0:
        slope = y / x if x > 0.0 else math.nan
        return slope if low <= slope <= high else math.nan
    at_low, at_high = side_of(beam, low, x, y), side_of(beam, high, x, y)
    if at_low < 0.0 or at_high > 0.0:
        return math.nan
    slope = low
    for step in range(STEPS):
        slope = between(step, low, high, at_low, at_high)
        if not low < slope < high:
            break
        here = side_of(beam, slope, x, y)
        if here == 0.0:
            break
        # The Illinois method: an end that stays loses half of its weight.
        if here > 0.0:
            low, at_low, at_high = slope, here, 0.5 * at_high
        else:
            high, at_high, at_low = slope, here, 0.5 * at_low
    ox, oy, dx, dy, _, _, _ = ray_of(beam, slope)
    # Not where the sides change behind the pillar.
    is_ahead = (x - ox) * dx + (y - oy) * dy > -1e-9
    return slope if is_ahead else math.nan
