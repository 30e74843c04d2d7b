"""Frames of an environment: the room, the robot and its sonar cones, beside the map they make."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from sim.envs.pictures.layout import BELIEVED_COLOUR, LEGEND, Layout, font, layout
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import Cause, GridSpec, InputError, SonarRing
from sonarmap.errors import first_row
from worlds import Pose, World
from worlds.colours import CAUSE_COLOURS, PATH_COLOUR, WALL_COLOUR

__all__ = ["ROBOT_COLOURS", "Scene", "draw", "frame_size"]

ROBOT_COLOURS = ("#14205C", "#FFF200")
"""The robot's body and the mark of its heading; nothing else in a frame has these colours."""
_PAPER, _TEXT, _BORDER, _GOAL = "#FFFFFF", "#222222", "#BBBBBB", "#000000"

# Panels are drawn this many times larger and reduced: smooth edges at little cost.
_FINE = 2
_ARC_POINTS = 17
# Widths of lines in fine pixels.
_TRAIL_WIDTH, _RIM_WIDTH, _OUTLINE_WIDTH = 3, 4, 3
_GOAL_RADIUS_M = 0.15
# A robot in a wide room stays visible.
_ROBOT_MIN_PX = 5
# Opacity of a cone that ends at an echo, and of one that met nothing, inside and at its border.
_ECHO_ALPHA, _SILENT_ALPHA, _SILENT_BORDER_ALPHA = 90, 28, 80
# What no cell of the map covers is neither free nor occupied.
_UNKNOWN_GREY = 128


@dataclass(frozen=True, eq=False)
class Scene:
    """What a frame shows. All of it is given; drawing changes nothing.

    Parameters
    ----------
    world : World
        The room.
    pose, believed : Pose
        Where the robot is, and where it is by odometry.
    ring : SonarRing
        Its sonars.
    range_m : ndarray, shape (sonars,)
        Newest reading of each sonar, metres; +inf no echo, -inf too close.
    cause : ndarray of int, shape (sonars,)
        A `sonarmap.Cause` each.
    trail_xy_m : ndarray, shape (k, 2)
        True places of the robot so far, metres; may be empty.
    goal_xy_m : tuple of float, optional
        Where the robot is to go, metres.
    probability : ndarray, shape (rows, cols), optional
        P(occupied) of the map.
    grid : GridSpec, optional
        Grid of the map in the frame of odometry; given if and only if `probability` is.
    caption : str
        One line, such as ``step 120 · reward 3.2``.
    aspect : float, optional
        Width of a panel in heights, see `sim.envs.pictures.layout.layout`.

    Raises
    ------
    InputError
        If an array has the wrong shape, a range is NaN, a cause is unknown, or the caption has
        several lines, or only one of `probability` and `grid` is given.
    """

    world: World
    pose: Pose
    believed: Pose
    ring: SonarRing
    range_m: NDArray[np.float64]
    cause: NDArray[np.int8]
    trail_xy_m: NDArray[np.float64]
    goal_xy_m: tuple[float, float] | None = None
    probability: NDArray[np.float64] | None = None
    grid: GridSpec | None = None
    caption: str = ""
    aspect: float | None = None

    def __post_init__(self) -> None:
        for name in ("range_m", "cause"):
            if (shape := getattr(self, name).shape) != (len(self.ring),):
                raise InputError(f"{name} must have shape ({len(self.ring)},), got {shape}")
        first_row("range_m", np.isnan(self.range_m), self.range_m, "metres or infinite")
        first_row("cause", ~np.isin(self.cause, list(Cause)), self.cause, "a sonarmap.Cause")
        shape = self.trail_xy_m.shape
        if len(shape) != 2 or shape[1] != 2:
            raise InputError(f"trail_xy_m must have shape (k, 2), got {shape}")
        if "\n" in self.caption:
            raise InputError(f"caption must be one line, got {self.caption!r}")
        if (self.probability is None) != (self.grid is None):
            raise InputError("probability and grid must be given together, got one of them")
        if self.grid is None or self.probability is None:
            return
        if (shape := self.probability.shape) != self.grid.shape:
            raise InputError(
                f"probability must have the shape of its grid, {self.grid.shape}, got {shape}"
            )


def frame_size(world: World, *, with_map: bool, height_px: int = 480) -> tuple[int, int]:
    """Return (height, width) of the frames of a room in pixels, as `layout` sets it."""
    width, height = layout(world, with_map=with_map, height_px=height_px).size_px
    return height, width


