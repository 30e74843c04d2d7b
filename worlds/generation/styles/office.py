"""Offices: several rooms behind doors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import shapely

from worlds.generation.base import Style
from worlds.generation.site import NoRoomError, Site, mm

__all__ = ["Office"]

# A wall keeps this far from the jamb of a door in the wall that it meets.
_JAMB_M = 0.15


class _Cell(NamedTuple):
    """A room while it may still be divided, with the doors in its sides, metres."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    def sides(self) -> tuple[float, float]:
        return self.x_max - self.x_min, self.y_max - self.y_min


@dataclass(frozen=True, kw_only=True)
class Office(Style):
    """Several rooms with a door from each to the next.

    Parameters
    ----------
    side_min_m, side_max_m : float
        Of either side of the whole.
    rooms_min, rooms_max : int
        How many rooms; fewer if they do not fit.
    room_min_m : float
        No room is narrower.
    door_min_m, door_max_m : float
        Width of a door.
    partition_min_m, partition_max_m : float
        Thickness of the walls between the rooms.
    partition_materials : str
        Their materials by share.
    """

    name: ClassVar[str] = "office"
    about: ClassVar[str] = "Rooms with doors between them"

    side_min_m: float = 4.5
    side_max_m: float = 9.0
    rooms_min: int = 2
    rooms_max: int = 5
    room_min_m: float = 1.8
    door_min_m: float = 0.8
    door_max_m: float = 1.2
    partition_min_m: float = 0.02
    partition_max_m: float = 0.12
    partition_materials: str = "drywall:8,glass:2,wood:2,plaster:1"
    beside_per_m2: float = 0.3
    clutter_per_m2: float = 0.1
    stops_min: int = 1
    stops_max: int = 2

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the outer wall, then divide the largest room until there are enough."""
        self.wide_enough(site, "door_min_m", self.door_min_m)
        dice = site.dice
        wide_m, deep_m = (mm(dice.uniform(self.side_min_m, self.side_max_m)) for _ in range(2))
        self.enclose(site, shapely.box(0, 0, wide_m, deep_m))
        cells, doors = [_Cell(0.0, 0.0, wide_m, deep_m)], list[shapely.Polygon]()
        wanted = dice.whole(self.rooms_min, self.rooms_max)
        for _ in range(4 * wanted):
            if len(cells) >= wanted:
                break
            cells.sort(key=lambda cell: (-max(cell.sides()), cell))
            i = 0 if dice.chance(0.7) else dice.whole(0, len(cells) - 1)
            if halves := self._divided(site, cells[i], doors):
                cells[i : i + 1] = halves
        if len(cells) < min(wanted, 2):
            raise NoRoomError("the rooms do not fit")
        site.rooms = [shapely.box(*cell) for cell in cells]
        return site.rooms

    def _divided(
        self, site: Site, cell: _Cell, doors: list[shapely.Polygon]
    ) -> tuple[_Cell, _Cell] | None:
        """Put a wall with a door through a room; return both halves, or None if none fits."""
        dice = site.dice
        wide_m, deep_m = cell.sides()
        upright = wide_m > deep_m if abs(wide_m - deep_m) > 0.8 else dice.chance(0.5)
        low, high = (cell.x_min, cell.x_max) if upright else (cell.y_min, cell.y_max)
        begin, end = (cell.y_min, cell.y_max) if upright else (cell.x_min, cell.x_max)
        thick_m = mm(dice.uniform(self.partition_min_m, self.partition_max_m) / 2) * 2
        door_m = dice.uniform(self.door_min_m, self.door_max_m)
        off_m = self.room_min_m + thick_m / 2
        if high - low < 2 * off_m or end - begin < door_m + 0.3:
            return None
        material = self.material(site, "partition_materials")
        for _ in range(10):
            at = mm(dice.uniform(low + off_m, high - off_m))
            line = [(at, begin), (at, end)] if upright else [(begin, at), (end, at)]
            if not any(shapely.LineString(line).dwithin(door, _JAMB_M + thick_m) for door in doors):
                break
        else:
            return None
        jamb = mm(dice.uniform(begin + 0.15, end - door_m - 0.15))
        other = mm(jamb + door_m)
        for piece in ((begin, jamb), (other, end)):
            points = [(at, each) if upright else (each, at) for each in piece]
            site.wall(
                "partition",
                points,
                material=material,
                thickness_m=thick_m,
                height_m=self.height_m,
            )
        door = [(at, jamb), (at, other)] if upright else [(jamb, at), (other, at)]
        doors.append(shapely.LineString(door).buffer(0.3, cap_style="flat"))
        near, far = mm(at - thick_m / 2), mm(at + thick_m / 2)
        if upright:
            return cell._replace(x_max=near), cell._replace(x_min=far)
        return cell._replace(y_max=near), cell._replace(y_min=far)
