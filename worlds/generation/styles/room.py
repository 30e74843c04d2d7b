"""A single room of four walls, with bays and piers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely

from worlds.generation.base import Style
from worlds.generation.site import Site

__all__ = ["Room"]


@dataclass(frozen=True, kw_only=True)
class Room(Style):
    """A room of four walls.

    Parameters
    ----------
    side_min_m, side_max_m : float
        Of either side.
    bays_max : int
        At most so many bays in the walls and piers before them.
    """

    name: ClassVar[str] = "room"
    about: ClassVar[str] = "A room of four walls, with bays and piers"

    side_min_m: float = 2.6
    side_max_m: float = 8.0
    bays_max: int = 3

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls."""
        dice = site.dice
        width_m, depth_m = (dice.uniform(self.side_min_m, self.side_max_m) for _ in range(2))
        whole = floor = shapely.box(0, 0, width_m, depth_m)
        for _ in range(dice.whole(0, self.bays_max)):
            changed = self._with_bay(site, floor, width_m, depth_m)
            # Two that meet may leave a slot or a bridge: the room stays without the second.
            if isinstance(changed, shapely.Polygon) and not changed.interiors:
                floor = changed
        self.enclose(site, floor)
        return [shapely.intersection(site.floor, whole)]

    @staticmethod
    def _with_bay(
        site: Site, floor: shapely.Polygon, width_m: float, depth_m: float
    ) -> shapely.Geometry:
        """Return the floor with a bay (outwards) or without the place of a pier (inwards)."""
        dice = site.dice
        long_m, deep_m = dice.uniform(0.4, 1.4), dice.uniform(0.15, 0.6)
        across = dice.chance(0.5)
        side_m, other_m = (width_m, depth_m) if across else (depth_m, width_m)
        if side_m < long_m + 1.0:
            return floor
        begin_m = dice.uniform(0.4, side_m - long_m - 0.4)
        outwards = dice.chance(0.5)
        low_m, high_m = (-deep_m, 0.0) if outwards else (0.0, min(deep_m, 0.4))
        if dice.chance(0.5):
            low_m, high_m = other_m - high_m, other_m - low_m
        ends = (begin_m, low_m, begin_m + long_m, high_m)
        bay = shapely.box(*(ends if across else (ends[1], ends[0], ends[3], ends[2])))
        changed = floor.union(bay) if outwards else floor.difference(bay)
        return shapely.set_precision(changed, 0.001)
