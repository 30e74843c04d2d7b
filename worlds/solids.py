"""`Solid`: a thing that stands in a room, and the shapes that it may be made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shapely import Polygon

from sonarmap.errors import InputError, finite, one_of, positive
from worlds.materials import Material, find_material
from worlds.outlines import Point, box_outline, pillar_outline, polygon_outline, wall_outline

__all__ = ["Solid"]


@dataclass(frozen=True, slots=True)
class Solid:
    """A thing that stands in a room and sends sound back.

    It is made by `wall`, `box`, `pillar` or `polygon`, which check what they are given; their
    messages start with the name of the argument.

    Parameters
    ----------
    name : str
        Name of its surface, unique in the world.
    material : Material
        What its surface does to sound.
    height_m : float
        Height above the floor, metres.
    outline : shapely.Polygon
        Its shape seen from above. A pillar's is a polygon inscribed in its circle.
    circle : tuple of float, optional
        (x, y, radius) of a pillar in metres, exact; None for everything else.
    """

    name: str
    material: Material
    height_m: float
    outline: Polygon
    circle: tuple[float, float, float] | None = None

    @classmethod
    def wall(
        cls,
        name: str,
        points_m: Sequence[Point],
        *,
        thickness_m: float,
        height_m: float,
        material: str | Material,
        closed: bool = False,
        side: str = "centre",
    ) -> Solid:
        """Return a wall along a line, see `worlds.outlines.wall_outline`.

        Parameters
        ----------
        name : str
            Its name, unique in the world.
        points_m : sequence of (x, y)
            The line, metres; a closed one does not repeat its first point.
        thickness_m, height_m : float
            In metres, > 0.
        material : str or Material
            A name in `worlds.MATERIALS`, or a material of one's own.
        closed : bool
            Whether the last point is joined to the first.
        side : {"centre", "left", "right"}
            Where the thickness lies, seen along the line.
        """
        made_of, height_m = _body(material, height_m)
        points = _points("points_m", points_m)
        thickness_m = positive("thickness_m", thickness_m)
        one_of("side", side, ("centre", "left", "right"))
        try:
            outline = wall_outline(points, closed=closed, thickness_m=thickness_m, side=side)
        except InputError as error:
            raise InputError(f"points_m: {error}") from None
        return cls(name, made_of, height_m, outline)

    @classmethod
    def box(
        cls,
        name: str,
        centre_m: Point,
        size_m: tuple[float, float],
        *,
        height_m: float,
        material: str | Material,
        heading_rad: float = 0.0,
    ) -> Solid:
        """Return a box of (length, width) `size_m` in metres, its length along the heading."""
        made_of, height_m = _body(material, height_m)
        length_m, width_m = _pair("size_m", size_m)
        outline = box_outline(
            _pair("centre_m", centre_m),
            length_m=positive("size_m[0]", length_m),
            width_m=positive("size_m[1]", width_m),
            heading_rad=finite("heading_rad", heading_rad),
        )
        return cls(name, made_of, height_m, outline)

    @classmethod
    def pillar(
        cls,
        name: str,
        centre_m: Point,
        radius_m: float,
        *,
        height_m: float,
        material: str | Material,
    ) -> Solid:
        """Return a round post of `radius_m` metres about `centre_m`."""
        made_of, height_m = _body(material, height_m)
        x_m, y_m = _pair("centre_m", centre_m)
        radius_m = positive("radius_m", radius_m)
        outline = pillar_outline((x_m, y_m), radius_m=radius_m)
        return cls(name, made_of, height_m, outline, (x_m, y_m, radius_m))

    @classmethod
    def polygon(
        cls,
        name: str,
        points_m: Sequence[Point],
        *,
        height_m: float,
        material: str | Material,
        holes_m: Sequence[Sequence[Point]] = (),
    ) -> Solid:
        """Return a solid that fills the polygon of `points_m`, less the polygons of `holes_m`."""
        made_of, height_m = _body(material, height_m)
        holes = [_points(f"holes_m[{i}]", hole) for i, hole in enumerate(holes_m)]
        outline = polygon_outline(_points("points_m", points_m), holes)
        return cls(name, made_of, height_m, outline)


def _body(material: str | Material, height_m: float) -> tuple[Material, float]:
    return find_material(material), positive("height_m", height_m)


def _points(name: str, points_m: Sequence[Point]) -> list[Point]:
    return [_pair(f"{name}[{i}]", point) for i, point in enumerate(points_m)]


def _pair(name: str, values: Sequence[float]) -> tuple[float, float]:
    try:
        first, second = values
    except (TypeError, ValueError):
        raise InputError(f"{name} must be two numbers, got {values!r}") from None
    return finite(f"{name}[0]", first), finite(f"{name}[1]", second)
