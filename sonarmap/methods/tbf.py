"""Triangulation-based fusion: a target is a point that several places explain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import positive, whole
from sonarmap.methods.atm import steep
from sonarmap.methods.cones import Beams
from sonarmap.methods.onepass import Scene
from sonarmap.methods.points import PointMethod
from sonarmap.parameters import Real, Space, Whole

__all__ = ["TriangulationFusion"]


@dataclass(frozen=True, kw_only=True)
class TriangulationFusion(PointMethod):
    """The point on a reading's arc at which most arcs of the last scans cross it.

    Parameters
    ----------
    window_scans : int
        How many scans' readings before it are remembered, >= 1: so many times the ring's sonars.
    cluster_m : float
        Crossings within so much along the arc are of one target, metres, > 0.
    least : int
        Crossings that make a triangulation point, >= 1.
    crossing_rad : float
        Least angle of a crossing, in [0, pi/2).
    tolerance_m, point_weight, no_echo, max_range_m, half_angle_rad, scale, offset
        See `PointMethod`.

    Notes
    -----
    For each reading in its turn, its arc is intersected with those of the window; crossings must
    lie in both cones. The cluster with most of them, if it has `least`, is a triangulation point:
    an edge, a corner or a piece of wall that was seen from several places. Its place is the mean
    of the cluster.

    From memory of the paper, whose text could not be had: window, voting on the newest arc and the
    threshold are its idea; the cluster in place of its grid search and all defaults are ours.
    """

    name: ClassVar[str] = "tbf"
    source: ClassVar[str] = (
        "After Wijk and Christensen, Triangulation-Based Fusion of Sonar Data with Application in "
        "Robot Pose Tracking, IEEE Transactions on Robotics and Automation 16(6), 2000."
    )

    window_scans: int = 10
    cluster_m: float = 0.05
    least: int = 3
    crossing_rad: float = math.radians(3)

    def __post_init__(self) -> None:
        super().__post_init__()
        whole("window_scans", self.window_scans, least=1)
        whole("least", self.least, least=1)
        positive("cluster_m", self.cluster_m)
        steep("crossing_rad", self.crossing_rad)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "window_scans": Whole(3, 40),
            "cluster_m": Real(0.01, 0.2),
            "least": Whole(1, 10),
            "crossing_rad": Real(0.0, 0.5),
            "tolerance_m": Real(0.025, 0.3),
            "point_weight": Real(0.1, 50.0, log=True),
        }

    def bearings_rad(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the bearings of the triangulation points."""
        from sonarmap.kernels.arcs import clustered_crossings  # numba: loaded when mapping

        along = np.column_stack([np.cos(beams.axis_rad), np.sin(beams.axis_rad)])
        bearing: NDArray[np.float64] = clustered_crossings(
            beams.sensor_xy_m,
            along,
            beams.range_m,
            math.cos(scene.half_angle_rad),
            math.cos(self.crossing_rad),
            self.window_scans * len(scene.ring),
            self.cluster_m,
            self.least,
        )
        return bearing
