"""The forward model of a cone: how probable a reading is, given the map.

After Thrun, Learning Occupancy Grid Maps with Forward Sensor Models, Autonomous Robots 15, 2003: a
reading is random, or the echo of the first obstacle in the cone that answers, or no echo because
none did. With the occupied cells of the cone in order of range, z the reading, and h(c) = p_hit *
(1 - (1 - edge) * (bearing / half-angle)^2) the probability that cell c answers, the cone's factor::

    P(z | m)       = p_random / z_max + (1 - p_random) * sum over cells c of the cone
                     h(c) m(c) * product over nearer cells (1 - h(c') m(c')) * N(z; r(c), s)
    P(no echo | m) = p_no_echo + (1 - p_no_echo) * product over all cells (1 - h(c) m(c))

The mixture and its order are Thrun's, and so is an even cone (edge = 1). His parameters could not
be had; the weaker edge, the probability of a lost echo `p_no_echo` (his maximum-range case is a
normal distribution around z_max), and these are ours:

* Cells within 3 s of the reading are taken in five bins of equal width; of one bin all answer at
  its middle. What is nearer only blocks, what is farther does not matter.
* The variance of a reading is s^2 + resolution^2 / 12, for a wall lies anywhere in its cell.
* Readings that a sonar takes from about the same place share one vote, which is the exponent of
  their factors (`sonarmap.methods.arc_competition.shared_votes`).

A factor is linear in each single cell, so that its expectation over independent cells is its value
at their probabilities: that is what belief propagation needs.
"""

from __future__ import annotations

import math
from abc import ABC
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, positive, within
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.arc_competition import shared_votes
from sonarmap.rings import SonarRing

__all__ = ["BINS", "ConeFactors", "ForwardModel"]

# An odd number of bins, so that one lies around the reading; together 3 s to each side.
BINS = 5
_REACH_S = 3.0
_BATCH = 500


