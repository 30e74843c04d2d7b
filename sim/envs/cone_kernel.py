"""The simple cone in one compiled call: `sim.ConeSonar.listen` on the faces of a room.

It finds the same first return as the steps in `sim.following`, ray by ray, and follows no ray
farther than the first return found so far.
"""

from __future__ import annotations

import math

from numba import njit

from sim.following import OFF_SURFACE_M, turned
from worlds.raycast import face_normal, first_hit

__all__ = ["RAY_COLUMNS", "hear_cone"]

# Rays under way: begin of the leg, direction, way so far, share of the amplitude that is left.
_X, _Y, _DX, _DY, _WAY, _STRENGTH, RAY_COLUMNS = range(7)


@njit(cache=True, error_model="numpy")
def hear_cone(
    table, room, x, y, axis_rad, cos_bearing, sin_bearing, far_m, max_bounces,
    critical_cos, reflectivity, threshold, rays,
):  # fmt: skip
    """Return what one transducer hears.

    Parameters
    ----------
    table, room
        The faces.
    x, y, axis_rad : float
        Place of the transducer and its axis.
    cos_bearing, sin_bearing : ndarray, shape (rays,)
        Bearings of the rays off the axis; the axis is in the middle.
    far_m, max_bounces, threshold
        See `sim.ConeSonar`.
    critical_cos, reflectivity : ndarray, shape (surfaces,)
        What the surfaces do to sound, see `sim.following.meet_surfaces`.
    rays : ndarray, shape (rays, RAY_COLUMNS)
        Working memory.

    Returns
    -------
    heard_m : float
        Range of the first return, inf for none.
    surface, bounces : int
    incidence_cos : float
        Cosine of the angle of incidence.
    axis_range_m, cone_range_m : float
        True ranges on the axis and of the nearest surface in the cone.
    """
    segments, normals, circles, surfaces, grid, shape, cell_start, cell_face = table
    best_m, best_surface, best_cos, best_bounces = far_m, -1, math.nan, 0
    axis_range_m, cone_range_m = math.inf, math.inf
    under_way = cos_bearing.size
    middle = under_way // 2
    cos_axis, sin_axis = math.cos(axis_rad), math.sin(axis_rad)
    for i in range(under_way):
        rays[i, _X], rays[i, _Y], rays[i, _WAY], rays[i, _STRENGTH] = x, y, 0.0, 1.0
        rays[i, _DX], rays[i, _DY] = turned(cos_axis, sin_axis, cos_bearing[i], sin_bearing[i])

    for bounce in range(max_bounces + 1):
        mirrored = 0
        for i in range(under_way):
            way_m, dx, dy = rays[i, _WAY], rays[i, _DX], rays[i, _DY]
            is_axis = bounce == 0 and i == middle
            # What is farther than the first return so far says nothing more, but on the axis.
            reach_m = far_m if is_axis else best_m - way_m
            if reach_m < 0.0:
                continue
            leg_m, face = first_hit(
                segments, circles, grid, shape, cell_start, cell_face,
                room, rays[i, _X], rays[i, _Y], dx, dy, reach_m,
            )  # fmt: skip
            if is_axis:
                axis_range_m = leg_m
            if bounce == 0:
                cone_range_m = min(cone_range_m, leg_m)
            if face < 0:
                continue
            way_m += leg_m
            surface = surfaces[face]
            strength = rays[i, _STRENGTH] * reflectivity[surface]
            if strength < threshold:
                continue
            hit_x, hit_y = rays[i, _X] + leg_m * dx, rays[i, _Y] + leg_m * dy
            nx, ny = face_normal(normals, circles, face, hit_x, hit_y, dx, dy)
            cos = -(dx * nx + dy * ny)
            if cos >= critical_cos[surface]:
                # An echo from exactly the maximum range is one.
                if way_m < best_m or (best_surface < 0 and way_m == best_m):
                    best_m, best_surface = way_m, surface
                    best_cos, best_bounces = cos, bounce
            elif bounce < max_bounces:
                # The rays that go on take the place of those that are done.
                rays[mirrored, _X] = rays[i, _X] + (leg_m * dx + OFF_SURFACE_M * nx)
                rays[mirrored, _Y] = rays[i, _Y] + (leg_m * dy + OFF_SURFACE_M * ny)
                along = dx * nx + dy * ny
                rays[mirrored, _DX], rays[mirrored, _DY] = (
                    dx - 2 * along * nx,
                    dy - 2 * along * ny,
                )
                rays[mirrored, _WAY], rays[mirrored, _STRENGTH] = way_m, strength
                mirrored += 1
        under_way = 0
        for i in range(mirrored):
            if rays[i, _WAY] + OFF_SURFACE_M < best_m:
                for column in range(RAY_COLUMNS):
                    rays[under_way, column] = rays[i, column]
                under_way += 1
        if under_way == 0:
            break

    heard_m = best_m if best_surface >= 0 else math.inf
    return heard_m, best_surface, best_bounces, best_cos, axis_range_m, cone_range_m
