"""Dempster-Shafer evidence: masses for occupied, free and unknown in place of one probability."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, finite, one_of, positive
from sonarmap.methods.bayes.models import THESIS_UNIT_M
from sonarmap.methods.cones import Beams, Cells
from sonarmap.methods.onepass import ConeMethod, Layers, OnePass, Scene
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["DempsterShafer", "Matching"]

Matching = Literal["textbook", "pignistic", "plausibility"]


@dataclass(frozen=True, kw_only=True)
class DempsterShafer(ConeMethod, OnePass):
    """Dempster's rule with the masses of the standard sensor model.

    Parameters
    ----------
    matching : {"pignistic", "plausibility", "textbook"}
        How the model's P(occupied) becomes masses, and the cell's masses P(occupied) again: the
        row "Dempster-Shafer" of a table means nothing without it.
    max_occupied : float
        No mass of occupied is ever more than this, in (0.5, 1].
    tolerance_m : float
        Half of the thickness of the arc (region 1), metres, > 0.
    no_echo, max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`; the maximum range is also R below.

    Notes
    -----
    With a share of the half-angle, b = ((R - r) / R + (1 - share)) / 2, as in `StandardModel`::

        arc, |r - s| <= tolerance:  p = b max_occupied       textbook: m(O) = p, m(U) = 1 - p
        sector, r < s - tolerance:  p = 1 - b                          m(F) = b, m(U) = 1 - b

        pignistic:     m(O) = max(0, 2p - 1), m(F) = max(0, 1 - 2p)
        plausibility:  p >= 1/2: m(O) = (2p - 1) / p;  p < 1/2: m(F) = (1 - 2p) / (1 - p)

    and U has the rest. Dempster's rule, with the conflict K = O1 F2 + F1 O2::

        O = (O1 O2 + O1 U2 + U1 O2) / (1 - K),  F alike,  U = U1 U2 / (1 - K)

    The map states the pignistic probability O + U / 2 (textbook and pignistic matching) or the
    relative plausibility (O + U) / (1 + U). With plausibility matching Dempster's rule *is*
    Bayes' rule, and the map that of ``bayes-standard``; the two matchings differ in everything
    that the masses carry beside it. p is clipped to [1e-6, 1 - 1e-6], as Bayesian updating does:
    total conflict has no combination.
    """

    name: ClassVar[str] = "dempster-shafer"
    source: ClassVar[str] = (
        "Murphy, Introduction to AI Robotics, 2000, chapter 11; matchings of Berlenko and Krinkin, "
        "arXiv 2602.18872, 2026."
    )

    matching: Matching = "pignistic"
    max_occupied: float = 0.98
    tolerance_m: float = THESIS_UNIT_M

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of("matching", self.matching, get_args(Matching))
        positive("tolerance_m", self.tolerance_m)
        if not 0.5 < finite("max_occupied", self.max_occupied) <= 1:
            raise InputError(f"max_occupied must be in (0.5, 1], got {self.max_occupied!r}")

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "tolerance_m": Real(0.025, 0.15),
            "max_occupied": Real(0.51, 0.99),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def layers(self, scene: Scene) -> Layers:
        """Return all mass on unknown."""
        zeros, ones = np.zeros(scene.size), np.ones(scene.size)
        return {"occupied": zeros, "free": zeros.copy(), "unknown": ones}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the far border of each arc, or of each free sector."""
        return np.maximum(
            beams.range_m + np.where(beams.echo, self.tolerance_m, -self.tolerance_m), 0.0
        )

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Combine the masses."""
        from sonarmap.kernels.layers import add_masses  # numba: loaded when mapping

        add_masses(
            layers["occupied"],
            layers["free"],
            layers["unknown"],
            cells.first,
            cells.cell,
            cells.range_m,
            cells.share,
            beams.range_m,
            beams.echo,
            scene.limit_m,
            self.tolerance_m,
            self.max_occupied,
            get_args(Matching).index(self.matching),
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map that the matching reads from the masses."""
        occupied, free, unknown = (layers[name] for name in ("occupied", "free", "unknown"))
        support = occupied - free
        if self.matching == "plausibility":
            # (O + U) / (O + F + 2 U), times 2, less 1.
            support = support / (occupied + free + 2 * unknown)
        return self.from_support(scene.grid, support, unknown < 1)
