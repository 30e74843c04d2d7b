"""Crowded rooms: cartons, pillars, chairs and tables of which sonar sees the legs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from worlds.generation.styles.room import Room

__all__ = ["Clutter"]


@dataclass(frozen=True, kw_only=True)
class Clutter(Room):
    """A room of four walls, full of things. Its parameters are those of the style ``room``."""

    name: ClassVar[str] = "clutter"
    about: ClassVar[str] = "A crowded room: cartons, pillars and chair legs"

    side_min_m: float = 3.5
    side_max_m: float = 7.0
    bays_max: int = 1
    pillars_per_m2: float = 0.08
    beside_per_m2: float = 0.15
    clutter_per_m2: float = 0.8
