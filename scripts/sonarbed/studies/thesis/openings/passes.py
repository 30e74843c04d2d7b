"""Passes by an opening on the bench: from how far it is seen, and what geometry derives."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

import worlds
from sim.sonar.presets import preset
from sim.sonar.protocol import Sonar
from sonarbed.reporting.bench import readings
from sonarbed.reporting.statistics import Estimate, mean_of
from worlds import World

__all__ = [
    "BEYOND_M",
    "RIG",
    "SHARE",
    "SPEED_MPS",
    "Line",
    "Passes",
    "counts",
    "derived",
    "detects",
    "farthest_m",
    "passes_of_seed",
    "seeing_half_angle_rad",
]

SHARE = 0.6
"""An opening counts as seen while so many of the nearest pass's readings detect it; p. 57."""

RIG = "opening-rig"
"""The room: two boards with a gap."""

SPEED_MPS = 0.1
"""Of the driver "straight", assumed: the thesis gives no speed."""

# A reading that is longer than the boards' distance by more than this went through the opening;
# the farthest point of a board that a cone of 30 degrees sees at 2.6 m is 0.09 m longer.
BEYOND_M = 0.3


@dataclass(frozen=True)
class Line:
    """``farthest distance = slope * opening + offset_m``."""

    slope: float
    offset_m: float

    def at(self, gap_m: ArrayLike) -> NDArray[np.float64]:
        """Return the distance for openings of the given widths, metres."""
        return self.slope * np.asarray(gap_m, float) + self.offset_m


@dataclass(frozen=True, eq=False)
class Passes:
    """Passes by openings of many widths at many distances.

    Parameters
    ----------
    gaps_m, distances_m : ndarray
        Widths of the openings, and distances, the nearest first.
    detected : ndarray of int, shape (seeds, gaps, distances)
        How many readings of a pass detect the opening.
    """

    gaps_m: NDArray[np.float64]
    distances_m: NDArray[np.float64]
    detected: NDArray[np.int64]

    @cached_property
    def farthest_m(self) -> NDArray[np.float64]:
        """The largest distance at which each opening is seen, shape (seeds, gaps)."""
        return np.array(
            [[farthest_m(self.distances_m, n) for n in counted] for counted in self.detected]
        )

    def farthest_at(self, gap_m: float) -> Estimate:
        """Return the largest distance for the opening nearest to `gap_m`."""
        return mean_of(self.farthest_m[:, np.argmin(np.abs(self.gaps_m - gap_m))])

    def share_at(self, gap_m: float, distance_m: float) -> Estimate:
        """Return the share of the nearest pass's readings that still detect the opening."""
        gap = np.argmin(np.abs(self.gaps_m - gap_m))
        distance = np.argmin(np.abs(self.distances_m - distance_m))
        counted = self.detected[:, gap]
        return mean_of(counted[:, distance] / np.where(counted[:, 0] > 0, counted[:, 0], np.nan))

    @cached_property
    def fits(self) -> list[Line]:
        """The line through the points of each seed."""
        return [
            Line(*np.polyfit(self.gaps_m[known], row[known], 1))
            for row in self.farthest_m
            if (known := np.isfinite(row)).sum() >= 2
        ]

    @property
    def slope(self) -> Estimate:
        """The slope of these lines."""
        return mean_of([line.slope for line in self.fits])

    @property
    def offset_m(self) -> Estimate:
        """The offset of these lines, metres."""
        return mean_of([line.offset_m for line in self.fits])


def derived(half_angle_rad: float, near_m: float) -> Line:
    """Return the equation of the largest distance from which an opening is seen.

    A sonar that looks at the boards squarely hears one of them as soon as the edge of its cone
    touches it, since a ray at the edge meets the board at no more than the critical angle. It
    passes an opening ``g`` wide unheard on a way of ``g - 2 d tan b`` only. The share ``q`` of
    the nearest pass's way, ``g - 2 d_near tan b``, is left at
    ``d = (1 - q) / (2 tan b) g + q d_near``.

    Parameters
    ----------
    half_angle_rad : float
        ``b``, see `seeing_half_angle_rad`.
    near_m : float
        ``d_near``, the distance of the nearest pass, metres.
    """
    return Line((1 - SHARE) / (2 * math.tan(half_angle_rad)), SHARE * near_m)


def seeing_half_angle_rad(sonar: Sonar, rig: World) -> float:
    """Return the largest bearing at which a squarely met board still returns sound, radians.

    Beyond the cone no sound goes; beyond the board's critical incidence none comes back.
    """
    return min(sonar.ring.half_angle_rad, float(rig.critical_incidence_rad.min()))


def counts(
    sonar: Sonar,
    gap_m: float,
    distances_m: NDArray[np.float64],
    first_m: float,
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    """Return how many readings of a pass detect an opening, at each distance.

    Parameters
    ----------
    sonar : Sonar
        Whose acoustics; it reads once a scan period, at the driver's speed.
    gap_m : float
        Width of the opening, metres.
    distances_m : ndarray, shape (n,)
        Distances of the passes from the boards, metres.
    first_m : float
        Where the readings begin, metres along the boards: below one step, at random.
    rng : numpy.random.Generator
        Noise of the readings.
    """
    step_m = SPEED_MPS * sonar.firing.period_s
    # Before and behind the opening there is nothing but board.
    half = math.ceil(gap_m / 2 / step_m) + 1
    along_m = np.arange(-half, half + 1) * step_m + first_m
    rig = worlds.load(RIG, gap_m=gap_m)
    d, x = np.meshgrid(distances_m, along_m, indexing="ij")
    heard = readings(sonar, rig, np.column_stack([x.ravel(), -d.ravel()]), np.pi / 2, rng)
    counted: NDArray[np.int64] = detects(heard.reshape(d.shape), d).sum(axis=1)
    return counted


def farthest_m(distances_m: NDArray[np.float64], detected: NDArray[np.int64]) -> float:
    """Return the largest distance with at least `SHARE` of the nearest pass's readings.

    Between the last distance with enough and the next: their middle. NaN if the nearest pass
    detects nothing, or the farthest still enough.
    """
    enough = detected >= SHARE * detected[0]
    if detected[0] == 0 or enough.all():
        return math.nan
    first_without = int(np.argmin(enough))
    return float(distances_m[first_without - 1 : first_without + 1].mean())


def detects(
    heard_m: NDArray[np.float64], distance_m: NDArray[np.float64] | float
) -> NDArray[np.bool_]:
    """Return which readings are clearly beyond the boards; too close (-inf) means a board."""
    return heard_m > distance_m + BEYOND_M


def passes_of_seed(
    task: tuple[str, tuple[float, ...], tuple[float, ...], int],
) -> NDArray[np.int64]:
    """Return the counts of one seed, shape (gaps, distances)."""
    name, gaps_m, distances_m, seed = task
    sonar, rng = preset(name), np.random.default_rng(seed)
    # The robot's scans know nothing of the opening's edges, so the first lies anywhere.
    step_m = SPEED_MPS * sonar.firing.period_s
    distances = np.array(distances_m)
    return np.array([counts(sonar, gap, distances, rng.uniform(0, step_m), rng) for gap in gaps_m])
