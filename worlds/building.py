"""From checked tables to a `World`, with the rules that hold between tables."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from shapely import Point, Polygon, box

from sonarmap.errors import InputError, did_you_mean
from worlds.materials import MATERIALS, Material
from worlds.outlines import box_outline, pillar_outline, wall_outline
from worlds.schema import (
    BoxTable,
    MaterialTable,
    PillarTable,
    StartTable,
    WallTable,
    WorldTable,
)
from worlds.world import Pose, Solid, World

__all__ = ["build"]

_SolidTable = WallTable | BoxTable | PillarTable


def build(name: str, table: WorldTable, parameters: Mapping[str, float]) -> World:
    """Return the world that a file describes.

    Raises
    ------
    InputError
        If names repeat, a material is unknown, a shape is impossible, a solid lies wholly
        outside of the bounds, or the start or a way point is not free; as ``key: rule``.
    """
    own = {key: _material(key, entry) for key, entry in table.materials.items()}
    tables = list(_solid_tables(table))
    places = [place for place, _ in tables]
    world = World(
        name=name,
        title=table.title,
        source=table.source,
        bounds_m=table.bounds_m,
        start=_pose(table.start),
        route_m=table.route_m,
        solids=tuple(_solid(place, entry, {**MATERIALS, **own}) for place, entry in tables),
        notes=dict(_notes(table)),
        parameters=parameters,
    )
    _check_names(world, places)
    _check_bounds(world, places)
    _check_free("start", (world.start.x_m, world.start.y_m), world)
    for i, point in enumerate(world.route_m):
        _check_free(f"route_m[{i}]", point, world)
    return world


def _solid_tables(table: WorldTable) -> Iterator[tuple[str, _SolidTable]]:
    kinds: tuple[tuple[str, Sequence[_SolidTable]], ...] = (
        ("wall", table.wall),
        ("box", table.box),
        ("pillar", table.pillar),
    )
    for kind, entries in kinds:
        for i, entry in enumerate(entries):
            yield f"{kind}[{i}]", entry


def _solid(place: str, table: _SolidTable, materials: Mapping[str, Material]) -> Solid:
    if table.material not in materials:
        hint = did_you_mean(table.material, materials)
        raise InputError(f"{place}.material: unknown material {table.material!r}{hint}")
    circle = None
    match table:
        case WallTable():
            outline = _wall(place, table)
        case BoxTable():
            length_m, width_m = table.size_m
            outline = box_outline(
                table.centre_m,
                length_m=length_m,
                width_m=width_m,
                heading_rad=math.radians(table.heading_deg),
            )
        case PillarTable():
            outline = pillar_outline(table.centre_m, radius_m=table.radius_m)
            circle = (*table.centre_m, table.radius_m)
    return Solid(table.name, materials[table.material], table.height_m, outline, circle)


def _wall(place: str, table: WallTable) -> Polygon:
    try:
        return wall_outline(
            table.points_m, closed=table.closed, thickness_m=table.thickness_m, side=table.side
        )
    except InputError as error:
        raise InputError(f"{place}.points_m: {error}") from None


def _material(name: str, table: MaterialTable) -> Material:
    critical_rad = math.radians(table.critical_incidence_deg)
    return Material(
        name,
        critical_rad,
        table.reflectivity,
        table.roughness_mm / 1000,
        table.diffuse_floor_db,
    )


def _pose(table: StartTable) -> Pose:
    return Pose(table.x_m, table.y_m, math.radians(table.heading_deg))


def _notes(table: WorldTable) -> Iterator[tuple[str, str]]:
    """Give (place, text) of every note in the file, the place as messages name it."""
    tables: list[tuple[str, Mapping[str, str]]] = [("", table.notes)]
    tables += [("start.", table.start.notes)]
    tables += [(f"{place}.", entry.notes) for place, entry in _solid_tables(table)]
    tables += [(f"materials.{name}.", entry.notes) for name, entry in table.materials.items()]
    tables += [("parameters.", table.parameters.notes)]
    tables += [
        (f"parameters.{name}.", entry.notes) for name, entry in table.parameters.by_name.items()
    ]
    for prefix, notes in tables:
        for key, text in notes.items():
            yield f"{prefix}{key}", text


def _check_names(world: World, places: Sequence[str]) -> None:
    first: dict[str, str] = {}
    for place, solid in zip(places, world.solids, strict=True):
        if solid.name in first:
            raise InputError(f"{place}.name: {solid.name!r} is already that of {first[solid.name]}")
        first[solid.name] = place


def _check_bounds(world: World, places: Sequence[str]) -> None:
    bounds = box(*world.bounds_m)
    for place, solid in zip(places, world.solids, strict=True):
        if not bounds.intersects(solid.outline):
            raise InputError(
                f"{place}: {solid.name!r} lies wholly outside of bounds_m {list(world.bounds_m)}"
            )


def _check_free(place: str, point_m: tuple[float, float], world: World) -> None:
    x_m, y_m = point_m
    x_min, y_min, x_max, y_max = world.bounds_m
    if not (x_min < x_m < x_max and y_min < y_m < y_max):
        raise InputError(
            f"{place}: [{x_m:g}, {y_m:g}] must lie inside of bounds_m {list(world.bounds_m)}"
        )
    for solid in world.solids:
        if solid.outline.intersects(Point(point_m)):
            raise InputError(f"{place}: [{x_m:g}, {y_m:g}] lies inside of {solid.name!r}")
