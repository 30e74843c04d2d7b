"""Fuzzy maps: how far a cell belongs to the empty and to the occupied ones, apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, finite, one_of, positive
from sonarmap.methods.cones import Beams, Cells
from sonarmap.methods.onepass import ConeMethod, Layers, OnePass, Scene
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["Fuzzy"]

FuzzyMap = Literal["difference", "unsafe"]


@dataclass(frozen=True, kw_only=True)
class Fuzzy(ConeMethod, OnePass):
    """Two fuzzy sets, united over readings by Dombi's operator.

    Parameters
    ----------
    most_empty, most_occupied : float
        kE and kO: memberships that one reading gives at most, in (0, 1).
    thickness_m : float
        dr: half of the thickness of the arc, metres, > 0.
    visible_m : float
        Range at which the sonar is believed half, metres, > 0.
    power : float
        Dombi's exponent, > 0.
    reading : {"difference", "unsafe"}
        What the map states: how much more occupied than empty a cell is, or the set of unsafe
        cells.
    no_echo, max_range_m, half_angle_rad, scale, offset
        See `ConeMethod`.

    Notes
    -----
    With r and a a cell's range and share of the half-angle and R the reading::

        seen = (1 - a^2) (1 - (1 + tanh(2 (r - visible_m))) / 2)
        r < R - dr:      e = kE seen
        R - dr <= r < R: e = kE seen ((R - r) / dr)^2
        |r - R| < dr:    o = kO seen (1 - ((r - R) / dr)^2)

        union over readings (Dombi):  x = (sum of (m / (1 - m))^power)^(1 / power)
                                      E or O = x / (1 + x)

        ambiguous A = E O,  indeterminate I = (1 - E) (1 - O)
        safe S = E^2 (1 - O) (1 - A) (1 - I)

    "difference": support is O - E, so that P(occupied) is (1 + O - E) / 2; the choice is ours.
    "unsafe": P(occupied) is 1 - S, the set in which the papers plan paths, where a cell was seen.
    In that set a cell that nobody has seen is unsafe, which is right for planning and says nothing
    about walls: here it has 1/2.

    The form of the sets is the papers'; kE, kO, dr and the exponent could not be confirmed, and
    the products for the intersections are ours. The visibility function is the one that nav2's
    range layer took over.
    """

    name: ClassVar[str] = "fuzzy"
    source: ClassVar[str] = (
        "Oriolo, Ulivi and Vendittelli, Fuzzy Maps, Journal of Robotic Systems 14(3), 1997, and "
        "Poloni, Ulivi and Vendittelli, Fuzzy Sets and Systems 69, 1995; constants not confirmed."
    )

    most_empty: float = 0.1
    most_occupied: float = 0.25
    thickness_m: float = 0.15
    visible_m: float = 1.2
    power: float = 1.0
    reading: FuzzyMap = "difference"

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("most_empty", "most_occupied"):
            if not 0 < finite(name, getattr(self, name)) < 1:
                raise InputError(f"{name} must be in (0, 1), got {getattr(self, name)!r}")
        for name in ("thickness_m", "visible_m", "power"):
            positive(name, getattr(self, name))
        one_of("reading", self.reading, get_args(FuzzyMap))

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "most_empty": Real(0.01, 0.9, log=True),
            "most_occupied": Real(0.01, 0.9, log=True),
            "thickness_m": Real(0.05, 0.3),
            "visible_m": Real(0.3, 5.0),
            "power": Real(0.5, 3.0),
            "half_angle_rad": Real(0.05, 0.7),
        }

    def layers(self, scene: Scene) -> Layers:
        """Return two empty sets."""
        return {"empty": np.zeros(scene.size), "occupied": np.zeros(scene.size)}

    def reach_m(self, scene: Scene, beams: Beams) -> NDArray[np.float64]:
        """Return the far border of each arc; the limit without an echo."""
        return beams.range_m + np.where(beams.echo, self.thickness_m, 0.0)

    def add(self, scene: Scene, layers: Layers, beams: Beams, cells: Cells) -> None:
        """Unite the sets with those of the readings."""
        from sonarmap.kernels.layers import add_fuzzy  # numba: loaded when mapping

        add_fuzzy(
            layers["empty"],
            layers["occupied"],
            cells.first,
            cells.cell,
            cells.range_m,
            cells.share,
            beams.range_m,
            beams.echo,
            self.thickness_m,
            self.most_empty,
            self.most_occupied,
            self.visible_m,
            self.power,
        )

    def read(self, scene: Scene, layers: Layers) -> OccupancyMap:
        """Return the map of the two sets."""
        odds = [layers[name] ** (1 / self.power) for name in ("empty", "occupied")]
        empty, occupied = (each / (1 + each) for each in odds)
        seen = (empty > 0) | (occupied > 0)
        support = occupied - empty
        if self.reading == "unsafe":
            clear = (1 - empty * occupied) * (1 - (1 - empty) * (1 - occupied))
            safe = empty**2 * (1 - occupied) * clear
            support = np.where(seen, 1 - 2 * safe, 0.0)
        return self.from_support(scene.grid, support, seen)
