"""Compiled: how pillars and edges turn sound from one place to another."""

from __future__ import annotations

import math

from sonarmap.kernels.jit import njit

__all__ = ["edge_share_db", "pillar_share_db", "turning_place"]

# The place of a pillar that turns a sound is found by steps that shrink it by the pillar's radius
# over its distance; so many are more than enough, and so small a turn is none, radians.
_MOST_STEPS, _SAME_RAD = 60, 1e-12
_LEAST_M = 0.01


@njit(error_model="numpy")
def edge_share_db(edge_db, one_m, other_m):
    """Return the level of an edge against a plane's on a path as long, decibels.

    An edge sends on what it gets as a point does: its amplitude falls with both distances.
    """
    one_m, other_m = max(one_m, _LEAST_M), max(other_m, _LEAST_M)
    return edge_db + 20 * math.log10((one_m + other_m) / (2 * one_m * other_m))


@njit(error_model="numpy")
def pillar_share_db(radius_m, cos, one_m, other_m):
    """Return the level of a pillar against a plane's on a path as long, decibels.

    Geometrical optics of a cylinder met at an angle of incidence (Keller, Journal of the Optical
    Society of America 52, 1962); there and back the same way it is b / (b + r) of the power.
    """
    bent = radius_m * cos * (one_m + other_m)
    return 10 * math.log10(bent / (bent + 2 * one_m * other_m))


@njit(error_model="numpy")
def turning_place(x, y, radius_m, from_x, from_y, to_x, to_y):
    """Return (x, y, cosine of incidence) of the place of a pillar that turns sound to a place."""
    nx, ny = 0.0, 0.0
    px, py = x, y
    cos = 0.0
    for _ in range(_MOST_STEPS):
        ax, ay = from_x - px, from_y - py
        bx, by = to_x - px, to_y - py
        a, b = math.hypot(ax, ay), math.hypot(bx, by)
        sx, sy = ax / a + bx / b, ay / a + by / b
        both = math.hypot(sx, sy)
        if both < _SAME_RAD:
            break  # the pillar stands between the two
        turn = abs(nx * sy - ny * sx) / both
        nx, ny = sx / both, sy / both
        px, py = x + radius_m * nx, y + radius_m * ny
        cos = both / 2
        if turn < _SAME_RAD and px != x:
            break
    return px, py, cos
