"""The inverse range sensor model of Probabilistic Robotics."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, finite, positive
from sonarmap.methods.cones import Beams, Cells, NoEcho
from sonarmap.methods.onepass import ConeMethod, Layers, OnePass, Scene
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["ThrunInverse"]


@dataclass(frozen=True, kw_only=True)
class ThrunInverse(ConeMethod, OnePass):
    """Three constants of log-odds: an arc that is occupied, a sector that is free, silence.

    Parameters
    ----------
    thickness_m : float
        alpha, the thickness of obstacles, metres, > 0.
    occupied_log_odds, free_log_odds : float
        What a cell on the arc, > 0, and before it, < 0, is told.
    no_echo
        "clear" by default: in the table a reading of the maximum range frees its whole cone.
    max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    With r the range and a the bearing of a cell, z the reading and beta the full width::

        |a| > beta / 2 or r > min(z_max, z + alpha / 2):   nothing
        z < z_max and |r - z| < alpha / 2:                 + occupied_log_odds
        r <= z:                                            + free_log_odds

    Table 9.2 gives a cell to the nearest beam of a scan that is taken all at once. Sonars fire one
    after the other from places of their own: here each reading is a scan of one beam, and where
    two cones overlap both speak. The defaults are those of the Udacity course's eight sonars
    (alpha 200 mm, 0.4 and -0.4); the book leaves them open.
    """

    name: ClassVar[str] = "thrun-inverse"
    source: ClassVar[str] = (
        "Thrun, Burgard and Fox, Probabilistic Robotics, 2005, table 9.2; constants of Udacity's "
        "RoboND occupancy grid lesson."
    )

    thickness_m: float = 0.2
    occupied_log_odds: float = 0.4
    free_log_odds: float = -0.4
    no_echo: NoEcho = "clear"

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("thickness_m", self.thickness_m)
        positive("occupied_log_odds", self.occupied_log_odds)
        if finite("free_log_odds", self.free_log_odds) >= 0:
            raise InputError(f"free_log_odds must be < 0, got {self.free_log_odds!r}")

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "thickness_m": Real(0.05, 0.3),
            "occupied_log_odds": Real(0.02, 3.0, log=True),
            "free_log_odds": Real(-3.0, -0.02),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def layers(self, scene: Scene) -> Layers:
        """Return log-odds of 0, and no cell seen."""
        return {"log_odds": np.zeros(scene.size), "seen": np.zeros(scene.size, bool)}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the far border of each arc; no obstacle is told of beyond the maximum range."""
        return np.minimum(beams.range_m + self.thickness_m / 2, scene.limit_m)

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Add the constants."""
        from sonarmap.kernels.layers import add_thrun  # numba: loaded when mapping

        add_thrun(
            layers["log_odds"],
            layers["seen"],
            cells.first,
            cells.cell,
            cells.range_m,
            beams.range_m,
            beams.echo & (beams.range_m < scene.limit_m),
            self.thickness_m / 2,
            self.occupied_log_odds,
            self.free_log_odds,
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map of the log-odds."""
        return self.from_log_odds(scene.grid, layers["log_odds"], layers["seen"])
