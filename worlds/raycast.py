"""Kernels that find where a ray meets segments and circles first.

A ray is an origin and a unit vector; lengths are in whatever unit the faces are in. Faces are
numbered segments first, then circles. Sums and products only, in a fixed order: a mirrored or
quarter-turned room gives the same distances to the last bit.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

__all__ = ["cast_rays", "face_normal", "first_hit"]

_Floats = NDArray[np.float64]
_Ints = NDArray[np.int32]

# A ray that begins on the surface that mirrored it must not meet that surface again.
_NEAREST = 1e-9
# Segments reach this share of their length beyond their ends, so that no ray slips through
# the corner of two walls by a rounding error.
_OVERHANG = 1e-9


@njit(cache=True)
def first_hit(
    x: float, y: float, dx: float, dy: float, reach: float, segments: _Floats, circles: _Floats
) -> tuple[float, int]:
    """Return (distance, face) of the first face within `reach`; (inf, -1) if there is none."""
    best, face = math.inf, -1
    for i in range(segments.shape[0]):
        ex, ey = segments[i, 2] - segments[i, 0], segments[i, 3] - segments[i, 1]
        across = dx * ey - dy * ex
        if across == 0.0:
            continue  # a ray along a wall meets the wall's end, which is another segment
        ax, ay = segments[i, 0] - x, segments[i, 1] - y
        distance = (ax * ey - ay * ex) / across
        if not _NEAREST < distance <= reach or distance >= best:
            continue
        share = (ax * dy - ay * dx) / across
        if -_OVERHANG <= share <= 1.0 + _OVERHANG:
            best, face = distance, i
    for i in range(circles.shape[0]):
        ax, ay = circles[i, 0] - x, circles[i, 1] - y
        along = ax * dx + ay * dy
        aside = ax * dy - ay * dx
        half_chord_2 = circles[i, 2] * circles[i, 2] - aside * aside
        if half_chord_2 < 0.0:
            continue
        half_chord = math.sqrt(half_chord_2)
        distance = along - half_chord
        if distance <= _NEAREST:
            distance = along + half_chord  # from inside, the far side is met
        if _NEAREST < distance <= reach and distance < best:
            best, face = distance, segments.shape[0] + i
    return best, face


@njit(cache=True)
def face_normal(
    face: int,
    hit_x: float,
    hit_y: float,
    dx: float,
    dy: float,
    segments: _Floats,
    circles: _Floats,
) -> tuple[float, float]:
    """Return the unit normal of a face at a point, turned against the ray (dx, dy)."""
    if face < segments.shape[0]:
        nx, ny = segments[face, 3] - segments[face, 1], segments[face, 0] - segments[face, 2]
    else:
        circle = face - segments.shape[0]
        nx, ny = hit_x - circles[circle, 0], hit_y - circles[circle, 1]
    length = math.sqrt(nx * nx + ny * ny)
    if nx * dx + ny * dy > 0.0:
        length = -length
    return nx / length, ny / length


@njit(cache=True)
def cast_rays(
    origins: _Floats,
    directions: _Floats,
    reach: _Floats,
    segments: _Floats,
    segment_surface: _Ints,
    circles: _Floats,
    circle_surface: _Ints,
) -> tuple[_Floats, _Floats, _Ints]:
    """Return (distance, normal, surface) of n rays, see `worlds.RayHits`."""
    n = origins.shape[0]
    distances = np.full(n, np.inf)
    normals = np.zeros((n, 2))
    surfaces = np.full(n, -1, dtype=np.int32)
    for i in range(n):
        x, y = origins[i, 0], origins[i, 1]
        dx, dy = directions[i, 0], directions[i, 1]
        distance, face = first_hit(x, y, dx, dy, reach[i], segments, circles)
        if face < 0:
            continue
        distances[i] = distance
        normals[i, 0], normals[i, 1] = face_normal(
            face, x + distance * dx, y + distance * dy, dx, dy, segments, circles
        )
        if face < segments.shape[0]:
            surfaces[i] = segment_surface[face]
        else:
            surfaces[i] = circle_surface[face - segments.shape[0]]
    return distances, normals, surfaces
