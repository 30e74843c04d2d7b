"""Inverse sensor models: how probable it is that a cell is occupied, given one reading.

Both models of the thesis are *bilinear in range and bearing* inside up to three regions that lie
one behind the other on the cone. A model is therefore told by its `Regions`: the far border of
each, and in each the straight line of P(occupied) over range on the acoustic axis and at the
cone's edge. `probability` and the mapping kernel both read that one description.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sonarmap.errors import InputError, positive, within

__all__ = ["ParameterizedModel", "Regions", "SensorModel", "StandardModel", "probability"]

REGION_COUNT = 3
THESIS_UNIT_M = 0.1
"""The thesis draws ten units over a range of one metre."""
# The kernel's polynomial for the bearing is exact to 1e-12 up to here, and no sonar is wider.
MAX_HALF_ANGLE_RAD = math.radians(60)


@dataclass(frozen=True)
class Regions:
    """P(occupied) of n readings in regions that lie one behind the other.

    Region k of a reading reaches from the far border of region k - 1 (included; 0 for the first)
    to its own (excluded, but for the last). In it P(occupied) is linear in range on the axis and
    at the edge of the cone, and linear in bearing between the two. A region that is not longer
    than nothing is empty.

    Parameters
    ----------
    border_m : ndarray, shape (n, 3)
        Far border of each region in metres, not decreasing; the last is the model's reach.
    axis, edge : ndarray, shape (n, 3, 2)
        Intercept and slope (per metre) of P(occupied) over range, on the axis and at the edge.
    """

    border_m: NDArray[np.float64]
    axis: NDArray[np.float64]
    edge: NDArray[np.float64]

    @classmethod
    def empty(cls, size: int) -> Regions:
        """Return regions for `size` readings, all silent: no reach, P(occupied) = 0.5."""
        lines = np.zeros((size, REGION_COUNT, 2))
        lines[..., 0] = 0.5
        return cls(np.zeros((size, REGION_COUNT)), lines, lines.copy())

    @property
    def reach_m(self) -> NDArray[np.float64]:
        """Range up to which each reading says anything, metres, shape (n,)."""
        reach: NDArray[np.float64] = self.border_m[:, -1]
        return reach


@runtime_checkable
class SensorModel(Protocol):
    """What mapping asks of a sensor model."""

    @property
    def half_angle_rad(self) -> float:
        """Half of the cone's full width."""

    @property
    def range_limit_m(self) -> float:
        """Longest reading that the model has an opinion on; inf when it has no limit."""

    def regions(self, reading_m: NDArray[np.float64]) -> Regions:
        """Return the regions of finite readings, shape (n,)."""

    def free_regions(self, range_m: NDArray[np.float64]) -> Regions:
        """Return the regions of cones that are known to be free up to a range, shape (n,)."""


