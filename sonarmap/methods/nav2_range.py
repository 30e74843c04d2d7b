"""The range sensor layer of nav2's costmap, line by line, in its eight bits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.errors import InputError, positive, within
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.cones import beams_of
from sonarmap.methods.onepass import ConeMethod, Votes
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["Nav2Range"]

# nav2's LETHAL_OBSTACLE, and what a cell has before anything is known: to_cost(0.5).
_LETHAL, _UNKNOWN = 254, 127


@dataclass(frozen=True, kw_only=True)
class Nav2Range(ConeMethod):
    """What a robot that runs ROS 2 with the default settings makes of its sonars.

    Parameters
    ----------
    phi_m : float
        ``phi``: range at which the sonar is believed half, metres, > 0.
    inflate_cone : float
        ``inflate_cone``: 1 updates the whole box around the cone, less a triangle that is
        inflated by so much; in [0, 1].
    clear_threshold, mark_threshold : float
        P(occupied) below and above which a cell counts as free and as occupied.
    no_echo
        "ignore" is nav2's way with +inf, which is dropped as out of range. "clear" is
        ``clear_on_max_reading`` with a driver that reports the maximum range for no echo.
    max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`. A reading below the ring's nearest range is dropped.

    Notes
    -----
    With r and a a cell's range and bearing, z the reading, q the resolution as a *fraction* (so
    it is in the source) and half the cone's half-angle::

        weight = (1 - (1 + tanh(2 (r - phi))) / 2) (1 - (a / half)^2), 0 outside of the cone
        r < z (1 - 2q):  p = (1 - weight) / 2
        r < z (1 - q):   p = weight / 2 ((r - z (1 - 2q)) / (q z))^2 + (1 - weight) / 2
        r < z (1 + q):   p = weight / 2 (1 - ((z - r) / (q z))^2) + 1 / 2
        beyond:          p = 1 / 2
        cost = floor(254 p P / (p P + (1 - p) (1 - P))),  P = cost / 254

    The cell of the reading on the axis is set to 233 first. All cells of the box around the sonar
    and the cone's corners at 1.2 z are updated, also those outside of the cone, where p = 1/2
    leaves each of the 255 costs as it is. Clearing writes zeros over the whole box, whose corners
    are cut to cells toward zero and which holds its upper border.

    Support is 2 cost / 254 - 1, so that P(occupied) is nav2's own. Observed are the cells of
    cones. The remedies of `sonarmap.methods.remedies` do not apply: the layer is what it is.
    """

    name: ClassVar[str] = "nav2-range"
    source: ClassVar[str] = (
        "nav2_costmap_2d::RangeSensorLayer of ros-navigation/navigation2, read at a3a9704."
    )

    phi_m: float = 1.2
    inflate_cone: float = 1.0
    clear_threshold: float = 0.2
    mark_threshold: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("phi_m", self.phi_m)
        within("inflate_cone", self.inflate_cone, 0, 1)
        within("clear_threshold", self.clear_threshold, 0, 1)
        within("mark_threshold", self.mark_threshold, self.clear_threshold, 1)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "phi_m": Real(0.3, 5.0),
            "inflate_cone": Real(0.0, 1.0),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def fuse(self, log: SonarLog, grid: GridSpec, votes: Votes | None = None) -> OccupancyMap:
        """Return the map of a log on a grid.

        Raises
        ------
        InputError
            If there is a remedy.
        """
        from sonarmap.kernels.fusion import bearing_polynomial  # numba: loaded when mapping
        from sonarmap.kernels.layers import add_costs

        if votes is not None:
            raise InputError("nav2-range takes no remedy for repeated readings")
        scene = self.scene(log.ring, grid)
        beams = beams_of(log, scene.limit_m, self.no_echo)
        beams = beams.select(beams.range_m >= log.ring.range_min_m)
        clear = (beams.range_m >= scene.limit_m) & (self.no_echo == "clear")
        cost, seen = np.full(grid.shape, _UNKNOWN, np.uint8), np.zeros(grid.shape, bool)
        add_costs(
            cost,
            seen,
            *grid.origin_xy_m,
            grid.resolution_m,
            beams.sensor_xy_m,
            beams.axis_rad,
            beams.range_m,
            clear,
            scene.half_angle_rad,
            self.inflate_cone,
            self.phi_m,
            bearing_polynomial(scene.half_angle_rad),
        )
        return self.from_support(
            grid,
            2 * cost.astype(float) / _LETHAL - 1,
            seen,
            # nav2 compares costs, and "above" and "below" leave the threshold's own out.
            occupied_from=min((int(_LETHAL * self.mark_threshold) + 0.5) / _LETHAL, 1.0),
            free_up_to=max((int(_LETHAL * self.clear_threshold) - 0.5) / _LETHAL, 0.0),
        )
