"""The colours of pictures: what a person learns from one picture holds in all of them."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from sonarmap import Cause

__all__ = ["CAUSE_COLOURS", "PATH_COLOUR", "WALL_COLOUR"]

# Okabe and Ito's palette: told apart by colour-blind people too.
CAUSE_COLOURS: Mapping[Cause, str] = MappingProxyType(
    {
        Cause.DIRECT: "#009E73",
        Cause.OFF_AXIS: "#56B4E9",
        Cause.OUT_OF_RANGE: "#999999",
        Cause.BOUNCE: "#E69F00",
        Cause.CROSSTALK: "#CC79A7",
        Cause.DROPOUT: "#D55E00",
    }
)
"""Colour of the readings of each cause, as ``#RRGGBB``."""
WALL_COLOUR = "#444444"
"""Whatever stands in a room, where its material is not shown."""
PATH_COLOUR = "#0072B2"
"""The robot and its path."""
