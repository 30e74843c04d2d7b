"""Where the parts of a frame are: known from the room's bounds, never from what happens in it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import ImageFont

from sonarmap import Cause, InputError
from sonarmap.errors import within
from worlds import World
from worlds.colours import CAUSE_COLOURS

__all__ = ["BELIEVED_COLOUR", "LEGEND", "Layout", "font", "layout", "panel_aspect"]

BELIEVED_COLOUR = "#7A4EA3"
"""Outline of the robot where odometry believes it to be."""
LEGEND = (
    *((cause.name.lower().replace("_", " "), CAUSE_COLOURS[cause]) for cause in Cause),
    ("by odometry", BELIEVED_COLOUR),
)
"""(name, colour) of what the legend explains, in its order."""

_Bounds = tuple[float, float, float, float]

_HEIGHT_PX = (160, 4320)
# Air around the room, in its longer side: a wall is not taken for the border of the panel.
_AIR = 0.015
# Width of a panel in heights: a tower leaves room for the legend, a corridor fits a screen.
_PANEL_ASPECT = (0.8, 1.8)
# Height of the letters in heights of the frame; nothing smaller than the second can be read.
_FONT_SHARE, _FONT_MIN_PX = 1 / 40, 9


@dataclass(frozen=True, slots=True)
class Layout:
    """Where the parts of a frame are; pixels (x, y) count from its upper left corner.

    Parameters
    ----------
    size_px : tuple of int
        (width, height) of the frame.
    panel_px : tuple of int
        (width, height) of each panel.
    room_px : tuple of int
        Upper left corner of the panel of the room.
    map_px : tuple of int or None
        Upper left corner of the panel of the map, if there is one.
    corner_m : tuple of float
        Place that the upper left corner of each panel shows, metres.
    pixels_per_m : float
        Scale of both panels.
    font_px : int
        Height of the letters.
    legend_px : tuple of (x, y)
        Upper left corner of each entry of `LEGEND`; empty in a frame too small for it.
    """

    size_px: tuple[int, int]
    panel_px: tuple[int, int]
    room_px: tuple[int, int]
    map_px: tuple[int, int] | None
    corner_m: tuple[float, float]
    pixels_per_m: float
    font_px: int
    legend_px: tuple[tuple[int, int], ...]

    def in_panel(self, xy_m: ArrayLike) -> NDArray[np.float64]:
        """Return where places of shape (..., 2) are in a panel, pixels from its upper left."""
        scale = self.pixels_per_m
        return (np.asarray(xy_m, float) - self.corner_m) * (scale, -scale)


def panel_aspect(rooms: Iterable[World]) -> float:
    """Return the width of a panel that suits several rooms, in heights: what the widest needs."""
    return max(_aspect(_padded(room.bounds_m)) for room in rooms)


def layout(
    world: World, *, with_map: bool, height_px: int = 480, aspect: float | None = None
) -> Layout:
    """Return where the parts of the frames of a room are.

    Parameters
    ----------
    world : World
        The room; only its bounds matter.
    with_map : bool
        Whether a map is shown beside it.
    height_px : int
        Height of the frame in pixels, within [160, 4320]. The width is even, as video encoders
        need it.
    aspect : float, optional
        Width of a panel in heights, for frames of one size for several rooms (`panel_aspect`); by
        default what this room needs. The room is in the middle.

    Raises
    ------
    InputError
        If `height_px` is out of its bounds or not whole.
    """
    if within("height_px", height_px, *_HEIGHT_PX) != int(height_px):
        raise InputError(f"height_px must be a whole number, got {height_px!r}")
    bounds_m = _padded(world.bounds_m)
    wide = _aspect(bounds_m) if aspect is None else aspect
    return _layout(bounds_m, wide, 2 if with_map else 1, int(height_px))


@lru_cache(maxsize=64)
def _layout(bounds_m: _Bounds, aspect: float, panels: int, height_px: int) -> Layout:
    font_px = max(_FONT_MIN_PX, round(height_px * _FONT_SHARE))
    line_px, gap_px = round(1.5 * font_px), font_px // 2
    # A narrow frame breaks its legend into two lines; one too small for that has none.
    for lines in (1, 2, 0):
        tall_px = height_px - (1 + lines) * line_px - 2 * gap_px
        wide_px = round(aspect * tall_px)
        width_px = panels * (wide_px + gap_px) + gap_px
        width_px += width_px % 2
        columns_px, legend_width_px = _legend_columns(font_px, lines)
        if legend_width_px <= width_px - 2 * gap_px:
            break
    scale, corner_m = _fitted(bounds_m, wide_px, tall_px)
    legend_top_px = line_px + tall_px + 2 * gap_px
    return Layout(
        size_px=(width_px, height_px),
        panel_px=(wide_px, tall_px),
        room_px=(gap_px, line_px + gap_px // 2),
        map_px=(wide_px + 2 * gap_px, line_px + gap_px // 2) if panels == 2 else None,
        corner_m=corner_m,
        pixels_per_m=scale,
        font_px=font_px,
        legend_px=tuple(
            (gap_px + left_px, legend_top_px + line * line_px) for line, left_px in columns_px
        ),
    )


def _padded(bounds_m: _Bounds) -> _Bounds:
    x_min, y_min, x_max, y_max = bounds_m
    air_m = _AIR * max(x_max - x_min, y_max - y_min)
    return x_min - air_m, y_min - air_m, x_max + air_m, y_max + air_m


def _aspect(bounds_m: _Bounds) -> float:
    x_min, y_min, x_max, y_max = bounds_m
    return float(np.clip((x_max - x_min) / (y_max - y_min), *_PANEL_ASPECT))


def _fitted(bounds_m: _Bounds, wide_px: int, tall_px: int) -> tuple[float, tuple[float, float]]:
    """Return pixels a metre and the place of the upper left corner: the room in the middle."""
    x_min, y_min, x_max, y_max = bounds_m
    scale = min(wide_px / (x_max - x_min), tall_px / (y_max - y_min))
    return scale, ((x_min + x_max - wide_px / scale) / 2, (y_min + y_max + tall_px / scale) / 2)


def _legend_columns(font_px: int, lines: int) -> tuple[list[tuple[int, int]], int]:
    """Return (line, left) of each entry, and how wide the widest line is, pixels."""
    if lines == 0:
        return [], 0
    per_line = -(-len(LEGEND) // lines)
    places: list[tuple[int, int]] = []
    ends: list[int] = []
    for entry, (name, _) in enumerate(LEGEND):
        line, column = divmod(entry, per_line)
        left_px = 0 if column == 0 else ends[-1]
        places.append((line, left_px))
        # A square of its colour, the name, and air.
        ends.append(left_px + round(font(font_px).getlength(name)) + 2 * font_px)
    return places, max(ends)


@cache
def font(size_px: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's own font: the same letters on every machine."""
    return ImageFont.load_default(size_px)
