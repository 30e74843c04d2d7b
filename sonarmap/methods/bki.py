"""Bayesian kernel inference with the shapes that a sonar tells of: arcs and sectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import positive, within
from sonarmap.methods.cones import Beams, Cells
from sonarmap.methods.onepass import ConeMethod, Layers, OnePass, Scene
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["BayesianKernel"]

_OCCUPIED_FROM, _FREE_UP_TO = 0.7, 0.3


@dataclass(frozen=True, kw_only=True)
class BayesianKernel(ConeMethod, OnePass):
    """Beta counts of occupied and free, smoothed by a sparse kernel over the distance.

    Parameters
    ----------
    length_m : float
        l, beyond which the kernel is 0, metres, > 0.
    spread : float
        How far the weight of an arc is shared among its cells, in [0, 1]: 1 gives each arc the
        weight of one point in all, as it holds one obstacle; 0 gives each of its cells that.
    prior : float
        Count of occupied and of free that each cell begins with, > 0.
    no_echo, max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    With d the distance of a cell from what a reading tells::

        k(d) = (2 + cos(2 pi d / l)) (1 - d / l) / 3 + sin(2 pi d / l) / (2 pi),  0 from d = l on
        A = prior + sum of w k(distance to the arc)
        B = prior + sum of k(distance to the free sector)
        P(occupied) = A / (A + B)

    Published for points and lines of lidars; distances to *arcs* and *sectors* are ours, and taken
    within the cone, where both are differences of ranges: nothing spills over its sides. The
    sector ends l before the reading, so that it says nothing of the arc itself. An arc of m cells
    has w = m^-spread. Kernel, prior, l and the map's thresholds 0.3 and 0.7 are the published ones.
    """

    name: ClassVar[str] = "bki"
    source: ClassVar[str] = (
        "After Doherty, Shan, Wang and Englot, Learning-Aided 3-D Occupancy Mapping with Bayesian "
        "Generalized Kernel Inference, IEEE Transactions on Robotics 35(4), 2019."
    )

    length_m: float = 0.2
    spread: float = 1.0
    prior: float = 0.001

    def __post_init__(self) -> None:
        super().__post_init__()
        positive("length_m", self.length_m)
        within("spread", self.spread, 0, 1)
        positive("prior", self.prior)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "length_m": Real(0.04, 0.5, log=True),
            "spread": Real(0.0, 1.0),
            "prior": Real(0.001, 10.0, log=True),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def layers(self, scene: Scene) -> Layers:
        """Return no counts beyond the prior."""
        return {"occupied": np.zeros(scene.size), "free": np.zeros(scene.size)}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the end of each arc's kernel; no echo is not smoothed beyond the limit."""
        return beams.range_m + np.where(beams.echo, self.length_m, 0.0)

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Add the kernels."""
        from sonarmap.kernels.layers import add_kernels  # numba: loaded when mapping

        arc_cells = 2 * scene.half_angle_rad * beams.range_m / scene.grid.resolution_m
        add_kernels(
            layers["occupied"],
            layers["free"],
            cells.first,
            cells.cell,
            cells.range_m,
            beams.range_m,
            beams.echo,
            self.length_m,
            np.maximum(arc_cells, 1.0) ** -self.spread,
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map of the mean of each cell's Beta distribution."""
        occupied, free = layers["occupied"], layers["free"]
        total = occupied + free
        return self.from_support(
            scene.grid,
            (occupied - free) / (total + 2 * self.prior),
            total > 0,
            occupied_from=_OCCUPIED_FROM,
            free_up_to=_FREE_UP_TO,
        )
