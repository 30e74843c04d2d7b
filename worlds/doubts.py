"""`doubts`: what is allowed in a room but may not be what was meant."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from sonarmap.errors import positive
from worlds.materials import MATERIALS
from worlds.solids import Solid
from worlds.world import World

__all__ = ["Doubt", "doubts"]

# Where the rules below are not geometry, their limits are assumed.
_MIRROR_BELOW_M = 0.00087  # Rayleigh: an eighth of the wavelength of 49.4 kHz
_LOWEST_M, _HIGHEST_M = 0.15, 10.0
_OVERLAP_SHARE = 0.5
_ROOM_M2 = 0.5
_REACHED_SHARE = 0.6
_FAR_M = 3.0
_SEGMENTS = 8


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something of a room that may be a mistake.

    Parameters
    ----------
    rule : str
        Which of the rules found it: start, route, reach, material, height, thin, overlap, bounds.
    place : str
        What it is about: a solid's name, ``start``, ``route_m[2]``, ``bounds_m``.
    message : str
        What is doubtful, in words.
    """

    rule: str
    place: str
    message: str

    def __str__(self) -> str:
        """Return ``place: message``."""
        return f"{self.place}: {self.message}"


def doubts(
    world: World, *, robot_radius_m: float = 0.18, resolution_m: float = 0.05
) -> tuple[Doubt, ...]:
    """Return what is doubtful of a room, the gravest first.

    Parameters
    ----------
    world : World
        A room; that it is one keeps the rules that all rooms keep.
    robot_radius_m : float
        Radius of the robot that shall drive there, by default the AmigoBot's.
    resolution_m : float
        Cells of the maps that shall be made of it.
    """
    radius_m = positive("robot_radius_m", robot_radius_m)
    cell_m = positive("resolution_m", resolution_m)
    # Older versions of GEOS divide by zero within, where nothing is wrong, and numpy notices.
    with np.errstate(divide="ignore", invalid="ignore"):
        return (
            *_of_start_and_route(world, radius_m),
            *_of_reach(world, radius_m),
            *_of_materials(world),
            *_of_heights(world),
            *_of_thickness(world, cell_m),
            *_of_overlaps(world),
            *_of_bounds(world),
        )


def _of_start_and_route(world: World, radius_m: float) -> Iterator[Doubt]:
    outlines = np.array([solid.outline for solid in world.solids])
    points = [(world.start.x_m, world.start.y_m), *world.route_m]
    legs = [shapely.Point(points[0]), *(shapely.LineString(ends) for ends in pairwise(points))]
    for i, leg in enumerate(legs):
        apart_m = shapely.distance(outlines, leg)
        nearest = int(apart_m.argmin())
        if apart_m[nearest] < radius_m:
            what, place = (
                ("the robot", "start") if i == 0 else ("the leg to it", f"route_m[{i - 1}]")
            )
            name, near = world.solids[nearest].name, float(apart_m[nearest])
            yield Doubt(
                "start" if i == 0 else "route",
                place,
                f"{what} meets {name!r}, {near:.2f} m away: a robot of {radius_m:g} m radius "
                "touches it",
            )


def _of_reach(world: World, radius_m: float) -> Iterator[Doubt]:
    """Doubt rooms where the robot does not come to, and a start that leads hardly anywhere."""
    taken = shapely.union_all([solid.outline for solid in world.solids])
    free = shapely.box(*world.bounds_m).difference(taken)
    start = shapely.Point(world.start.x_m, world.start.y_m)
    here = _piece_with(free, start)
    # The free space that counts is that of the start and of other rooms; what lies outside of the
    # outer walls reaches the bounds.
    edge = shapely.box(*world.bounds_m).exterior
    rooms = [p for p in shapely.get_parts(free) if p.equals(here) or not p.intersects(edge)]
    parts = [part for room in rooms for part in shapely.get_parts(_shrunk(room, radius_m))]
    mine = next((part for part in parts if part.dwithin(start, 1e-6)), None)
    if mine is None:
        return  # the robot does not even fit at the start, which is said already
    others = [part for part in parts if part is not mine and part.area >= _ROOM_M2]
    for other in sorted(others, key=lambda part: (-part.area, part.bounds)):
        at = other.representative_point()
        where = f"{other.area:.1f} m² about [{at.x:.2f}, {at.y:.2f}] cannot be reached"
        if here is not None and here.covers(at):
            gap = shapely.shortest_line(mine, other)
            x, y = gap.interpolate(0.5, normalized=True).coords[0]
            wide_m = 2 * _widest(here, start, at, radius_m)
            robot_m = 2 * radius_m
            why = f"the way by [{x:.2f}, {y:.2f}] is {wide_m:.2f} m wide, the robot {robot_m:g} m"
        else:
            why = "no opening leads there"
        yield Doubt("reach", "start", f"{where}: {why}")
    whole = sum(part.area for part in parts)
    if mine.area < _REACHED_SHARE * whole:
        yield Doubt(
            "reach",
            "start",
            f"the robot comes to {mine.area / whole:.0%} of the free space that it fits in",
        )


