"""Rooms of four to nine walls at any angle, with convex and hollow corners."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from sonarmap.errors import InputError
from worlds.generation.base import Style
from worlds.generation.site import NoRoomError, Site

__all__ = ["PolygonRoom"]

# No corner is sharper, no wall shorter: a robot sees nothing of narrower ones.
_SHARPEST_DEG, _SHORTEST_M = 50.0, 0.5


@dataclass(frozen=True, kw_only=True)
class PolygonRoom(Style):
    """A room of walls at any angle.

    Parameters
    ----------
    corners_min, corners_max : int
        How many corners it has.
    radius_min_m, radius_max_m : float
        How far the corners are from the middle.
    hollow_share : float
        Share of rooms whose corners may point inwards.
    """

    name: ClassVar[str] = "polygon"
    about: ClassVar[str] = "A room of walls at any angle"

    corners_min: int = 4
    corners_max: int = 9
    radius_min_m: float = 1.6
    radius_max_m: float = 4.2
    hollow_share: float = 0.6

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.corners_min < 3:
            raise InputError(f"corners_min must be >= 3, got {self.corners_min}")

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls."""
        hollow = site.dice.chance(self.hollow_share)
        for _ in range(40):
            points = self._points(site)
            floor = shapely.Polygon(points) if hollow else shapely.MultiPoint(points).convex_hull
            if floor.is_valid and _is_roomy(floor):
                self.enclose(site, floor)
                return [site.floor]
        raise NoRoomError("no such polygon")

    def _points(self, site: Site) -> list[tuple[float, float]]:
        dice = site.dice
        count = dice.whole(self.corners_min, self.corners_max)
        turn = dice.uniform(0, math.tau)
        radius_m = dice.uniform(self.radius_min_m, self.radius_max_m)
        points = []
        for i in range(count):
            angle = turn + (i + dice.uniform(-0.35, 0.35)) * math.tau / count
            away = max(dice.uniform(0.55, 1.1) * radius_m, self.radius_min_m * 0.8)
            points.append((round(away * math.cos(angle), 3), round(away * math.sin(angle), 3)))
        return points


def _is_roomy(floor: shapely.Polygon) -> bool:
    points = np.array(orient(floor).exterior.coords[:-1])
    ahead = np.roll(points, -1, 0) - points
    if np.hypot(*ahead.T).min() < _SHORTEST_M:
        return False
    back = -np.roll(ahead, 1, 0)
    angle = np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(ahead[:, 1], ahead[:, 0])
    inside_deg = np.degrees(angle) % 360
    return bool((inside_deg > _SHARPEST_DEG).all() and (inside_deg < 360 - _SHARPEST_DEG).all())
