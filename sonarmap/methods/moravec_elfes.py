"""The first sonar map: empty and occupied areas, cancelled, normalised, enhanced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.errors import positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.cones import beams_of
from sonarmap.methods.onepass import ConeMethod, Votes
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["MoravecElfes"]

# A beam's evidence below this in sum is not blown up to 1: the arc is known to be empty.
_LEAST_SUM = 1e-3


@dataclass(frozen=True, kw_only=True)
class MoravecElfes(ConeMethod):
    """Moravec and Elfes's map of 1985.

    Parameters
    ----------
    error_m : float
        epsilon, the largest error of a range, half of the thickness of an arc, metres, > 0.
    no_echo, max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    With r and a a cell's range and share of the half-angle, R the reading and R_min the ring's
    nearest range::

        R_min <= r <= R - epsilon:  pE = (1 - ((r - R_min) / (R - epsilon - R_min))^2) (1 - a^2)
        |r - R| <= epsilon:         pO = (1 - ((r - R) / epsilon)^2) (1 - a^2)

        for every reading:  Emp = Emp + pE - Emp pE
        for every reading:  pO' = pO (1 - Emp)                     cancel
                            pO'' = pO' / sum of the beam's pO'     normalise
                            Occ = Occ + pO'' - Occ pO''            enhance

        support = Occ where Occ >= Emp, else -Emp

    What cancels is the emptiness that *all* readings have gathered (a reading's own is 0 on its
    arc), so that all empty areas are superposed before the first occupied one, and the order of
    the readings does not matter. The sum is over the cells of the grid; one below 1e-3 is not
    normalised. Readings that are too long or too short are dropped, as in the paper. Ours is the
    default of epsilon.
    """

    name: ClassVar[str] = "moravec-elfes"
    source: ClassVar[str] = (
        "Moravec and Elfes, High Resolution Maps from Wide Angle Sonar, IEEE International "
        "Conference on Robotics and Automation, 1985."
    )

    error_m: float = 0.05

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("error_m", self.error_m)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {"error_m": Real(0.025, 0.2), "half_angle_rad": Real(0.05, 0.7)}

    def fuse(self, log: SonarLog, grid: GridSpec, votes: Votes | None = None) -> OccupancyMap:
        """Return the map of a log on a grid, with a remedy for repeated readings or without."""
        from sonarmap.kernels.layers import add_empty, add_occupied  # numba: loaded when mapping

        scene = self.scene(log.ring, grid)
        beams = beams_of(log, scene.limit_m, self.no_echo)
        reach_m = beams.range_m + np.where(beams.echo, self.error_m, -self.error_m)
        empty, occupied, arcs = np.zeros(scene.size), np.zeros(scene.size), []
        for part, cells in self.touched(scene, beams, np.maximum(reach_m, 0.0), votes):
            on_arc = add_empty(
                empty,
                cells.first,
                cells.cell,
                cells.range_m,
                cells.share,
                part.range_m,
                log.ring.range_min_m,
                self.error_m,
            )
            arcs.append((part.range_m, cells.keep(on_arc)))
        for reading_m, cells in arcs:
            add_occupied(
                occupied,
                empty,
                cells.first,
                cells.cell,
                cells.range_m,
                cells.share,
                reading_m,
                self.error_m,
                _LEAST_SUM,
            )
        support = np.where(occupied >= empty, occupied, -empty)
        return self.from_support(grid, support, (occupied > 0) | (empty > 0))
