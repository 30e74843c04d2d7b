"""What holds in every world, whatever it was read from; messages are ``place: rule``."""

from __future__ import annotations

from collections.abc import Sequence

from shapely import Point, box

from sonarmap.errors import InputError, finite
from worlds.materials import Material
from worlds.solids import Solid

__all__ = ["check_free", "check_inside", "check_solids", "checked_bounds", "finite_numbers"]

Bounds = tuple[float, float, float, float]

WIDEST_M = 1000.0
"""No room is wider: millimetres, or places of a map of the world, taken for metres. Assumed."""


def finite_numbers(place: str, values: Sequence[float], picture: str) -> tuple[float, ...]:
    """Return as many finite numbers as the `picture` of them, such as ``[x, y]``, shows."""
    count = picture.count(",") + 1
    try:
        numbers = tuple(finite(place, value) for value in values)
    except (TypeError, InputError):
        numbers = ()
    if len(numbers) != count:
        raise InputError(f"{place}: must be {picture}, finite numbers, got {values!r}")
    return numbers


def checked_bounds(bounds_m: Sequence[float]) -> Bounds:
    """Return bounds in order, or raise `InputError`."""
    picture = "[xmin, ymin, xmax, ymax]"
    x_min, y_min, x_max, y_max = finite_numbers("bounds_m", bounds_m, picture)
    if x_min >= x_max or y_min >= y_max:
        got = [x_min, y_min, x_max, y_max]
        raise InputError(f"bounds_m: must be {picture} with min < max, got {got}")
    side_m = max(x_max - x_min, y_max - y_min)
    if side_m > WIDEST_M:
        raise InputError(f"bounds_m: must be metres, at most {WIDEST_M:g} a side, got {side_m:g}")
    return x_min, y_min, x_max, y_max


def check_solids(solids: Sequence[Solid], places: Sequence[str]) -> None:
    """Raise `InputError` if something is no solid, is of no material, or two have one name."""
    if not solids:
        raise InputError("wall: a room must have a wall, a box or a pillar, got none")
    first: dict[str, str] = {}
    for place, solid in zip(places, solids, strict=True):
        if not isinstance(solid, Solid):
            raise InputError(f"{place}: must be a Solid, got {solid!r}")
        if not isinstance(solid.material, Material):
            raise InputError(f"{place}.material: must be a Material, got {solid.material!r}")
        if solid.name in first:
            raise InputError(f"{place}.name: {solid.name!r} is already that of {first[solid.name]}")
        first[solid.name] = place


def check_inside(solids: Sequence[Solid], places: Sequence[str], bounds_m: Bounds) -> None:
    """Raise `InputError` if a solid lies wholly outside of the bounds."""
    bounds = box(*bounds_m)
    for place, solid in zip(places, solids, strict=True):
        if not bounds.intersects(solid.outline):
            raise InputError(
                f"{place}: {solid.name!r} lies wholly outside of bounds_m {list(bounds_m)}"
            )


def check_free(
    place: str, point_m: tuple[float, float], solids: Sequence[Solid], bounds_m: Bounds
) -> None:
    """Raise `InputError` if a point lies outside of the bounds or inside of a solid."""
    x_m, y_m = point_m
    x_min, y_min, x_max, y_max = bounds_m
    if not (x_min < x_m < x_max and y_min < y_m < y_max):
        raise InputError(
            f"{place}: [{x_m:g}, {y_m:g}] must lie inside of bounds_m {list(bounds_m)}"
        )
    for solid in solids:
        if solid.outline.intersects(Point(point_m)):
            raise InputError(f"{place}: [{x_m:g}, {y_m:g}] lies inside of {solid.name!r}")
