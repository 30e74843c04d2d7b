"""Rooms of right angles with convex corners: L, T, U and Z."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import shapely

from worlds.generation.base import Style
from worlds.generation.site import NoRoomError, Site

__all__ = ["LShape"]

# Which quarters of a square of 3 x 3 fields are floor, row by row.
_LETTERS: Mapping[str, tuple[str, ...]] = {
    "L": ("x..", "x..", "xxx"),
    "T": ("xxx", ".x.", ".x."),
    "U": ("x.x", "x.x", "xxx"),
    "Z": ("xx.", ".x.", ".xx"),
    "plus": (".x.", "xxx", ".x."),
}


@dataclass(frozen=True, kw_only=True)
class LShape(Style):
    """A room like the letter L, T, U or Z, or a plus, in any of its turns.

    Parameters
    ----------
    arm_min_m, arm_max_m : float
        Width of an arm, and how far it reaches out.
    """

    name: ClassVar[str] = "l-shape"
    about: ClassVar[str] = "A room of right angles with convex corners"

    arm_min_m: float = 1.4
    arm_max_m: float = 3.0
    stops_min: int = 1
    stops_max: int = 2

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls; every field of the letter must be visited."""
        dice = site.dice
        fields = _LETTERS[dice.weighted({"L": 3.0, "T": 1.0, "U": 1.0, "Z": 1.0, "plus": 0.5})]
        for _ in range(dice.whole(0, 3)):
            fields = tuple("".join(row) for row in zip(*fields[::-1], strict=True))
        if dice.chance(0.5):
            fields = fields[::-1]
        x, y = (self._lines(site) for _ in range(2))
        boxes = [
            shapely.box(x[col], y[row], x[col + 1], y[row + 1])
            for row, line in enumerate(fields)
            for col, mark in enumerate(line)
            if mark == "x"
        ]
        floor = shapely.union_all(boxes, grid_size=0.001)
        if not isinstance(floor, shapely.Polygon):
            raise NoRoomError("the letter falls apart")
        self.enclose(site, floor)
        return boxes

    def _lines(self, site: Site) -> list[float]:
        at = [0.0]
        for _ in range(3):
            at.append(round(at[-1] + site.dice.uniform(self.arm_min_m, self.arm_max_m), 3))
        return at
