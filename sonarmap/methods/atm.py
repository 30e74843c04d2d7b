"""The arc-transversal median: a target is where most other arcs cross the reading's own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, non_negative, one_of
from sonarmap.methods.cones import Beams
from sonarmap.methods.onepass import Scene
from sonarmap.methods.points import PointMethod
from sonarmap.parameters import Real, Space

__all__ = ["ArcTransversalMedian"]

Lonely = Literal["centre", "drop"]


@dataclass(frozen=True, kw_only=True)
class ArcTransversalMedian(PointMethod):
    """The median of the transversal intersections of an arc with all others.

    Parameters
    ----------
    crossing_rad : float
        Intersections under a smaller angle are not transversal, in [0, pi/2).
    lonely : {"drop", "centre"}
        What becomes of an arc that no other crosses: nothing, or the middle of the arc.
    tolerance_m, point_weight, no_echo, max_range_m, half_angle_rad, scale, offset
        See `PointMethod`.

    Notes
    -----
    Two circles of radii a and b whose centres are d apart cross under the angle with the cosine
    |a^2 + b^2 - d^2| / (2 a b); arcs of neighbouring readings run almost along each other and
    cross anywhere, so that only steep crossings count. The target is the median of the bearings
    at which an arc is crossed, of an even number the mean of the middle two.

    The steps are those of the paper's abstract. Ours are the 30 degrees, and that all arcs of the
    log are intersected, not those near in time.
    """

    name: ClassVar[str] = "atm"
    source: ClassVar[str] = (
        "Choset, Nagatani and Lazar, The Arc-Transversal Median Algorithm, IEEE Transactions on "
        "Robotics and Automation 19(3), 2003, from its abstract; the map is ours."
    )

    crossing_rad: float = math.radians(30)
    lonely: Lonely = "drop"

    def __post_init__(self) -> None:
        super().__post_init__()
        steep("crossing_rad", self.crossing_rad)
        one_of("lonely", self.lonely, get_args(Lonely))

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "crossing_rad": Real(0.05, 1.4),
            "tolerance_m": Real(0.025, 0.3),
            "point_weight": Real(0.1, 50.0, log=True),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def bearings_rad(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the median bearings."""
        from sonarmap.kernels.arcs import median_crossings  # numba: loaded when mapping

        along = np.column_stack([np.cos(beams.axis_rad), np.sin(beams.axis_rad)])
        bearing: NDArray[np.float64] = median_crossings(
            beams.sensor_xy_m,
            along,
            beams.range_m,
            math.cos(scene.half_angle_rad),
            math.cos(self.crossing_rad),
        )
        return bearing if self.lonely == "drop" else np.nan_to_num(bearing, nan=0.0)


def steep(name: str, value: float) -> float:
    """Return an angle in [0, pi/2), else raise `InputError`."""
    if non_negative(name, value) >= math.pi / 2:
        raise InputError(f"{name} must be < pi/2, got {value!r}")
    return value