@dataclass(frozen=True, eq=False)
class ConeFactors:
    """The factors of n readings, and the cells that each one touches.

    Parameters
    ----------
    first : ndarray of int, shape (n + 1,)
        Where the cells of each reading begin.
    cell : ndarray of int, shape (touched,)
        Flat index in the grid.
    zone : ndarray of int, shape (touched,)
        Bin around the reading, 0 to 4; -1 for a cell that is nearer.
    answers : ndarray, shape (touched,)
        h, the probability that the cell answers when it is occupied.
    floor, scale : ndarray, shape (n,)
        The factor is ``floor + scale * ...``: its random part, and the weight of the rest.
    density : ndarray, shape (n, 5)
        What an answer in each bin is worth: N at its middle.
    beyond : ndarray, shape (n,)
        What no answer is worth: 1 for no echo, 0 for an echo.
    vote : ndarray, shape (n,)
        Exponent of the factor.
    """

    first: NDArray[np.int64]
    cell: NDArray[np.int32]
    zone: NDArray[np.int8]
    answers: NDArray[np.float32]
    floor: NDArray[np.float64]
    scale: NDArray[np.float64]
    density: NDArray[np.float64]
    beyond: NDArray[np.float64]
    vote: NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ForwardModel(ABC):
    """What the methods with a forward model have in common; the defaults are ours.

    `p_hit` and `edge` were chosen by hand from a dozen settings, by the noise-free door of the
    tests and one drive each in the rooms office, thesis-exp2, corridor and clutter.

    Parameters
    ----------
    prior : float
        P(occupied) of a cell before any reading, in (0, 0.5].
    p_hit : float
        Probability that an occupied cell on the axis answers, in (0, 1). Less than one would
        think, for a wall has several cells in a cone.
    edge : float
        What a cell at the edge of the cone answers, as a share of one on the axis, in [0, 1].
    p_random : float
        Probability that an echo is random, in (0, 1).
    p_no_echo : float
        Probability that the echo is lost whatever the map, in (0, 1).
    sigma_m : float
        s, standard deviation of an echo, metres, > 0.
    repeat_travel_m, repeat_turn_rad : float
        Readings of a sonar share a vote until the robot has driven or turned so far, metres and
        radians, > 0.
    max_range_m : float, optional
        z_max, metres, > 0; readings above it are taken as no echo. By default the ring's.
    """

    name: ClassVar[str]
    source: ClassVar[str]

    prior: float = 0.06
    p_hit: float = 0.2
    edge: float = 1.0
    p_random: float = 0.2
    p_no_echo: float = 0.2
    sigma_m: float = 0.05
    repeat_travel_m: float = 0.05
    repeat_turn_rad: float = math.radians(5)
    max_range_m: float | None = None

    def __post_init__(self) -> None:
        if not 0 < self.prior <= 0.5:
            raise InputError(f"prior must be in (0, 0.5], got {self.prior!r}")
        for name in ("p_hit", "p_random", "p_no_echo"):
            if not 0 < getattr(self, name) < 1:
                raise InputError(f"{name} must be in (0, 1), got {getattr(self, name)!r}")
        within("edge", self.edge, 0, 1)
        for name in ("sigma_m", "repeat_travel_m", "repeat_turn_rad"):
            positive(name, getattr(self, name))
        if self.max_range_m is not None:
            positive("max_range_m", self.max_range_m)

    def longest_reading_m(self, ring: SonarRing) -> float:
        """Return the range above which a reading is taken as no echo, metres."""
        return ring.range_max_m if self.max_range_m is None else self.max_range_m

    @property
    def prior_log_odds(self) -> float:
        """Log-odds of the prior, Thrun's l0."""
        return math.log(self.prior / (1 - self.prior))

    def factors(self, log: SonarLog, grid: GridSpec) -> ConeFactors:
        """Return the factors of the readings that may be used."""
        log = log.select(log.usable & (log.range_m >= 0))
        limit_m = self.longest_reading_m(log.ring)
        echo = log.range_m <= limit_m
        sigma_m = math.sqrt(self.sigma_m**2 + grid.resolution_m**2 / 12)
        # A no echo has no bins: all its cells are nearer than the limit.
        reading_m = np.where(echo, log.range_m, limit_m + _REACH_S * sigma_m)
        first, cell, zone, answers = self._listed(log, grid, reading_m, limit_m, sigma_m)
        middle = (np.arange(BINS) - BINS // 2) * (2 * _REACH_S / BINS)
        normal = np.exp(-(middle**2) / 2) / (math.sqrt(2 * math.pi) * sigma_m)
        return ConeFactors(
            first=first,
            cell=cell,
            zone=zone,
            answers=answers,
            floor=np.where(echo, self.p_random / limit_m, self.p_no_echo),
            scale=np.where(echo, 1 - self.p_random, 1 - self.p_no_echo),
            density=np.where(echo[:, None], normal, 0.0),
            beyond=np.where(echo, 0.0, 1.0),
            vote=shared_votes(log, self.repeat_travel_m, self.repeat_turn_rad),
        )

    def _listed(
        self,
        log: SonarLog,
        grid: GridSpec,
        reading_m: NDArray[np.float64],
        limit_m: float,
        sigma_m: float,
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int8], NDArray[np.float32]]:
        """Return the cells of each reading with their zones and h, batch by batch."""
        from sonarmap.kernels.listed_cones import ListedCones  # numba

        sensor_xy_m, axis_rad = log.sensor_xy_m, log.axis_rad
        firsts, cells = [np.zeros(1, np.int64)], [np.empty(0, np.int32)]
        zones, answers = [np.empty(0, np.int8)], [np.empty(0, np.float32)]
        width_m = 2 * _REACH_S * sigma_m / BINS
        for begin in range(0, len(log), _BATCH):
            rows = slice(begin, begin + _BATCH)
            nearest_m = reading_m[rows] - _REACH_S * sigma_m
            reach_m = np.where(reading_m[rows] > limit_m, limit_m, nearest_m + BINS * width_m)
            cones = ListedCones.on(
                grid, sensor_xy_m[rows], axis_rad[rows], log.ring.half_angle_rad, reach_m
            )
            past_m = cones.range_m - np.repeat(nearest_m, np.diff(cones.first))
            firsts.append(firsts[-1][-1] + cones.first[1:])
            cells.append(cones.cell)
            zones.append(np.clip(np.floor(past_m / width_m), -1, BINS - 1).astype(np.int8))
            weaker = (1 - self.edge) * cones.share**2
            answers.append((self.p_hit * (1 - weaker)).astype(np.float32))
        return (
            np.concatenate(firsts),
            np.concatenate(cells),
            np.concatenate(zones),
            np.concatenate(answers),
        )