@dataclass(frozen=True)
class StandardModel:
    """The standard sensor model, equations 4.9 to 4.12 of Rashid 2006 (from Murphy 2000, ch. 11).

    Parameters
    ----------
    beta_rad : float
        Half-angle of the cone, in (0, pi/3].
    max_range_m : float
        R, the longest range that the sonar can sense, > 0. Longer readings are silent.
    max_occupied : float
        No cell is ever believed to be occupied with more than this, in (0.5, 1].
    tolerance_m : float
        Half of the thickness of region 1, > 0.

    Notes
    -----
    With a the absolute bearing and r the range of a cell, and s the reading::

        belief = ((R - r) / R + (beta - a) / beta) / 2
        region 1, s - tolerance <= r <= s + tolerance:  P(occupied) = belief * max_occupied
        region 2, r < s - tolerance:                    P(empty) = belief

    As the thesis notes (section 5.1) region 2 may say "occupied" and region 1 "empty" near the
    edge of the cone: that is the model, not an error of ours.
    """

    beta_rad: float
    max_range_m: float
    max_occupied: float
    tolerance_m: float

    def __post_init__(self) -> None:
        _half_angle("beta_rad", self.beta_rad)
        positive("max_range_m", self.max_range_m)
        positive("tolerance_m", self.tolerance_m)
        if not 0.5 < self.max_occupied <= 1:
            raise InputError(f"max_occupied must be in (0.5, 1], got {self.max_occupied!r}")

    @classmethod
    def thesis(cls) -> StandardModel:
        """Return the setting of figure 5.8 a: beta 15 degrees, tolerance 1 unit, 0.98; R 3 m."""
        return cls(math.radians(15), 3.0, 0.98, THESIS_UNIT_M)

    @property
    def half_angle_rad(self) -> float:
        """Half of the cone's full width, beta."""
        return self.beta_rad

    @property
    def range_limit_m(self) -> float:
        """R: longer readings are silent."""
        return self.max_range_m

    def regions(self, reading_m: NDArray[np.float64]) -> Regions:
        """Return region 2 (near) and region 1 of each reading."""
        regions = self._free(np.maximum(reading_m - self.tolerance_m, 0))
        regions.border_m[:, 1:] = reading_m[:, None] + self.tolerance_m
        # Equation 4.9 on the axis (a = 0) and at the edge (a = beta).
        regions.axis[:, 1:] = self.max_occupied * np.array([1, -0.5 / self.max_range_m])
        regions.edge[:, 1:] = self.max_occupied * np.array([0.5, -0.5 / self.max_range_m])
        return regions

    def free_regions(self, range_m: NDArray[np.float64]) -> Regions:
        """Return region 2 alone, up to `tolerance_m` before the range."""
        return self._free(np.maximum(range_m - self.tolerance_m, 0))

    def _free(self, until_m: NDArray[np.float64]) -> Regions:
        regions = Regions.empty(until_m.size)
        regions.border_m[:] = until_m[:, None]
        # Equations 4.11 and 4.12 on the axis and at the edge.
        regions.axis[:, 0] = [0, 0.5 / self.max_range_m]
        regions.edge[:, 0] = [0.5, 0.5 / self.max_range_m]
        return regions

    def probability(
        self, range_m: ArrayLike, bearing_rad: ArrayLike, reading_m: ArrayLike
    ) -> NDArray[np.float64]:
        """Return P(occupied), see `sonarmap.methods.bayes.models.probability`."""
        return probability(self, range_m, bearing_rad, reading_m)


