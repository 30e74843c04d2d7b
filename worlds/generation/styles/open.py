"""Open scenes: boards, boxes and pillars without a closed wall about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely

from worlds.generation.base import Style
from worlds.generation.site import Site, mm
from worlds.generation.things import Part

__all__ = ["Open"]


@dataclass(frozen=True, kw_only=True)
class Open(Style):
    """Boards that stand in the open, where sound is lost in most directions.

    Parameters
    ----------
    side_min_m, side_max_m : float
        Of the area that counts.
    boards_min, boards_max : int
        How many boards stand there.
    board_min_m, board_max_m : float
        Their length.
    gap_share : float
        Share of boards that are two in one line with a gap between them, as the thesis's rig.
    gap_min_m, gap_max_m : float
        Width of such a gap.
    """

    name: ClassVar[str] = "open"
    about: ClassVar[str] = "An open scene of boards, without a wall about it"

    wall_materials: str = "smooth-cardboard:5,cardboard:3,wood:2,drywall:2,metal:1,glass:1"
    side_min_m: float = 5.0
    side_max_m: float = 9.0
    boards_min: int = 2
    boards_max: int = 6
    board_min_m: float = 0.8
    board_max_m: float = 3.0
    gap_share: float = 0.3
    gap_min_m: float = 0.5
    gap_max_m: float = 1.0
    beside_per_m2: float = 0.0
    pillars_per_m2: float = 0.05
    clutter_per_m2: float = 0.08
    stops_min: int = 1
    stops_max: int = 2

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the boards; each quarter of the area is visited."""
        dice = site.dice
        width_m, depth_m = (mm(dice.uniform(self.side_min_m, self.side_max_m)) for _ in range(2))
        site.bounds_m = (0.0, 0.0, width_m, depth_m)
        site.floor = shapely.box(*site.bounds_m)
        for _ in range(dice.whole(self.boards_min, self.boards_max)):
            parts = self._board(site)
            for _ in range(20):
                at = dice.uniform(0, width_m), dice.uniform(0, depth_m)
                heading_deg = 90 * dice.whole(0, 1) if dice.chance(0.4) else dice.uniform(0, 180)
                apart_m = 2 * site.clear_m + 0.2
                if site.put(parts, at=at, heading_deg=heading_deg, apart_m=apart_m):
                    break
        x, y = width_m / 2, depth_m / 2
        return [shapely.box(i * x, j * y, (i + 1) * x, (j + 1) * y) for i in (0, 1) for j in (0, 1)]

    def _board(self, site: Site) -> list[Part]:
        dice = site.dice
        length_m, thick_m = (
            dice.uniform(self.board_min_m, self.board_max_m),
            dice.uniform(0.01, 0.05),
        )
        material = self.material(site)
        if not dice.chance(self.gap_share):
            return [Part("board", (length_m, thick_m), material, 1.2)]
        half_m = max(length_m / 2, 0.4)
        away_m = (half_m + dice.uniform(self.gap_min_m, self.gap_max_m)) / 2
        return [
            Part("board", (half_m, thick_m), material, 1.2, at_m=(side * away_m, 0.0), label=label)
            for side, label in ((-1, "left"), (1, "right"))
        ]
