"""`Style`: what the styles of rooms share; each adds its shell and its parameters."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from sonarmap.errors import InputError, positive, whole, within
from worlds.generation.shares import material_shares
from worlds.generation.site import Site
from worlds.generation.things import BESIDE, FREE, PILLAR, Thing

__all__ = ["DRYWALL_MOST", "SMOOTH_MOST", "Style"]

# Shares of materials of real walls are not known: most are drywall, some of each other kind.
DRYWALL_MOST = "drywall:10,plaster:4,brick:2,wood:1,glass:1,smooth-cardboard:1"
SMOOTH_MOST = "drywall:6,glass:3,metal:2,whiteboard:1,smooth-cardboard:2,plaster:2"

# No side of a generated room is longer, and no more things are in one: it stays quick.
_LONGEST_M, _MOST_THINGS = 60.0, 300
_TRIES = 12


@dataclass(frozen=True, kw_only=True)
class Style:
    """A style of rooms: its parameters, each within its rule, and how a room of it is put up.

    A subclass gives `name`, `about` and `shell`. Numbers named ``..._m`` are metres > 0,
    ``..._share`` shares within [0, 1], whole numbers counts; of ``X_min`` and ``X_max`` a room has
    something between.

    Parameters
    ----------
    wall_materials : str
        Materials of the walls by their shares, ``"drywall:5,glass:1"``.
    wall_thickness_m, height_m : float
        Of the outer walls.
    pillars_per_m2 : float
        Pillars and the like that leave a way on all sides, to each square metre of floor.
    beside_per_m2 : float
        Furniture along the walls.
    clutter_per_m2 : float
        Chairs, tables, cartons and so on, anywhere but on the route.
    stops_min, stops_max : int
        Places that the route visits in each room.
    margin_m : float
        How much more than its radius the robot keeps from everything on its route.
    """

    name: ClassVar[str]
    about: ClassVar[str]

    wall_materials: str = DRYWALL_MOST
    wall_thickness_m: float = 0.1
    height_m: float = 2.5
    pillars_per_m2: float = 0.04
    beside_per_m2: float = 0.15
    clutter_per_m2: float = 0.12
    stops_min: int = 2
    stops_max: int = 4
    margin_m: float = 0.15

    def __post_init__(self) -> None:
        values = {each.name: getattr(self, each.name) for each in dataclasses.fields(self)}
        for name, value in values.items():
            _check(name, value)
        for name, low in values.items():
            high = values.get(re.sub(r"_min(?=_|$)", "_max", name), low)
            if not isinstance(low, str) and low > high:
                other = re.sub(r"_min(?=_|$)", "_max", name)
                raise InputError(f"{name} must be <= {other}, got {low!r} and {high!r}")

    def shell(self, site: Site) -> Sequence[shapely.Polygon]:
        """Put up the walls; return the areas that the route must visit."""
        raise NotImplementedError

    def build(self, site: Site) -> str:
        """Build a room on an empty site and return its title.

        Raises
        ------
        NoRoomError
            If this draw has no room for all that must be there.
        """
        areas = self.shell(site)
        shapely.prepare(site.floor)
        floor_m2 = site.floor.area
        self._scatter(
            site, {PILLAR: 1.0}, self.pillars_per_m2 * floor_m2, apart_m=2 * site.clear_m + 0.2
        )
        site.drive(areas, stops_min=self.stops_min, stops_max=self.stops_max)
        self._along_walls(site, self.beside_per_m2 * floor_m2)
        self._scatter(site, FREE, self.clutter_per_m2 * floor_m2, apart_m=0.03)
        return self.about

    def material(self, site: Site, field: str = "wall_materials") -> str:
        """Return a material, drawn by the shares of a parameter."""
        return site.dice.weighted(material_shares(field, getattr(self, field)))

    def enclose(self, site: Site, floor: shapely.Polygon) -> None:
        """Put the outer wall about a floor."""
        site.enclosed(
            floor,
            material=self.material(site),
            thickness_m=self.wall_thickness_m,
            height_m=self.height_m,
        )

    @staticmethod
    def wide_enough(site: Site, name: str, width_m: float) -> None:
        """Raise `InputError` if the robot would not come through where the room is so wide."""
        least_m = 2 * (site.clear_m * 1.02 + 0.003) + 0.05
        if width_m < least_m:
            raise InputError(
                f"{name} must be >= {least_m:.3f} for a robot of {site.radius_m:g} m radius "
                f"that keeps {site.margin_m:g} m off, got {width_m:g}"
            )

    def _along_walls(self, site: Site, wanted: float) -> None:
        dice = site.dice
        rooms = [orient(area) for area in site.rooms or [site.floor]]
        for _ in range(_count(site, wanted)):
            parts = dice.weighted(BESIDE)(dice)
            length_m, width_m = parts[0].size_m
            for _ in range(_TRIES):
                ring = np.array(dice.one_of(rooms).exterior.coords)
                i = dice.whole(0, len(ring) - 2)
                (x, y), (to_x, to_y) = ring[i].tolist(), ring[i + 1].tolist()
                side_m = math.hypot(to_x - x, to_y - y)
                if side_m < length_m:
                    continue
                along_m = dice.uniform(length_m / 2, side_m - length_m / 2)
                off_m = width_m / 2 + dice.uniform(0.005, 0.03)
                cos, sin = (to_x - x) / side_m, (to_y - y) / side_m
                at = (x + cos * along_m - sin * off_m, y + sin * along_m + cos * off_m)
                heading_deg = math.degrees(math.atan2(sin, cos))
                if site.put(parts, at=at, heading_deg=heading_deg, apart_m=0.002):
                    break

    def _scatter(
        self, site: Site, things: Mapping[Thing, float], wanted: float, *, apart_m: float
    ) -> None:
        dice, (x_min, y_min, x_max, y_max) = site.dice, site.floor.bounds
        for _ in range(_count(site, wanted)):
            parts = dice.weighted(things)(dice)
            for _ in range(_TRIES):
                at = dice.uniform(x_min, x_max), dice.uniform(y_min, y_max)
                # Half of what stands about stands square to the axes.
                heading_deg = 90.0 * dice.whole(0, 3) if dice.chance(0.5) else dice.uniform(0, 360)
                if site.put(parts, at=at, heading_deg=heading_deg, apart_m=apart_m):
                    break


def _count(site: Site, wanted: float) -> int:
    """Return a whole number whose mean is the wanted one."""
    return min(int(wanted + site.dice.uniform(0, 1)), _MOST_THINGS)


def _check(name: str, value: object) -> None:
    if name.endswith("_materials"):
        if not isinstance(value, str):
            raise InputError(f"{name} must be a text, got {value!r}")
        material_shares(name, value)
    elif name.endswith("_per_m2"):
        within(name, value, 0, 5)  # type: ignore[arg-type]
    elif name.endswith("_share"):
        within(name, value, 0, 1)  # type: ignore[arg-type]
    elif name.endswith("_deg"):
        within(name, value, 0, 180)  # type: ignore[arg-type]
    elif name.endswith("_m"):
        if positive(name, value) > _LONGEST_M:  # type: ignore[arg-type]
            raise InputError(f"{name} must be <= {_LONGEST_M:g}, got {value!r}")
    elif whole(name, value, least=0) > 100:  # type: ignore[arg-type]
        raise InputError(f"{name} must be <= 100, got {value!r}")
