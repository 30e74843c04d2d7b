"""What stands in rooms: furniture, pillars, cartons, chairs on four legs; with usual sizes.

All sizes are assumed: what such things usually measure, drawn within a range.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from worlds.generation.dice import Dice
from worlds.solids import Solid

__all__ = ["BESIDE", "FREE", "PILLAR", "Part", "Thing"]

Point = tuple[float, float]


@dataclass(frozen=True)
class Part:
    """A box or a pillar of a thing, in the thing's frame until it is placed.

    Parameters
    ----------
    thing : str
        Name of the thing.
    size_m : tuple of float
        (length, width) of a box, (radius,) of a pillar.
    material : str
        Name of its material.
    height_m : float
        Its height.
    at_m : (x, y)
        Its middle.
    heading_deg : float
        Where its length points.
    label : str
        What it is of the thing, such as "leg 1"; empty if it is all of it.
    """

    thing: str
    size_m: tuple[float, ...]
    material: str
    height_m: float
    at_m: Point = (0.0, 0.0)
    heading_deg: float = 0.0
    label: str = ""

    def placed(self, at: Point, heading_deg: float) -> Part:
        """Return the part where it comes to when its thing is put somewhere, rounded."""
        cos, sin = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
        x, y = self.at_m
        return replace(
            self,
            at_m=(_mm(at[0] + cos * x - sin * y), _mm(at[1] + sin * x + cos * y)),
            size_m=tuple(_mm(size) for size in self.size_m),
            heading_deg=round(self.heading_deg + heading_deg, 1) % 360,
            height_m=round(self.height_m, 2),
        )

    def solid(self, name: str) -> Solid:
        """Return the solid that it is."""
        shape = {"height_m": self.height_m, "material": self.material}
        if len(self.size_m) == 1:
            return Solid.pillar(name, self.at_m, self.size_m[0], **shape)  # type: ignore[arg-type]
        turned = math.radians(self.heading_deg)
        return Solid.box(name, self.at_m, self.size_m, heading_rad=turned, **shape)  # type: ignore[arg-type]

    def table(self, number: int) -> tuple[str, dict[str, Any]]:
        """Return the kind and the table of a world file that it is; `number` is its thing's."""
        name = f"{self.thing} {number}" + (f", {self.label}" if self.label else "")
        table: dict[str, Any] = {"name": name, "centre_m": list(self.at_m)}
        kind = "pillar" if len(self.size_m) == 1 else "box"
        if kind == "pillar":
            table["radius_m"] = self.size_m[0]
        else:
            table["size_m"] = list(self.size_m)
            if self.heading_deg:
                table["heading_deg"] = self.heading_deg
        return kind, table | {"height_m": self.height_m, "material": self.material}


Thing = Callable[[Dice], tuple[Part, ...]]
"""Draws a thing; one that stands beside a wall has its back along its x axis, at negative y."""


def _mm(value_m: float) -> float:
    return round(value_m, 3) + 0.0


def _box(
    thing: str,
    length_m: tuple[float, float],
    width_m: tuple[float, float],
    height_m: tuple[float, float],
    **materials: float,
) -> Thing:
    named = {name.replace("_", "-"): share for name, share in materials.items()}

    def draw(dice: Dice) -> tuple[Part, ...]:
        size = dice.uniform(*length_m), dice.uniform(*width_m)
        return (Part(thing, size, dice.weighted(named), dice.uniform(*height_m)),)

    return draw


def _post(
    thing: str, radius_m: tuple[float, float], height_m: tuple[float, float], **materials: float
) -> Thing:
    def draw(dice: Dice) -> tuple[Part, ...]:
        size = (dice.uniform(*radius_m),)
        return (Part(thing, size, dice.weighted(materials), dice.uniform(*height_m)),)

    return draw


def _on_legs(
    thing: str,
    length_m: tuple[float, float],
    width_m: tuple[float, float],
    leg_m: tuple[float, float],
    height_m: tuple[float, float],
) -> Thing:
    """Return a thing of which only its four legs stand on the floor."""

    def draw(dice: Dice) -> tuple[Part, ...]:
        half, deep = dice.uniform(*length_m) / 2, dice.uniform(*width_m) / 2
        leg, material = (dice.uniform(*leg_m),), dice.weighted({"metal": 2.0, "wood": 1.0})
        high = dice.uniform(*height_m)
        corners = ((-half, -deep), (half, -deep), (half, deep), (-half, deep))
        return tuple(
            Part(thing, leg, material, high, at_m=corner, label=f"leg {i}")
            for i, corner in enumerate(corners, 1)
        )

    return draw


PILLAR = _post("pillar", (0.08, 0.25), (2.5, 2.5), plaster=3, metal=1, wood=1, brick=1)

BESIDE: Mapping[Thing, float] = MappingProxyType(
    {
        _box("desk", (1.2, 1.8), (0.6, 0.8), (0.7, 0.75), wood=1): 3.0,
        _box("cabinet", (0.8, 1.2), (0.4, 0.5), (1.2, 2.0), metal=2, wood=1): 3.0,
        _box("bookshelf", (0.6, 1.6), (0.25, 0.35), (1.8, 2.1), books=1): 2.0,
        _box("sofa", (1.4, 2.0), (0.75, 0.9), (0.7, 0.8), carpet=1): 1.0,
        _box("drawers", (0.4, 0.5), (0.5, 0.6), (0.55, 0.7), metal=1, wood=1): 1.0,
        _box("whiteboard", (0.9, 1.8), (0.03, 0.05), (1.9, 2.0), whiteboard=1): 1.0,
        _box("curtain", (0.8, 1.8), (0.06, 0.12), (2.2, 2.4), curtain=1): 1.0,
        _box("pane", (0.8, 2.4), (0.01, 0.02), (2.0, 2.4), glass=3, metal=1, wood=1): 2.0,
        _box("radiator", (0.6, 1.6), (0.08, 0.12), (0.5, 0.6), metal=1): 1.0,
    }
)
"""What stands along a wall, with the share of each."""

FREE: Mapping[Thing, float] = MappingProxyType(
    {
        _box("carton", (0.3, 0.6), (0.25, 0.45), (0.3, 0.6), cardboard=1): 3.0,
        _box("crate", (0.5, 0.8), (0.4, 0.6), (0.4, 0.9), wood=1): 1.0,
        _box("case", (0.5, 0.9), (0.3, 0.5), (0.4, 0.8), metal=1): 1.0,
        _box(
            "screen", (0.8, 1.6), (0.03, 0.05), (1.4, 1.8), wood=1, smooth_cardboard=1, foam=1
        ): 1.0,
        _post("bin", (0.12, 0.2), (0.3, 0.6), metal=2, wood=1): 1.0,
        _post("lamp", (0.012, 0.02), (1.6, 1.8), metal=1): 0.5,
        PILLAR: 1.0,
        _on_legs("chair", (0.38, 0.46), (0.38, 0.46), (0.011, 0.02), (0.42, 0.47)): 4.0,
        _on_legs("table", (0.8, 1.6), (0.7, 0.9), (0.02, 0.035), (0.7, 0.75)): 1.5,
    }
)
"""What stands anywhere, at any angle, with the share of each."""
