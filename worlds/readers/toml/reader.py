"""`read_toml`: from the tables of a world file to a `World`."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from sonarmap.errors import InputError
from sonarmap.files import decoded
from worlds.materials import Material, find_material
from worlds.readers.toml.schema import (
    BoxTable,
    MaterialTable,
    PillarTable,
    StartTable,
    WallTable,
    WorldTable,
    parse_world,
)
from worlds.solids import Solid
from worlds.world import Pose, World

__all__ = ["read_toml", "world_of"]

_SolidTable = WallTable | BoxTable | PillarTable


def read_toml(path: Path, /, **parameters: float) -> World:
    """Return the world that a TOML file describes.

    Parameters
    ----------
    path : Path
        The file.
    **parameters : float
        Parameters of the room to set in place of their defaults.

    Raises
    ------
    InputError
        If the file is not TOML, a key breaks its rule, or the world one of `World.of`; as
        ``key: rule``.
    """
    return world_of(path.stem, _tables(path), parameters)


def world_of(
    name: str, tables: Mapping[str, Any], parameters: Mapping[str, float] = MappingProxyType({})
) -> World:
    """Return the world called `name` that the tables of a file describe, see `read_toml`."""
    table, values = parse_world(tables, parameters)
    own = {key: _material(key, entry) for key, entry in table.materials.items()}
    placed = list(_solid_tables(table))
    return World.of(
        name,
        [_solid(place, entry, own) for place, entry in placed],
        bounds_m=table.bounds_m,
        start=_pose(table.start),
        route_m=table.route_m,
        title=table.title,
        source=table.source,
        notes=dict(_notes(table)),
        parameters=values,
        places=[place for place, _ in placed],
    )


def _tables(path: Path) -> dict[str, Any]:
    try:
        text = decoded(path.read_bytes())
    except UnicodeDecodeError:
        raise InputError("is not a world file: not UTF-8 text") from None
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InputError("is not TOML: nested too deeply") from None
    except ValueError as error:  # what it says itself, or Python of a number of 5000 digits
        raise InputError(f"is not TOML: {error}") from None


def _solid_tables(table: WorldTable) -> Iterator[tuple[str, _SolidTable]]:
    """Give (place, table) of every solid, the place as messages name it."""
    for kind in ("wall", "box", "pillar"):
        for i, entry in enumerate(getattr(table, kind)):
            yield f"{kind}[{i}]", entry


def _solid(place: str, table: _SolidTable, own: Mapping[str, Material]) -> Solid:
    try:
        material = find_material(table.material, own)
        match table:
            case WallTable():
                return Solid.wall(
                    table.name,
                    table.points_m,
                    closed=table.closed,
                    thickness_m=table.thickness_m,
                    side=table.side,
                    height_m=table.height_m,
                    material=material,
                )
            case BoxTable():
                return Solid.box(
                    table.name,
                    table.centre_m,
                    table.size_m,
                    heading_rad=math.radians(table.heading_deg),
                    height_m=table.height_m,
                    material=material,
                )
            case PillarTable():
                return Solid.pillar(
                    table.name,
                    table.centre_m,
                    table.radius_m,
                    height_m=table.height_m,
                    material=material,
                )
    except InputError as error:
        raise InputError(f"{place}.{error}") from None


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
