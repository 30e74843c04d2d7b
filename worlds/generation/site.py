"""`Site`: a room while it is built. Whatever is put on it is rounded to millimetres first."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

from sonarmap.errors import InputError
from worlds.generation.dice import Dice
from worlds.generation.routing import pieces, tour
from worlds.generation.things import Part
from worlds.solids import Solid

__all__ = ["NoRoomError", "Site", "mm"]

Point = tuple[float, float]

# The outline of a thing's surroundings is drawn with few segments, inscribed in its round corners.
_SEGMENTS, _INSCRIBED = 4, 1.02


class NoRoomError(Exception):
    """A draw has no place for what must be there; the next one may."""


def mm(value_m: float) -> float:
    """Return metres rounded to millimetres, never -0.0."""
    return round(float(value_m), 3) + 0.0


class Site:
    """A room while it is built.

    Parameters
    ----------
    dice : Dice
        All that is random.
    radius_m : float
        Radius of the robot that shall drive here.
    margin_m : float
        How much more than its radius it keeps from everything.
    """

    def __init__(self, dice: Dice, *, radius_m: float, margin_m: float) -> None:
        self.dice = dice
        self.radius_m, self.margin_m = radius_m, margin_m
        self.tables: dict[str, list[dict[str, Any]]] = {"wall": [], "box": [], "pillar": []}
        self.outlines: list[shapely.Polygon] = []
        self.floor = shapely.Polygon()
        # Areas along whose sides furniture stands; none: all of the floor.
        self.rooms: list[shapely.Polygon] = []
        self.bounds_m: tuple[float, float, float, float] | None = None
        self.way_m: list[Point] = []
        self.heading_deg = 0
        self._reserved: BaseGeometry = shapely.Polygon()
        self._counts: Counter[str] = Counter()

    @property
    def clear_m(self) -> float:
        """How far the middle of the robot keeps from everything."""
        return self.radius_m + self.margin_m

    def wall(
        self,
        label: str,
        points_m: Iterable[Sequence[float]],
        *,
        material: str,
        thickness_m: float,
        height_m: float,
        closed: bool = False,
        side: str = "centre",
    ) -> shapely.Polygon:
        """Put up a wall and return its outline."""
        points = [(mm(x), mm(y)) for x, y in points_m]
        table: dict[str, Any] = {"name": self._name(label), "points_m": [list(p) for p in points]}
        shape: dict[str, Any] = {"closed": closed} if closed else {}
        shape |= {"side": side} if side != "centre" else {}
        shape |= {"thickness_m": mm(thickness_m), "height_m": mm(height_m), "material": material}
        try:
            solid = Solid.wall(table["name"], points, **shape)
        except InputError as error:
            raise NoRoomError(str(error)) from None
        self.tables["wall"].append(table | shape)
        self.outlines.append(solid.outline)
        return solid.outline

    def enclosed(
        self, floor: shapely.Polygon, *, material: str, thickness_m: float, height_m: float
    ) -> None:
        """Put a wall about a floor, which becomes that of the room."""
        points = _ring(floor)
        outline = self.wall(
            "walls",
            points,
            material=material,
            thickness_m=thickness_m,
            height_m=height_m,
            closed=True,
            side="right",
        )
        if len(outline.interiors) != 1:
            raise NoRoomError("the wall meets itself")
        self.floor = shapely.Polygon(outline.interiors[0])
        x_min, y_min, x_max, y_max = outline.bounds
        # Outwards to centimetres, so that the outermost face is inside.
        self.bounds_m = (
            math.floor(x_min * 100 + 1e-6) / 100,
            math.floor(y_min * 100 + 1e-6) / 100,
            math.ceil(x_max * 100 - 1e-6) / 100,
            math.ceil(y_max * 100 - 1e-6) / 100,
        )

    def put(self, parts: Sequence[Part], *, at: Point, heading_deg: float, apart_m: float) -> bool:
        """Put a thing somewhere if it fits there, and return whether it did.

        Parameters
        ----------
        parts : sequence of Part
            What it consists of, in its own frame.
        at : (x, y)
            Where its origin shall be, metres.
        heading_deg : float
            Where its x axis shall point; rounded to a tenth.
        apart_m : float
            How far from everything else it must be. Also it must stand on the floor and off the
            route.
        """
        # Most tries fail, and most of those at the middle already.
        middle = shapely.Point(mm(at[0]), mm(at[1]))
        others = np.array(self.outlines)
        if not self.floor.covers(middle) or self._reserved.intersects(middle):
            return False
        if shapely.dwithin(middle, others, apart_m).any():
            return False
        heading_deg = round(heading_deg, 1) % 360
        placed = [part.placed(at, heading_deg) for part in parts]
        solids = [part.solid(str(i)) for i, part in enumerate(placed)]
        outlines = np.array([solid.outline for solid in solids])
        whole = (
            outlines[0]
            if len(outlines) == 1
            else shapely.convex_hull(shapely.multipolygons(outlines))
        )
        if self._reserved.intersects(whole) or not self.floor.covers(whole):
            return False
        if shapely.dwithin(whole, others, apart_m).any():
            return False
        number = self._count(parts[0].thing)
        for part, outline in zip(placed, outlines, strict=True):
            kind, table = part.table(number)
            self.tables[kind].append(table)
            self.outlines.append(outline)
        return True

    def drive(self, areas: Sequence[shapely.Polygon], *, stops_min: int, stops_max: int) -> None:
        """Draw a route by a few stops in each of the areas, which from now on stays free.

        Raises
        ------
        NoRoomError
            If the robot does not come to each of them.
        """
        apart_m = self.clear_m * _INSCRIBED + 0.003
        clear = self.floor.buffer(-apart_m, quad_segs=_SEGMENTS)
        taken = shapely.union_all(
            shapely.buffer(np.array(self.outlines), apart_m, quad_segs=_SEGMENTS)
        )
        # An area may be a room's share of something, with lines where they only touch.
        areas = [shapely.union_all(pieces(area)) for area in areas]
        for piece in pieces(clear.difference(taken)):
            stops: list[Point] = []
            inner = piece.buffer(-0.02, quad_segs=_SEGMENTS)
            for area in areas:
                place = inner.intersection(area)
                count = self.dice.whole(stops_min, stops_max)
                stops += self._spread(place, count) if place.area > 0 else []
                if place.area == 0:
                    break
            else:
                way = tour(piece, self.dice.shuffled(stops))
                if way is not None and len(way) > 1:
                    self._take(way)
                    return
            if piece.area < 0.3 * clear.area:
                break
        raise NoRoomError("the robot does not come everywhere")

    def _take(self, way: list[Point]) -> None:
        rounded = [(mm(x), mm(y)) for x, y in way]
        # A stop beside the way of another would be driven to and back from.
        self.way_m = [rounded[0]]
        for point in rounded[1:]:
            if math.dist(point, self.way_m[-1]) >= 0.05:
                self.way_m.append(point)
        if len(self.way_m) < 2:
            raise NoRoomError("the route has no length")
        (x, y), (to_x, to_y) = self.way_m[:2]
        self.heading_deg = round(math.degrees(math.atan2(to_y - y, to_x - x)))
        line = shapely.LineString(self.way_m)
        if shapely.distance(line, np.array(self.outlines)).min(initial=math.inf) < self.clear_m:
            raise NoRoomError("the route comes too near")
        self._reserved = line.buffer(self.clear_m * _INSCRIBED + 0.003, quad_segs=_SEGMENTS)
        shapely.prepare(self._reserved)

    def _spread(self, place: BaseGeometry, count: int) -> list[Point]:
        """Return random points of an area, each as far from the others as a few tries find."""
        found: list[Point] = []
        for _ in range(count):
            tries = [self._somewhere(place) for _ in range(4)]
            away = [min((math.dist(p, q) for q in found), default=0.0) for p in tries]
            found.append(tries[away.index(max(away))])
        return found

    def _somewhere(self, place: BaseGeometry) -> Point:
        x_min, y_min, x_max, y_max = place.bounds
        for _ in range(60):
            x, y = mm(self.dice.uniform(x_min, x_max)), mm(self.dice.uniform(y_min, y_max))
            if place.covers(shapely.Point(x, y)):
                return x, y
        inside = place.representative_point()
        return mm(inside.x), mm(inside.y)

    def _name(self, label: str) -> str:
        return label if label == "walls" else f"{label} {self._count(label)}"

    def _count(self, label: str) -> int:
        self._counts[label] += 1
        return self._counts[label]


def _ring(floor: shapely.Polygon) -> list[Point]:
    """Return the corners of a floor, counter-clockwise from the lowest of the leftmost ones.

    Where a ring begins and whether it has points on its sides is up to the version of GEOS.
    """
    points = [(mm(x), mm(y)) for x, y in orient(floor).exterior.coords[:-1]]
    corners = [
        here
        for before, here, after in zip(
            points[-1:] + points[:-1], points, points[1:] + points[:1], strict=True
        )
        if not _in_line(before, here, after)
    ]
    first = corners.index(min(corners)) if corners else 0
    return corners[first:] + corners[:first]


def _in_line(a: Point, b: Point, c: Point) -> bool:
    (ax, ay), (bx, by), (cx, cy) = a, b, c
    return abs((bx - ax) * (cy - by) - (by - ay) * (cx - bx)) < 1e-9
