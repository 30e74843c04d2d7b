"""The simple cone of rays in one compiled call: `sim.ConeSonar.listen` on the faces of a room.

It finds the same first return as the steps in `sim.sonar.cone.kernel`: the fan at once, then the
mirrored rays one by one, none farther than the first return so far.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.envs.backends.compiled.fan import meet_fan
from sim.sonar.cone.kernel import OFF_SURFACE_M, turned
from sonarmap.kernels.jit import njit
from worlds.raycast import face_normal, first_hit

__all__ = ["ConeLimits", "ConeMemory", "RingGeometry", "cone_echo", "cone_memory"]

# The rays of a fan are filled up to a multiple of this, see `meet_fan`.
_WHOLE = 16
# Mirrored rays: begin of the leg, direction, path so far, share of the amplitude that is left.
_X, _Y, _DX, _DY, _PATH, _STRENGTH, _COLUMNS = range(7)


class RingGeometry(NamedTuple):
    """Where the sonars of a ring are, and the rays of a fan.

    Parameters
    ----------
    mounts : ndarray, shape (sonars, 3)
        Place and axis of each sonar in the robot's frame.
    half_rad : float
        Half angle of the cones.
    cos_bearing, sin_bearing : ndarray, shape (rays,)
        Bearings of the rays off the axis, rising; the axis is in the middle. No rays: the whole
        cone counts, see `sim.sonar.cone.exact`.
    """

    mounts: NDArray[np.float64]
    half_rad: float
    cos_bearing: NDArray[np.float64]
    sin_bearing: NDArray[np.float64]


class ConeLimits(NamedTuple):
    """How far, over how many mirrors and how weak sound is traced, see `sim.ConeSonar`."""

    far_m: float
    max_bounces: int
    threshold: float


class ConeMemory(NamedTuple):
    """Working memory of `cone_echo`.

    Parameters
    ----------
    dx, dy, leg_m, face : ndarray
        Of the rays of the fan: direction, leg and the face met.
    mirrored : ndarray
        A row for each mirrored ray.
    """

    dx: NDArray[np.float64]
    dy: NDArray[np.float64]
    leg_m: NDArray[np.float64]
    face: NDArray[np.int64]
    mirrored: NDArray[np.float64]


@njit()
def cone_memory(rays):
    """Return working memory of `cone_echo` for so many rays."""
    whole = -(-rays // _WHOLE) * _WHOLE
    return ConeMemory(
        np.zeros(whole),
        np.zeros(whole),
        np.empty(whole),
        np.empty(whole, np.int64),
        np.empty((rays, _COLUMNS)),
    )


@njit(error_model="numpy")
def cone_echo(table, room, near, sensor, ring, limits, surfaces, memory):
    """Return the echo that one transducer detects.

    Parameters
    ----------
    table, room
        The faces.
    near : ndarray of int
        Numbers of those that its rays may meet, see `sim.envs.backends.compiled.fan.faces_near`.
    sensor : tuple of float
        Place (x, y) of the transducer and its axis.
    ring : RingGeometry
    limits : ConeLimits
    surfaces : sim.sonar.cone.kernel.Surfaces
    memory : ConeMemory
        From `cone_memory`.

    Returns
    -------
    echo_m : float
        Range of the first return, inf for none.
    surface, bounces : int
    incidence_cos : float
        Cosine of the angle of incidence.
    axis_range_m, cone_range_m : float
        True ranges on the axis and of the nearest surface in the cone.
    """
    segments, normals, circles, surface_of, _, grid, shape, cell_start, cell_face = table
    fan_dx, fan_dy, fan_leg_m, fan_face, rays = memory
    x, y, axis_rad = sensor
    far_m, max_bounces = limits.far_m, limits.max_bounces
    best_m, best_surface, best_cos, best_bounces = far_m, -1, math.nan, 0
    under_way = ring.cos_bearing.size
    cos_axis, sin_axis = math.cos(axis_rad), math.sin(axis_rad)
    for i in range(under_way):
        fan_dx[i], fan_dy[i] = turned(cos_axis, sin_axis, ring.cos_bearing[i], ring.sin_bearing[i])
    meet_fan(table, near, x, y, fan_dx, fan_dy, under_way, far_m, fan_leg_m, fan_face)
    axis_range_m, cone_range_m = fan_leg_m[under_way // 2], math.inf
    for i in range(under_way):
        cone_range_m = min(cone_range_m, fan_leg_m[i])

    for bounce in range(max_bounces + 1):
        mirrored = 0
        for i in range(under_way):
            if bounce == 0:
                from_x, from_y, dx, dy = x, y, fan_dx[i], fan_dy[i]
                path_m, strength = 0.0, 1.0
                leg_m, face = fan_leg_m[i], fan_face[i]
            else:
                from_x, from_y, dx, dy = rays[i, _X], rays[i, _Y], rays[i, _DX], rays[i, _DY]
                path_m, strength = rays[i, _PATH], rays[i, _STRENGTH]
                if path_m > best_m:
                    continue
                leg_m, face = first_hit(
                    segments, circles, grid, shape, cell_start, cell_face,
                    room, from_x, from_y, dx, dy, best_m - path_m,
                )  # fmt: skip
            path_m += leg_m
            # What is farther than the first return so far says nothing more.
            if face < 0 or path_m > best_m:
                continue
            surface = surface_of[face]
            strength *= surfaces.reflectivity[surface]
            if strength < limits.threshold:
                continue
            nx, ny = face_normal(
                normals, circles, face, from_x + leg_m * dx, from_y + leg_m * dy, dx, dy
            )
            cos = -(dx * nx + dy * ny)
            if cos >= surfaces.critical_cos[surface]:
                # An echo from exactly the maximum range is one.
                if path_m < best_m or (best_surface < 0 and path_m == best_m):
                    best_m, best_surface = path_m, surface
                    best_cos, best_bounces = cos, bounce
            elif bounce < max_bounces:
                # The rays that go on take the place of those that are done.
                along = dx * nx + dy * ny
                rays[mirrored, _X] = from_x + (leg_m * dx + OFF_SURFACE_M * nx)
                rays[mirrored, _Y] = from_y + (leg_m * dy + OFF_SURFACE_M * ny)
                rays[mirrored, _DX] = dx - 2 * along * nx
                rays[mirrored, _DY] = dy - 2 * along * ny
                rays[mirrored, _PATH], rays[mirrored, _STRENGTH] = path_m, strength
                mirrored += 1
        under_way = 0
        for i in range(mirrored):
            if rays[i, _PATH] + OFF_SURFACE_M < best_m:
                for column in range(_COLUMNS):
                    rays[under_way, column] = rays[i, column]
                under_way += 1
        if under_way == 0:
            break

    echo_m = best_m if best_surface >= 0 else math.inf
    return echo_m, best_surface, best_bounces, best_cos, axis_range_m, cone_range_m