@dataclass(frozen=True)
class ParameterizedModel:
    """The parameterized sensor model of the thesis, equations 5.1 to 5.5 of Rashid 2006.

    Parameters
    ----------
    p1 : float
        P(occupied) on the axis at the sonar, in [0, 0.5).
    p2 : float
        Gap to 0.5 at the border of regions 2 and 1: P(occupied) jumps from 0.5 - p2 to
        0.5 + p2; in [0, 0.5 - p1] and at most p4 - 0.5.
    p3_m : float
        Tolerance, half of the thickness of region 1, metres, > 0.
    p4 : float
        P(occupied) on the axis at the reading, in (0.5, 1].
    p5_rad : float
        Half-angle of the cone, in (0, pi/3].

    Notes
    -----
    On the axis, with S the reading and r the range of a cell::

        line 1, r < S - P3:           P1 + (0.5 - P1 - P2) / (S - P3) * r
        line 3, S - P3 <= r < S:      0.5 + P2 + (P4 - 0.5 - P2) / P3 * (r - S + P3)
        line 4, S <= r <= S + P3:     P4 + (0.5 + P2 - P4) / P3 * (r - S)

    and off the axis (equation 5.1) the distance from 0.5 shrinks linearly to 0 at the edge.
    """

    p1: float
    p2: float
    p3_m: float
    p4: float
    p5_rad: float

    def __post_init__(self) -> None:
        positive("p3_m", self.p3_m)
        _half_angle("p5_rad", self.p5_rad)
        # P4 before P1, which is often 1 - P4.
        if not 0.5 < self.p4 <= 1:
            raise InputError(f"p4 must be in (0.5, 1], got {self.p4!r}")
        if not 0 <= self.p1 < 0.5:
            raise InputError(f"p1 must be in [0, 0.5), got {self.p1!r}")
        # The slack lets p4 = 0.7 have p2 = 0.2, although 0.7 - 0.5 is 0.19999999999999996.
        within("p2", self.p2, 0, min(0.5 - self.p1, self.p4 - 0.5) + 1e-12)

    @classmethod
    def thesis(cls) -> ParameterizedModel:
        """Return the setting of figure 5.8 b: 0.02, 0.15, 1 unit, 0.98 and 15 degrees."""
        return cls(p1=0.02, p2=0.15, p3_m=THESIS_UNIT_M, p4=0.98, p5_rad=math.radians(15))

    @property
    def half_angle_rad(self) -> float:
        """Half of the cone's full width, P5."""
        return self.p5_rad

    @property
    def range_limit_m(self) -> float:
        """No limit: the model does not know the sonar's maximum range."""
        return math.inf

    def regions(self, reading_m: NDArray[np.float64]) -> Regions:
        """Return region 2 (line 1) and the two halves of region 1 (lines 3 and 4)."""
        regions = self.free_regions(reading_m)
        rise = (self.p4 - 0.5 - self.p2) / self.p3_m
        regions.border_m[:, 1] = reading_m
        regions.border_m[:, 2] = reading_m + self.p3_m
        regions.axis[:, 1, 0] = 0.5 + self.p2 - rise * (reading_m - self.p3_m)
        regions.axis[:, 1, 1] = rise
        regions.axis[:, 2, 0] = self.p4 + rise * reading_m
        regions.axis[:, 2, 1] = -rise
        return regions

    def free_regions(self, range_m: NDArray[np.float64]) -> Regions:
        """Return line 1 alone, up to `p3_m` before the range."""
        regions = Regions.empty(range_m.size)
        until_m = np.maximum(range_m - self.p3_m, 0)
        regions.border_m[:] = until_m[:, None]
        regions.axis[:, 0, 0] = self.p1
        # A reading shorter than P3 has no region 2; its slope is never used.
        regions.axis[:, 0, 1] = (0.5 - self.p1 - self.p2) / np.where(until_m > 0, until_m, 1)
        return regions

    def probability(
        self, range_m: ArrayLike, bearing_rad: ArrayLike, reading_m: ArrayLike
    ) -> NDArray[np.float64]:
        """Return P(occupied), see `sonarmap.methods.bayes.models.probability`."""
        return probability(self, range_m, bearing_rad, reading_m)


def probability(
    model: SensorModel, range_m: ArrayLike, bearing_rad: ArrayLike, reading_m: ArrayLike
) -> NDArray[np.float64]:
    """Return P(occupied) of cells, given one reading each; the arguments broadcast.

    Parameters
    ----------
    model : SensorModel
        The model.
    range_m : array_like
        Distance of the cell from the sonar, metres.
    bearing_rad : array_like
        Angle of the cell off the acoustic axis, radians in [-pi, pi]; its sign does not matter.
    reading_m : array_like
        The sonar's reading, metres.

    Returns
    -------
    ndarray
        P(occupied), in the broadcast shape. 0.5 where the model is silent: outside of the cone,
        beyond its reach, and for a reading that is not finite, negative or above its limit.
    """
    distance, bearing, reading = np.broadcast_arrays(
        np.asarray(range_m, float), np.asarray(bearing_rad, float), np.asarray(reading_m, float)
    )
    heard = np.isfinite(reading) & (reading >= 0) & (reading <= model.range_limit_m)
    regions = model.regions(np.where(heard, reading, 0.0).ravel())
    flat = distance.ravel()
    share = np.abs(bearing.ravel()) / model.half_angle_rad

    # The region of a cell is the first whose far border lies beyond it.
    which = np.minimum((flat[:, None] >= regions.border_m).sum(axis=1), REGION_COUNT - 1)
    rows = np.arange(flat.size)
    on_axis, at_edge = (
        lines[rows, which, 0] + lines[rows, which, 1] * flat
        for lines in (regions.axis, regions.edge)
    )
    believed = on_axis + (at_edge - on_axis) * share
    speaks = heard.ravel() & (share <= 1) & (flat >= 0) & (flat <= regions.reach_m)
    result: NDArray[np.float64] = np.where(speaks, believed, 0.5).reshape(distance.shape)
    return result


def _half_angle(name: str, value: float) -> None:
    if not 0 < value <= MAX_HALF_ANGLE_RAD:
        raise InputError(f"{name} must be in (0, pi/3], got {value!r}")
