"""Corridors: long, with turns, recesses and doors, mostly smooth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import shapely
from shapely.geometry.polygon import orient

from worlds.generation.base import SMOOTH_MOST, Style
from worlds.generation.site import NoRoomError, Site
from worlds.generation.things import Part

__all__ = ["Corridor"]

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Corridor(Style):
    """A corridor with turns, side arms and recesses for doors.

    Parameters
    ----------
    width_min_m, width_max_m : float
        Its clear width.
    part_min_m, part_max_m : float
        Length of each part between two turns, the last included.
    turns_min, turns_max : int
        How many turns.
    slanted_share : float
        Share of turns that are not right angles but 30 to 60 degrees.
    arm_share : float
        Share of corridors from which a side arm leads off.
    recess_per_m : float
        Recesses to each metre of length; most have a door at their back.
    recess_min_m, recess_max_m : float
        Depth of a recess.
    door_materials : str
        Materials of the doors by share.
    """

    name: ClassVar[str] = "corridor"
    about: ClassVar[str] = "A corridor with turns and recesses"

    wall_materials: str = SMOOTH_MOST
    width_min_m: float = 1.2
    width_max_m: float = 2.4
    part_min_m: float = 3.5
    part_max_m: float = 12.0
    turns_min: int = 0
    turns_max: int = 3
    slanted_share: float = 0.25
    arm_share: float = 0.3
    recess_per_m: float = 0.3
    recess_min_m: float = 0.08
    recess_max_m: float = 0.5
    door_materials: str = "wood:4,metal:2,glass:1"
    pillars_per_m2: float = 0.0
    beside_per_m2: float = 0.05
    clutter_per_m2: float = 0.03
    stops_min: int = 1
    stops_max: int = 1

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls; the ends of all parts must be visited."""
        dice = site.dice
        width_m = dice.uniform(self.width_min_m, self.width_max_m)
        self.wide_enough(site, "width_min_m", self.width_min_m)
        line = self._line(site)
        lines = [line]
        if dice.chance(self.arm_share):
            lines.append(self._arm(site, line))
        body = shapely.union_all(
            [each.buffer(width_m / 2, cap_style="flat", join_style="mitre") for each in lines]
        )
        floor, doors = self._with_recesses(site, body)
        floor = shapely.set_precision(floor, 0.001).simplify(0.0015)
        if not isinstance(floor, shapely.Polygon) or floor.interiors:
            raise NoRoomError("the corridor meets itself")
        self.enclose(site, floor)
        for part, at, heading_deg in doors:
            site.put([part], at=at, heading_deg=heading_deg, apart_m=0.001)
        stops = [point for each in lines for point in each.coords]
        return [
            shapely.Point(stop).buffer(0.8 * width_m).intersection(site.floor) for stop in stops
        ]

    def _line(self, site: Site) -> shapely.LineString:
        dice = site.dice
        heading = math.radians(90 * dice.whole(0, 3))
        points = [(0.0, 0.0)]
        turn = dice.sign()
        for i in range(dice.whole(self.turns_min, self.turns_max) + 1):
            if i:
                # To and fro more often than round, or the corridor meets itself.
                turn = -turn if dice.chance(0.6) else turn
                angle = dice.uniform(30, 60) if dice.chance(self.slanted_share) else 90.0
                heading += turn * math.radians(angle)
            length_m = dice.uniform(self.part_min_m, self.part_max_m)
            x, y = points[-1]
            points.append((x + length_m * math.cos(heading), y + length_m * math.sin(heading)))
        line = shapely.LineString(points)
        if not line.is_simple:
            raise NoRoomError("the corridor crosses itself")
        return line

    def _arm(self, site: Site, line: shapely.LineString) -> shapely.LineString:
        dice = site.dice
        ends = list(line.coords)
        i = dice.whole(0, len(ends) - 2)
        (x, y), (to_x, to_y) = ends[i], ends[i + 1]
        share, side = dice.uniform(0.3, 0.7), dice.sign()
        length_m = dice.uniform(self.part_min_m, min(self.part_max_m, 2 * self.part_min_m))
        along = math.dist(ends[i], ends[i + 1])
        cos, sin = (to_x - x) / along, (to_y - y) / along
        root = (x + share * (to_x - x), y + share * (to_y - y))
        tip = (root[0] - side * sin * length_m, root[1] + side * cos * length_m)
        return shapely.LineString([root, tip])

    def _with_recesses(
        self, site: Site, body: shapely.Polygon
    ) -> tuple[shapely.Polygon, list[tuple[Part, Point, float]]]:
        """Return the floor with recesses in its walls, and the doors at their backs."""
        dice, floor = site.dice, body
        doors = []
        taken: list[shapely.Polygon] = []
        for begin, end in pairwise(orient(body).exterior.coords):
            side = _Side(begin, end)
            for _ in range(int(side.length_m * self.recess_per_m / 2 + dice.uniform(0, 1))):
                half_m = dice.uniform(0.8, 1.3) / 2
                deep_m = dice.uniform(self.recess_min_m, self.recess_max_m)
                has_door, leaf_m = dice.chance(0.75), dice.uniform(0.03, 0.05)
                material = self.material(site, "door_materials")
                if side.length_m < 2 * half_m + 0.5:
                    continue
                at_m = dice.uniform(0.25 + half_m, side.length_m - half_m - 0.25)
                recess = side.box(at_m - half_m, at_m + half_m, -0.02, deep_m)
                beyond = side.box(at_m - half_m, at_m + half_m, 0.02, deep_m)
                wall = recess.buffer(2 * self.wall_thickness_m)
                if body.intersects(beyond) or any(wall.intersects(other) for other in taken):
                    continue
                taken.append(recess)
                floor = floor.union(recess)
                if has_door and deep_m > leaf_m + 0.01:
                    leaf = Part("door", (2 * half_m - 0.006, leaf_m), material, 2.0)
                    back = side.at(at_m, deep_m - leaf_m / 2 - 0.003)
                    doors.append((leaf, back, side.heading_deg))
        return floor, doors


class _Side:
    """A straight side of the corridor, seen along it with the corridor on the left."""

    def __init__(self, begin: Point, end: Point) -> None:
        self.begin = begin
        self.length_m = math.dist(begin, end)
        heading_rad = math.atan2(end[1] - begin[1], end[0] - begin[0])
        self.heading_deg = math.degrees(heading_rad)
        self._cos, self._sin = math.cos(heading_rad), math.sin(heading_rad)

    def at(self, along_m: float, out_m: float) -> Point:
        """Return the place so far along the side and outside of it."""
        x, y = self.begin
        return (
            x + self._cos * along_m + self._sin * out_m,
            y + self._sin * along_m - self._cos * out_m,
        )

    def box(self, from_m: float, to_m: float, near_m: float, far_m: float) -> shapely.Polygon:
        """Return the rectangle between two places along the side and two outside of it."""
        ends = ((from_m, near_m), (from_m, far_m), (to_m, far_m), (to_m, near_m))
        return shapely.Polygon([self.at(*corner) for corner in ends])
