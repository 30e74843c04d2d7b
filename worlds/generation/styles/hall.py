"""Halls: rows of pillars or of shelves with aisles between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely

from worlds.generation.base import Style
from worlds.generation.site import Site
from worlds.generation.things import Part

__all__ = ["Hall"]


@dataclass(frozen=True, kw_only=True)
class Hall(Style):
    """A large room with rows of pillars or shelves.

    Parameters
    ----------
    side_min_m, side_max_m : float
        Of either side.
    aisle_min_m, aisle_max_m : float
        Free width between two rows, and between a row and a wall.
    shelf_share : float
        Share of halls with shelves; the others have pillars.
    shelf_materials : str
        Materials of the shelves by share.
    """

    name: ClassVar[str] = "hall"
    about: ClassVar[str] = "A hall with rows of pillars or shelves"

    wall_materials: str = "plaster:4,brick:3,drywall:3,metal:2"
    side_min_m: float = 5.0
    side_max_m: float = 10.0
    aisle_min_m: float = 0.95
    aisle_max_m: float = 1.6
    shelf_share: float = 0.5
    shelf_materials: str = "books:2,metal:2,wood:2,cardboard:1"
    pillars_per_m2: float = 0.0
    clutter_per_m2: float = 0.06
    beside_per_m2: float = 0.06

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls and the rows."""
        dice = site.dice
        width_m, depth_m = (dice.uniform(self.side_min_m, self.side_max_m) for _ in range(2))
        self.enclose(site, shapely.box(0, 0, width_m, depth_m))
        aisle_m = dice.uniform(self.aisle_min_m, self.aisle_max_m)
        if dice.chance(self.shelf_share):
            self._shelves(site, width_m, depth_m, aisle_m)
        else:
            self._pillars(site, width_m, depth_m, aisle_m)
        x = width_m / 2
        return [shapely.box(0, 0, x, depth_m), shapely.box(x, 0, width_m, depth_m)]

    def _shelves(self, site: Site, width_m: float, depth_m: float, aisle_m: float) -> None:
        deep_m = site.dice.uniform(0.3, 0.6)
        material = self.material(site, "shelf_materials")
        y = aisle_m + deep_m / 2
        while y + deep_m / 2 + aisle_m <= depth_m:
            # Each row leaves its own ends free, and some are open in the middle.
            begin, end = (aisle_m * site.dice.uniform(1, 1.5) for _ in range(2))
            runs = [(begin, width_m - end)]
            if width_m - begin - end > 3 * aisle_m and site.dice.chance(0.5):
                middle = width_m / 2 + site.dice.uniform(-0.5, 0.5)
                runs = [(begin, middle - aisle_m / 2), (middle + aisle_m / 2, width_m - end)]
            for low, high in runs:
                if high - low > 0.4:
                    shelf = Part("shelf", (high - low, deep_m), material, 2.0)
                    site.put([shelf], at=((low + high) / 2, y), heading_deg=0, apart_m=0.3)
            y += deep_m + aisle_m

    def _pillars(self, site: Site, width_m: float, depth_m: float, aisle_m: float) -> None:
        dice = site.dice
        round_ = dice.chance(0.6)
        size = dice.uniform(0.1, 0.25)
        material = self.material(site)
        size_m = (size,) if round_ else (2 * size, 2 * size)
        across, up = (
            max(1, int((side_m - aisle_m) / (aisle_m + 2 * size))) for side_m in (width_m, depth_m)
        )
        across, up = min(across, 5), min(up, 4)
        pillar = Part("pillar", size_m, material, self.height_m)
        for i in range(across):
            for j in range(up):
                at = (width_m * (i + 1) / (across + 1), depth_m * (j + 1) / (up + 1))
                site.put([pillar], at=at, heading_deg=0, apart_m=0.3)