def draw(scene: Scene, *, height_px: int = 480) -> NDArray[np.uint8]:
    """Return a frame: the true room on the left; the map, if there is one, on the right.

    Parameters
    ----------
    scene : Scene
        What to show.
    height_px : int
        Height of the frame in pixels, within [160, 4320].

    Returns
    -------
    ndarray of uint8, shape (height_px, width, 3)
        Red, green and blue. The width, an even number, depends on the room's bounds or the
        scene's aspect and on whether there is a map, on nothing else; see `layout`.

    Notes
    -----
    Each cone reaches from its transducer to the reading, in the colour of its cause; one without
    an echo reaches to the ring's maximum range and is much fainter. The robot is a disc of the
    radius that collides, in `ROBOT_COLOURS`. Where odometry believes the robot to be is an
    outline, in the room and on the map. In the map black is occupied and white is free.
    """
    plan = layout(
        scene.world,
        with_map=scene.grid is not None,
        height_px=height_px,
        aspect=scene.aspect,
    )
    background, room = _still(scene.world, plan)
    frame = background.copy()
    frame.paste(_room_panel(scene, plan, room.copy()), plan.room_px)
    if plan.map_px is not None:
        frame.paste(_map_panel(scene, plan), plan.map_px)
    _write_caption(frame, scene.caption, plan)
    return np.array(frame)


