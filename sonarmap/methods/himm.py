"""Histogramic in-motion mapping: counts on the acoustic axis, with and without growth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative, positive
from sonarmap.methods.cones import Beams, Cells, NoEcho
from sonarmap.methods.onepass import Layers, OnePass, Scene, Votes
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["Himm"]

# Beams whose cells are listed at a time.
_PART_BEAMS = 5_000


@dataclass(frozen=True, kw_only=True)
class Himm(OnePass):
    """HIMM: the cell of the reading counts up, the cells before it on the axis count down.

    Parameters
    ----------
    up, down : float
        What a hit adds, > 0, and a pass takes away, >= 0.
    top : float
        Counts stay within [0, top].
    growth : float
        Share of each of the eight neighbours' counts that a hit adds as well, >= 0: 0 is HIMM
        without growth, 0.5 with the published growth rate operator.
    no_echo
        "clear" by default: a reading of the maximum range counts its axis down.
    max_range_m, scale, offset
        See `EvidenceMethod`.

    Notes
    -----
    ::

        before the reading, on the axis:  G = max(G - down, 0)
        at the reading:                   G = min(G + up, top), with growth
                                          G = min(G + up + growth * sum of the 8 neighbours, top)

    The axis begins at the sonar (the papers' robot is a point). Each cell that it passes through
    counts once. Growth adds fractions, which are kept; the papers' grid has bytes.

    Support is 2 G / top - 1 where a beam has passed, so that P(occupied) is G / top: a count of 0
    says free. Cells that no beam has passed through are unknown, though their count is 0 as well.
    """

    name: ClassVar[str] = "himm"
    source: ClassVar[str] = (
        "Borenstein and Koren, Histogramic In-Motion Mapping for Mobile Robot Obstacle Avoidance, "
        "IEEE Transactions on Robotics and Automation 7(4), 1991, after Murphy, Introduction to AI "
        "Robotics, 2000, chapter 11."
    )

    up: float = 3.0
    down: float = 1.0
    top: float = 15.0
    growth: float = 0.0
    no_echo: NoEcho = "clear"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("up", self.up)
        non_negative("down", self.down)
        positive("top", self.top)
        non_negative("growth", self.growth)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched; the counts are in units of one pass."""
        return {"up": Real(0.5, 10.0), "top": Real(5.0, 40.0), "growth": Real(0.0, 1.0)}

    def layers(self, scene: Scene) -> Layers:
        """Return counts of 0, and no cell seen."""
        return {"count": np.zeros(scene.grid.shape), "seen": np.zeros(scene.size, bool)}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the readings themselves."""
        return beams.range_m

    def listed(
        self, scene: Scene, beams: Beams, votes: Votes | None
    ) -> Iterator[tuple[Beams, Cells]]:
        """Return the beams with the cells on their axes."""
        from sonarmap.kernels.lines import list_lines  # numba: loaded when mapping

        grid = scene.grid
        where = (*grid.shape, *grid.origin_xy_m, grid.resolution_m)
        for begin in range(0, len(beams), _PART_BEAMS):
            part = beams.select(slice(begin, begin + _PART_BEAMS))
            first, cell, range_m = list_lines(*where, part.sensor_xy_m, _ends(part))
            cells = Cells(first, cell, range_m, np.zeros(cell.size))
            yield part, cells if votes is None else votes.admit(part, cells)

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Count the axes down and the readings up."""
        from sonarmap.kernels.layers import add_himm  # numba: loaded when mapping

        row, col = scene.grid.cell_of(*_ends(beams).T)
        hit = beams.echo & scene.grid.contains(row, col)
        target = np.where(hit, row * scene.grid.cols + col, -1)
        add_himm(
            layers["count"],
            layers["seen"],
            cells.first,
            cells.cell,
            target,
            self.up,
            self.down,
            self.top,
            self.growth,
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map of the counts."""
        seen = layers["seen"]
        support = np.where(seen, 2 * layers["count"].ravel() / self.top - 1, 0.0)
        return self.from_support(scene.grid, support, seen)


def _ends(beams: Beams) -> NDArray[np.float64]:
    """Return the points of the readings on their axes, metres, shape (n, 2)."""
    along = np.column_stack([np.cos(beams.axis_rad), np.sin(beams.axis_rad)])
    ends: NDArray[np.float64] = beams.sensor_xy_m + beams.range_m[:, None] * along
    return ends