def _widest(room: BaseGeometry, start: shapely.Point, at: shapely.Point, high_m: float) -> float:
    """Return the radius of the largest robot that comes from one place to another."""
    low_m = 0.0
    for _ in range(8):
        middle_m = (low_m + high_m) / 2
        part = _piece_with(_shrunk(room, middle_m), start)
        low_m, high_m = (middle_m, high_m) if part and part.covers(at) else (low_m, middle_m)
    return low_m


def _shrunk(area: BaseGeometry, by_m: float) -> BaseGeometry:
    return area.buffer(-by_m, quad_segs=_SEGMENTS)


def _piece_with(area: BaseGeometry, point: shapely.Point) -> BaseGeometry | None:
    return next((part for part in shapely.get_parts(area) if part.covers(point)), None)


def _of_materials(world: World) -> Iterator[Doubt]:
    for material in dict.fromkeys(solid.material for solid in world.solids):
        if material == MATERIALS.get(material.name):
            continue
        place = f"materials.{material.name}"
        critical_deg = math.degrees(material.critical_incidence_rad)
        rough_mm = material.roughness_m * 1000
        if rough_mm > 50:
            yield Doubt("material", place, f"roughness_mm {rough_mm:g}: are those millimetres?")
        elif material.roughness_m >= _MIRROR_BELOW_M and critical_deg < 30:
            yield Doubt(
                "material",
                place,
                f"as rough as {rough_mm:g} mm it scatters, yet mirrors beyond {critical_deg:.0f} "
                "degrees; rough presets have 45 and more",
            )
        elif material.roughness_m < _MIRROR_BELOW_M and critical_deg > 40:
            yield Doubt(
                "material",
                place,
                f"as smooth as {rough_mm:g} mm it is a mirror, yet is seen up to "
                f"{critical_deg:.0f} degrees; smooth presets have 25 and less",
            )
        if material.reflectivity < 0.05:
            yield Doubt("material", place, f"reflectivity {material.reflectivity:g}: never heard")


def _of_heights(world: World) -> Iterator[Doubt]:
    for solid in world.solids:
        if solid.height_m < _LOWEST_M:
            what = "lower than a sonar is mounted: a real one looks over it, the simulated does not"
            yield Doubt("height", solid.name, f"height_m {solid.height_m:g} is {what}")
        elif solid.height_m > _HIGHEST_M:
            yield Doubt("height", solid.name, f"height_m {solid.height_m:g}: are those metres?")


def _of_thickness(world: World, cell_m: float) -> Iterator[Doubt]:
    half_m = cell_m / 2
    taken = shapely.union_all([solid.outline for solid in world.solids])
    # What stands close before a wall is one with it: slits are closed, then what is thin is lost.
    closed = taken.buffer(half_m, join_style="mitre").buffer(-half_m, join_style="mitre")
    thick = closed.buffer(-half_m, join_style="mitre").buffer(half_m, join_style="mitre")
    thin = [
        solid.name
        for solid in world.solids
        if solid.circle is None and solid.outline.difference(thick).area > 0.5 * _area(solid)
    ]
    if thin:
        names = ", ".join(repr(name) for name in thin[:3]) + (", ..." if len(thin) > 3 else "")
        yield Doubt(
            "thin",
            thin[0],
            f"thinner than a cell of {cell_m:g} m: {len(thin)} ({names}); a map shows a whole cell",
        )


def _of_overlaps(world: World) -> Iterator[Doubt]:
    for one, other in combinations(world.solids, 2):
        smaller, larger = sorted((one, other), key=_area)
        shared = _shared(smaller, larger)
        if shared > _OVERLAP_SHARE:
            yield Doubt(
                "overlap", smaller.name, f"{shared:.0%} of it lies inside of {larger.name!r}"
            )


def _area(solid: Solid) -> float:
    return float(solid.outline.area)


def _shared(smaller: Solid, larger: Solid) -> float:
    if not smaller.outline.intersects(larger.outline):
        return 0.0
    return float(smaller.outline.intersection(larger.outline).area) / _area(smaller)


def _of_bounds(world: World) -> Iterator[Doubt]:
    points = shapely.multipoints([(world.start.x_m, world.start.y_m), *world.route_m])
    used = shapely.total_bounds([*(solid.outline for solid in world.solids), points])
    x_min, y_min, x_max, y_max = world.bounds_m
    for size_m, wide_m, side in (
        (x_max - x_min, used[2] - used[0], "wide"),
        (y_max - y_min, used[3] - used[1], "high"),
    ):
        if size_m > 2 * (wide_m + 2 * _FAR_M):
            yield Doubt(
                "bounds",
                "bounds_m",
                f"{size_m:g} m {side}, where all that stands there and the route need "
                f"{wide_m:.1f} m",
            )