# A room of ordinary shape takes about 7 MB at 480 pixels.
@lru_cache(maxsize=8)
def _still(world: World, plan: Layout) -> tuple[Image.Image, Image.Image]:
    """Return what stays the same in all frames: the empty frame, and the room, still fine."""
    frame = Image.new("RGB", plan.size_px, _PAPER)
    brush = ImageDraw.Draw(frame)
    letters, side = font(plan.font_px), plan.font_px
    for (name, colour), (x, y) in zip(LEGEND, plan.legend_px, strict=False):
        box = (x, y + side // 4, x + side - side // 3, y + side - side // 12)
        if colour == BELIEVED_COLOUR:
            brush.ellipse(box, outline=colour, width=max(1, side // 8))
        else:
            brush.rectangle(box, fill=colour)
        brush.text((x + side, y), name, fill=_TEXT, font=letters)
    for corner in (plan.room_px, plan.map_px):
        if corner is not None:
            _border(brush, corner, plan.panel_px)

    room = Image.new("RGB", _fine(plan.panel_px), _PAPER)
    brush = ImageDraw.Draw(room)
    for solid in world.solids:
        brush.polygon(_points(plan, solid.outline.exterior.coords), fill=WALL_COLOUR)
        for hole in solid.outline.interiors:
            brush.polygon(_points(plan, hole.coords), fill=_PAPER)
    return frame, room


def _border(
    brush: ImageDraw.ImageDraw, corner_px: tuple[int, int], panel_px: tuple[int, int]
) -> None:
    (left, top), (wide, tall) = corner_px, panel_px
    brush.rectangle((left - 1, top - 1, left + wide, top + tall), outline=_BORDER)


def _room_panel(scene: Scene, plan: Layout, room: Image.Image) -> Image.Image:
    """Return the panel of the room; `room` is drawn upon."""
    brush = ImageDraw.Draw(room, "RGBA")
    if len(scene.trail_xy_m) > 1:
        brush.line(_points(plan, scene.trail_xy_m), fill=PATH_COLOUR, width=_TRAIL_WIDTH)
    _draw_cones(brush, scene, plan)
    if scene.goal_xy_m is not None:
        _draw_goal(brush, scene.goal_xy_m, plan)
    _draw_believed(brush, scene.believed, plan)
    _draw_robot(brush, scene.pose, plan)
    return room.reduce(_FINE)


def _map_panel(scene: Scene, plan: Layout) -> Image.Image:
    grid, probability = scene.grid, scene.probability
    assert grid is not None, "a panel without a map"
    assert probability is not None, "a grid without its map"
    grey = np.round(255 * (1 - probability)).astype(np.uint8)
    # From a pixel of the panel to a cell: columns grow with x, rows upwards.
    cells_a_pixel = 1 / (plan.pixels_per_m * _FINE * grid.resolution_m)
    left, top = (np.array(plan.corner_m) - grid.origin_xy_m) / grid.resolution_m
    shown = Image.fromarray(grey).transform(
        _fine(plan.panel_px),
        Image.Transform.AFFINE,
        (cells_a_pixel, 0, left, 0, -cells_a_pixel, top),
        resample=Image.Resampling.NEAREST,
        fillcolor=_UNKNOWN_GREY,
    )
    panel = shown.convert("RGB")
    _draw_believed(ImageDraw.Draw(panel, "RGBA"), scene.believed, plan)
    return panel.reduce(_FINE)


def _draw_cones(brush: ImageDraw.ImageDraw, scene: Scene, plan: Layout) -> None:
    ring, pose = scene.ring, scene.pose
    silent = np.isposinf(scene.range_m)
    reach_m = np.clip(scene.range_m, ring.range_min_m, ring.range_max_m)
    apex = ring.sensor_xy_m(slice(None), pose.x_m, pose.y_m, pose.heading_rad)
    bearing = np.linspace(-ring.half_angle_rad, ring.half_angle_rad, _ARC_POINTS)
    angle = pose.heading_rad + ring.heading_rad[:, None] + bearing
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    arc = apex[:, None] + reach_m[:, None, None] * ray
    # The long ones first, so that none hides a shorter one.
    for sonar in np.argsort(-reach_m, kind="stable"):
        colour = CAUSE_COLOURS[Cause(scene.cause[sonar])]
        rim = _points(plan, arc[sonar])
        sector = [*_points(plan, apex[sonar : sonar + 1]), *rim]
        if silent[sonar]:
            brush.polygon(sector, fill=_faded(colour, _SILENT_ALPHA))
            brush.line([*sector, sector[0]], fill=_faded(colour, _SILENT_BORDER_ALPHA))
        else:
            brush.polygon(sector, fill=_faded(colour, _ECHO_ALPHA))
            brush.line(rim, fill=colour, width=_RIM_WIDTH)


def _draw_robot(brush: ImageDraw.ImageDraw, pose: Pose, plan: Layout) -> None:
    body, mark = ROBOT_COLOURS
    centre, radius = _disc(plan, pose)
    brush.circle(centre, radius, fill=body)
    # An arrow head within the disc.
    arrow = [
        _towards(centre, radius * share, pose.heading_rad + turn)
        for share, turn in ((0.85, 0.0), (0.7, 2.5), (0.25, math.pi), (0.7, -2.5))
    ]
    brush.polygon(arrow, fill=mark)


def _draw_believed(brush: ImageDraw.ImageDraw, pose: Pose, plan: Layout) -> None:
    centre, radius = _disc(plan, pose)
    brush.circle(centre, radius, outline=BELIEVED_COLOUR, width=_OUTLINE_WIDTH)
    nose = _towards(centre, radius, pose.heading_rad)
    brush.line([centre, nose], fill=BELIEVED_COLOUR, width=_OUTLINE_WIDTH)


def _draw_goal(brush: ImageDraw.ImageDraw, xy_m: tuple[float, float], plan: Layout) -> None:
    (centre,) = _points(plan, [xy_m])
    radius = _FINE * max(_GOAL_RADIUS_M * plan.pixels_per_m, _ROBOT_MIN_PX)
    brush.circle(centre, radius, outline=_GOAL, width=_RIM_WIDTH)
    brush.circle(centre, radius / 3, fill=_GOAL)


def _write_caption(frame: Image.Image, caption: str, plan: Layout) -> None:
    letters, left = font(plan.font_px), plan.room_px[0]
    room = plan.size_px[0] - 2 * left
    if (length := letters.getlength(caption)) > room:
        caption = caption[: int(len(caption) * room / length) - 1] + "…"
    ImageDraw.Draw(frame).text((left, plan.font_px // 6), caption, fill=_TEXT, font=letters)


def _disc(plan: Layout, pose: Pose) -> tuple[tuple[float, float], float]:
    """Return centre and radius of the robot in fine pixels."""
    (centre,) = _points(plan, [(pose.x_m, pose.y_m)])
    return centre, _FINE * max(BODY_RADIUS_M * plan.pixels_per_m, _ROBOT_MIN_PX)


def _towards(centre: tuple[float, float], length: float, heading_rad: float) -> tuple[float, float]:
    # Pixels count downwards.
    return (
        centre[0] + length * math.cos(heading_rad),
        centre[1] - length * math.sin(heading_rad),
    )


def _points(plan: Layout, xy_m: ArrayLike) -> list[tuple[float, float]]:
    """Return places as fine pixels, for Pillow: whole numbers are the middles of pixels."""
    fine = _FINE * plan.in_panel(xy_m) - 0.5
    return list(map(tuple, fine.tolist()))


def _fine(size_px: tuple[int, int]) -> tuple[int, int]:
    return size_px[0] * _FINE, size_px[1] * _FINE


def _faded(colour: str, alpha: int) -> str:
    return f"{colour}{alpha:02X}"
