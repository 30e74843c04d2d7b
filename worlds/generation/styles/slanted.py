"""Rooms whose walls and partitions are met aslant: mirrors that are never seen head-on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely

from worlds.generation.base import SMOOTH_MOST, Style
from worlds.generation.site import Site
from worlds.generation.things import Part

__all__ = ["Slanted"]


@dataclass(frozen=True, kw_only=True)
class Slanted(Style):
    """A room with cut corners, turned against the axes, with slanting screens in it.

    Parameters
    ----------
    side_min_m, side_max_m : float
        Of either side.
    cut_share : float
        Share of corners that are cut off by a slanting wall.
    screens_min, screens_max : int
        Thin screens that stand in the room at any angle.
    screen_min_m, screen_max_m : float
        Their length.
    screen_materials : str
        Their materials by share.
    """

    name: ClassVar[str] = "slanted"
    about: ClassVar[str] = "A room of slanting walls and smooth screens"

    wall_materials: str = SMOOTH_MOST
    side_min_m: float = 3.5
    side_max_m: float = 7.5
    cut_share: float = 0.6
    screens_min: int = 1
    screens_max: int = 4
    screen_min_m: float = 0.7
    screen_max_m: float = 2.2
    screen_materials: str = "glass:3,metal:2,whiteboard:2,smooth-cardboard:2,wood:1"
    pillars_per_m2: float = 0.02

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls and the screens."""
        dice = site.dice
        width_m, depth_m = (dice.uniform(self.side_min_m, self.side_max_m) for _ in range(2))
        points: list[tuple[float, float]] = []
        for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            corner = (x * width_m / 2, y * depth_m / 2)
            if not dice.chance(self.cut_share):
                points.append(corner)
                continue
            along_x = (corner[0] - x * dice.uniform(0.15, 0.42) * width_m, corner[1])
            along_y = (corner[0], corner[1] - y * dice.uniform(0.15, 0.42) * depth_m)
            points += [along_y, along_x] if x * y > 0 else [along_x, along_y]
        if not shapely.Polygon(points).exterior.is_ccw:  # pragma: no cover - drawn that way
            points.reverse()
        turn = dice.uniform(0, math.pi / 2)
        cos, sin = math.cos(turn), math.sin(turn)
        self.enclose(
            site, shapely.Polygon([(cos * x - sin * y, sin * x + cos * y) for x, y in points])
        )
        x_min, y_min, x_max, y_max = site.floor.bounds
        for _ in range(dice.whole(self.screens_min, self.screens_max)):
            length_m = dice.uniform(self.screen_min_m, self.screen_max_m)
            size_m = (length_m, dice.uniform(0.012, 0.04))
            screen = Part("screen", size_m, self.material(site, "screen_materials"), 1.9)
            for _ in range(20):
                at = dice.uniform(x_min, x_max), dice.uniform(y_min, y_max)
                if site.put(
                    [screen],
                    at=at,
                    heading_deg=dice.uniform(0, 180),
                    apart_m=2 * site.clear_m + 0.2,
                ):
                    break
        return [site.floor]
