"""Ghosts: what is read over mirroring walls, beside the length that image sources give."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from matplotlib.figure import Figure
from numpy.typing import NDArray
from shapely.affinity import rotate

from sim import PhysicalSonar
from sonarbed.reporting.bench import echoes, scene
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.acoustics.theory import GLASS, as_deviation, as_range, physical, sharp
from worlds import Solid, World

__all__ = ["Corridor", "run"]

_LENGTH_M = 12.0
_BOARD_M = 0.7
_DRAWN = (35.0, 1)
# The sonar looks at the wall so steeply that neither wall nor board answers it straight.
_SLANTS_DEG = (30.0, 35.0, 40.0, 45.0)
_LEG_M = 1.0  # from the last mirror to the board, along the axis


@dataclass(frozen=True)
class Corridor:
    """Two walls, and a board that stands square to what they mirror on.

    Parameters
    ----------
    slant_rad : float
        Angle between the axis and the walls.
    mirrors : int
        How many walls the sound meets before the board.
    width_m : float
        From wall to wall; the sonar stands in the middle.
    """

    slant_rad: float
    mirrors: int
    width_m: float = 1.6

    @property
    def points_m(self) -> NDArray[np.float64]:
        """The way on the axis: sonar, mirrors, board; shape (mirrors + 2, 2)."""
        half_m = self.width_m / 2
        points, side = [np.zeros(2)], 1.0
        for mirror in range(self.mirrors):
            up_m = half_m if mirror == 0 else self.width_m
            points.append(
                np.array([points[-1][0] + up_m / math.tan(self.slant_rad), side * half_m])
            )
            side = -side
        along = np.array([math.cos(self.slant_rad), side * math.sin(self.slant_rad)])
        return np.array([*points, points[-1] + _LEG_M * along])

    @property
    def image_m(self) -> NDArray[np.float64]:
        """The sonar's image in the walls, one after the other."""
        y_m, side = 0.0, 1.0
        for _ in range(self.mirrors):
            y_m = side * self.width_m - y_m  # mirrored at y = side * width / 2
            side = -side
        return np.array([0.0, y_m])

    @property
    def ghost_m(self) -> float:
        """Distance of the image from the board's face: what is read."""
        points = self.points_m
        normal = (points[-2] - points[-1]) / np.linalg.norm(points[-2] - points[-1])
        return float((self.image_m - points[-1]) @ normal)

    @property
    def world(self) -> World:
        """The walls and the board, all of glass."""
        half_m = self.width_m / 2
        low, high = (
            shapely.box(-2.0, min(y, y + t), _LENGTH_M, max(y, y + t))
            for y, t in ((-half_m, -0.1), (half_m, 0.1))
        )
        before, there = self.points_m[-2:]
        angle_deg = math.degrees(math.atan2(*(there - before)[::-1]))
        outline = shapely.box(
            there[0], there[1] - _BOARD_M / 2, there[0] + 0.02, there[1] + _BOARD_M / 2
        )
        board = rotate(outline, angle_deg, origin=tuple(there))
        outlines = (("low", low), ("high", high), ("board", board))
        return scene(*(Solid(name, GLASS, 1.0, outline) for name, outline in outlines))

    def reading(self, sonar: PhysicalSonar) -> tuple[float, int]:
        """Return (range, mirrors) of what the sonar reads."""
        heard = echoes(
            sonar, self.world, np.zeros((1, 2)), self.slant_rad, np.random.default_rng(0)
        )
        return float(heard.range_m[0]), int(heard.bounces[0])


def run(context: StudyContext) -> Section:
    """Let a sonar look at a mirroring wall in a corridor."""
    return Section("ghost", "Ghosts over mirrors", (_ghosts(context),))


