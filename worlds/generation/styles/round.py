"""Round rooms: circles, ellipses, rooms with an apse or two round ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely

from worlds.generation.base import Style
from worlds.generation.site import Site

__all__ = ["Round"]

# A side of the polygon that stands for a curve is about as long.
_SIDE_M = 0.15


@dataclass(frozen=True, kw_only=True)
class Round(Style):
    """A room with a round wall.

    Parameters
    ----------
    radius_min_m, radius_max_m : float
        Of the round wall, of an ellipse the longer half-axis.
    straight_share : float
        Share of rooms of which a part has straight walls: an apse, or two round ends.
    """

    name: ClassVar[str] = "round"
    about: ClassVar[str] = "A room with a round wall"

    wall_materials: str = "drywall:4,plaster:4,smooth-cardboard:3,brick:2,glass:2,metal:1,wood:1"
    radius_min_m: float = 1.4
    radius_max_m: float = 3.5
    straight_share: float = 0.5
    pillars_per_m2: float = 0.06
    beside_per_m2: float = 0.05

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the wall."""
        dice = site.dice
        radius_m = dice.uniform(self.radius_min_m, self.radius_max_m)
        if dice.chance(self.straight_share):
            length_m = dice.uniform(0.8, 3.0)
            ends = dice.whole(1, 2)
            points = _arc(radius_m, radius_m, -90, 90)
            points = [(x + length_m, y) for x, y in points]
            left = _arc(radius_m, radius_m, 90, 270)
            points += left if ends == 2 else [(0.0, radius_m), (0.0, -radius_m)]
        else:
            flat = dice.uniform(0.65, 1.0) if dice.chance(0.5) else 1.0
            other_m = max(flat * radius_m, min(radius_m, self.radius_min_m * 0.8))
            points = _arc(radius_m, other_m, 0, 360)[:-1]
        turn = dice.uniform(0, math.tau)
        cos, sin = math.cos(turn), math.sin(turn)
        self.enclose(
            site, shapely.Polygon([(cos * x - sin * y, sin * x + cos * y) for x, y in points])
        )
        return [site.floor]


def _arc(a_m: float, b_m: float, from_deg: float, to_deg: float) -> list[tuple[float, float]]:
    sides = max(16, round(math.radians(to_deg - from_deg) * max(a_m, b_m) / _SIDE_M))
    angles = [math.radians(from_deg + (to_deg - from_deg) * i / sides) for i in range(sides + 1)]
    return [(a_m * math.cos(angle), b_m * math.sin(angle)) for angle in angles]
