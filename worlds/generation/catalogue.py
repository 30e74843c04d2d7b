"""The styles of rooms that ship, by name: a new one is a file, and one line here."""

from __future__ import annotations

from typing import Any

from sonarmap.registry import Registry

__all__ = ["STYLES"]

STYLES: Registry[Any] = Registry(
    "style",
    "sonarbed.room_styles",
    {
        "clutter": "worlds.generation.styles.clutter:Clutter",
        "corridor": "worlds.generation.styles.corridor:Corridor",
        "hall": "worlds.generation.styles.hall:Hall",
        "l-shape": "worlds.generation.styles.l_shape:LShape",
        "office": "worlds.generation.styles.office:Office",
        "open": "worlds.generation.styles.open:Open",
        "polygon": "worlds.generation.styles.polygon:PolygonRoom",
        "room": "worlds.generation.styles.room:Room",
        "round": "worlds.generation.styles.round:Round",
        "slanted": "worlds.generation.styles.slanted:Slanted",
    },
)
"""Classes of styles: frozen dataclasses of parameters, see `worlds.generation.base.Style`."""