def _ghosts(context: StudyContext) -> Item:
    sonar = physical(context.sonar)
    rows, off_m = [], []
    for mirrors in (1, 2):
        for slant_deg in _SLANTS_DEG:
            corridor = Corridor(math.radians(slant_deg), mirrors)
            follows = sonar.replace(max_bounces=max(mirrors, sonar.max_bounces))
            exact_m, met = corridor.reading(sharp(follows))
            read_m, _ = corridor.reading(follows)
            if met == mirrors:
                off_m.append(abs(exact_m - corridor.ghost_m))
            axis_m = float(np.linalg.norm(corridor.points_m[1]))
            rows.append(
                (
                    mirrors,
                    f"{slant_deg:g}",
                    f"{axis_m:.3f}",
                    f"{corridor.ghost_m:.4f}",
                    as_range(exact_m, 4),
                    as_range(read_m),
                    met if math.isfinite(exact_m) else "-",
                )
            )
    slant_deg, mirrors = _DRAWN
    drawn = Corridor(math.radians(slant_deg), mirrors)
    read_m, _ = drawn.reading(sonar)
    return Item(
        "A two-bounce ghost in a corridor",
        "A wall that mirrors the beam to something square to it sends the sound there and back "
        "over both: the sonar reads how far its mirror image is from what the sound met last.",
        f"In the picture the wall stands {float(np.linalg.norm(drawn.points_m[1])):.3f} m away on "
        f"the axis, the image {drawn.ghost_m:.3f} m from the board, and the sonar reads "
        f"{read_m:.3f} m. In {len(off_m)} corridors with one and two mirrors the largest "
        f"difference from the image source is {as_deviation(max(off_m, default=math.nan))} without "
        f"pulse length and noise; where the image is farther than {sonar.ring.range_max_m:g} m "
        "there is no echo.",
        (
            context.figure(
                "ghost", _picture(drawn, read_m), "The way of the sound and what is read"
            ),
        ),
        (
            context.table(
                "ghosts",
                (
                    "mirrors",
                    "slant, degrees",
                    "wall on the axis, m",
                    "image source, m",
                    "simulated, m",
                    "as read, m",
                    "mirrors met",
                ),
                rows,
                "Ghosts; 'as read' with pulse length, noise and whole millimetres",
            ),
        ),
    )


def _picture(corridor: Corridor, read_m: float) -> Figure:
    figure, (axes,) = figure_with(width=9.5, height=5.2)
    for solid in corridor.world.solids:
        axes.fill(*np.array(solid.outline.exterior.coords).T, color="#A8A8A8", lw=0)
    points, image = corridor.points_m, corridor.image_m
    axis = np.array([math.cos(corridor.slant_rad), math.sin(corridor.slant_rad)])
    axes.plot(*points.T, color=COLOURS[0], lw=2, label="way of the sound, there and back")
    axes.plot(*np.array([points[1], read_m * axis]).T, color=COLOURS[1], lw=1.2, ls=":",
              label="what the robot takes it for")  # fmt: skip
    axes.plot(*np.array([image, points[1]]).T, color=COLOURS[2], lw=1.2, ls="--",
              label="the same way from the mirror image")  # fmt: skip
    axes.plot(0, 0, "^", color="black", ms=9)
    axes.plot(*image, "^", color=COLOURS[2], ms=9, mfc="none")
    axes.plot(*(read_m * axis), "X", color=COLOURS[1], ms=10)
    axes.annotate("sonar", (0, 0), (0, -14), textcoords="offset points", ha="center", va="top")
    axes.annotate("mirror image", _place(image), (10, 0), textcoords="offset points", va="center")
    axes.annotate(f"ghost, {read_m:.3f} m", _place(read_m * axis), (10, 0),
                  textcoords="offset points", va="center")  # fmt: skip
    axes.annotate("board", _place(points[-1]), (14, 0), textcoords="offset points", va="center")
    axes.set_aspect("equal")
    axes.set(xlim=(-0.6, 3.6), ylim=(-1.05, 1.95), xlabel="x, m", ylabel="y, m")
    figure.legend(loc="outside lower center", ncols=3)
    return figure


def _place(xy_m: NDArray[np.float64]) -> tuple[float, float]:
    return float(xy_m[0]), float(xy_m[1])
