"""Arcs that compete for cells: each echo has one cause, and what others saw through loses it.

A map of reflection counts ("the counting model", Haehnel 2004, Mapping with Mobile Robots,
dissertation, Freiburg: occupied = hits / (hits + misses)) needs to know which cell sent an echo; a
sonar tells only that one on an arc did. This is expectation maximisation for that question. With
p(c) the occupancy of cell c so far, A(i) the arc of echo i (cells whose range differs from it by no
more than the tolerance), b = 1 - (bearing / half-angle)^2 the strength of the beam, and u the odds
that an echo has no cause on its arc (a bounce, cross-talk)::

    o(i, c) = b(i, c) p(c) / (1 - p(c))                     exactly one cell of the arc is it
    t(i)    = sum o(i, .) / (sum o(i, .) + u)               how far echo i is believed
    q(i, c) = t(i) o(i, c) / sum o(i, .)                    expectation: its share of echo i

    hits(c)   = sum of v(i) q(i, c)
    misses(c) = sum of v(i) t(i) b(i, c) (1 - r / R) w_pass     over cones that passed through c
              + sum of v(i) (t(i) - q(i, c)) b(i, c) w_rival    over arcs that another cell won
    p(c)      = (s p0 + hits) / (s + hits + misses)         maximisation, s readings' worth of prior

in rounds from p = p0. A cone that passes through c at range r says less the nearer r is to the
ring's maximum range R, for a sonar misses more there. A no echo passes through its whole cone with
t(i) = w_none. All of this but the counting model is ours.

Repeats say nothing new: the readings that a sonar takes while the robot has hardly moved share one
vote, so v(i) = 1 / their number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, non_negative, positive, whole, within
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space, Whole
from sonarmap.rings import SonarRing

__all__ = ["ArcCompetition", "shared_votes"]

# Readings whose cones are listed at a time; bounds the working memory, not the result.
_BATCH = 500


@dataclass(frozen=True)
class ArcCompetition:
    """Arcs that compete for cells, by expectation maximisation; see the module for the equations.

    Parameters
    ----------
    rounds : int
        Rounds of expectation and maximisation, >= 1.
    prior : float
        P(occupied) of a cell that nothing is known of, p0, in (0, 0.5]. The default is the share
        of walls among the observable cells of a common room.
    prior_weight : float
        Readings that the prior is worth, s, > 0.
    tolerance_m : float
        Half of the thickness of an arc, metres, > 0.
    unexplained : float
        Odds that an echo has a cause off its arc, u, > 0.
    pass_weight, rival_weight : float
        What a pass, and an echo that another cell won, count against a cell, >= 0. A fraction of
        1: many cones pass through a wall cell's surroundings, and poses are not exact.
    no_echo_weight : float
        How far a no echo is believed, w_none, in [0, 1].
    repeat_travel_m, repeat_turn_rad : float
        Readings of a sonar share a vote until the robot has driven or turned so far, metres and
        radians, > 0.
    max_range_m : float, optional
        Readings above it are taken as no echo, metres, > 0. By default the ring's maximum range.
    occupied_from, free_up_to : float
        From where on, and up to where, a cell of the map counts as occupied or free; P of a thin
        wall rarely is high, since few of the echoes near it are its own.

    Notes
    -----
    All numbers are ours, rounded, and chosen by hand from some forty settings tried on one drive
    each (a circle of 0.8 m) in the rooms office, thesis-exp2, corridor and clutter. A comparison on
    those rooms favours these defaults; one that shall be fair tunes on others.
    """

    name: ClassVar[str] = "arc-competition"
    source: ClassVar[str] = (
        "Ours: the counting model (Haehnel 2004) with the cause of each echo found by expectation "
        "maximisation."
    )

    rounds: int = 5
    prior: float = 0.06
    prior_weight: float = 1.0
    tolerance_m: float = 0.05
    unexplained: float = 0.05
    pass_weight: float = 0.1
    rival_weight: float = 0.05
    no_echo_weight: float = 0.5
    repeat_travel_m: float = 0.05
    repeat_turn_rad: float = math.radians(5)
    max_range_m: float | None = None
    occupied_from: float = 0.2
    free_up_to: float = 0.1

    def __post_init__(self) -> None:
        object.__setattr__(self, "rounds", whole("rounds", self.rounds, least=1))
        if not 0 < self.prior <= 0.5:
            raise InputError(f"prior must be in (0, 0.5], got {self.prior!r}")
        for name in (
            "prior_weight",
            "tolerance_m",
            "unexplained",
            "repeat_travel_m",
            "repeat_turn_rad",
        ):
            positive(name, getattr(self, name))
        non_negative("pass_weight", self.pass_weight)
        non_negative("rival_weight", self.rival_weight)
        within("no_echo_weight", self.no_echo_weight, 0, 1)
        if self.max_range_m is not None:
            positive("max_range_m", self.max_range_m)
        within("occupied_from", self.occupied_from, 0, 1)
        within("free_up_to", self.free_up_to, 0, 1)
        if self.free_up_to >= self.occupied_from:
            raise InputError(
                "free_up_to must be < occupied_from, got "
                f"{self.free_up_to!r} and {self.occupied_from!r}"
            )

    def longest_reading_m(self, ring: SonarRing) -> float:
        """Return the range above which a reading is taken as no echo, metres."""
        return ring.range_max_m if self.max_range_m is None else self.max_range_m

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid; observed is what an arc or a pass touched."""
        from sonarmap.kernels.competition import compete  # numba

        log = log.select(log.usable & (log.range_m >= 0))
        limit_m = self.longest_reading_m(log.ring)
        echo = log.range_m <= limit_m
        vote = shared_votes(log, self.repeat_travel_m, self.repeat_turn_rad)
        vote = vote * np.where(echo, 1.0, self.no_echo_weight)
        first, cell, claim = self._listed(log, grid, limit_m)

        p = np.full(grid.rows * grid.cols, self.prior)
        for _ in range(self.rounds):
            hits, misses = np.zeros(p.size), np.zeros(p.size)
            compete(
                p,
                first,
                cell,
                claim,
                vote,
                echo,
                self.unexplained,
                self.rival_weight,
                self.pass_weight,
                hits,
                misses,
            )
            p = (self.prior_weight * self.prior + hits) / (self.prior_weight + hits + misses)
        observed = np.zeros(p.size, bool)
        observed[cell[claim != 0]] = True
        return OccupancyMap.from_probability(
            grid,
            p.reshape(grid.shape),
            observed.reshape(grid.shape),
            occupied_from=self.occupied_from,
            free_up_to=self.free_up_to,
        )

    def _listed(
        self, log: SonarLog, grid: GridSpec, limit_m: float
    ) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]:
        """Return the cells of each reading, and what they are to it."""
        from sonarmap.kernels.competition import claims
        from sonarmap.kernels.listed_cones import ListedCones

        sensor_xy_m, axis_rad = log.sensor_xy_m, log.axis_rad
        first, cells, all_claims = [np.zeros(1, np.int64)], [], []
        for begin in range(0, len(log), _BATCH):
            rows = slice(begin, begin + _BATCH)
            echo = log.range_m[rows] <= limit_m
            reading_m = np.where(echo, log.range_m[rows], limit_m)
            cones = ListedCones.on(
                grid,
                sensor_xy_m[rows],
                axis_rad[rows],
                log.ring.half_angle_rad,
                reading_m + np.where(echo, self.tolerance_m, 0.0),
            )
            first.append(first[-1][-1] + cones.first[1:])
            cells.append(cones.cell)
            all_claims.append(
                claims(
                    cones.first,
                    cones.range_m,
                    cones.share,
                    reading_m,
                    echo,
                    self.tolerance_m,
                    limit_m,
                )
            )
        nothing = np.empty(0, np.int32)
        return (
            np.concatenate(first),
            np.concatenate([nothing, *cells]),
            np.concatenate([nothing.astype(np.float32), *all_claims]),
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "rounds": Whole(1, 12),
            "prior": Real(0.02, 0.2, log=True),
            "prior_weight": Real(0.1, 10.0, log=True),
            "tolerance_m": Real(0.025, 0.15),
            "unexplained": Real(0.005, 2.0, log=True),
            "pass_weight": Real(0.005, 1.0, log=True),
            "rival_weight": Real(0.0, 0.5),
            "no_echo_weight": Real(0.0, 1.0),
        }


def shared_votes(log: SonarLog, travel_m: float, turn_rad: float) -> NDArray[np.float64]:
    """Return the weight of each reading, shape (n,): repeats from one place share one vote.

    The drive is cut into stretches: within each the robot has driven and turned, as shares of
    `travel_m` and `turn_rad` together, no more than 1. A sonar has one vote a stretch.
    """
    if not len(log):
        return np.empty(0)
    turned = np.diff(log.heading_rad)
    turned = np.abs((turned + math.pi) % (2 * math.pi) - math.pi)
    steps = np.hypot(np.diff(log.x_m), np.diff(log.y_m)) / travel_m + turned / turn_rad
    # The slack keeps the rounding of equal steps from deciding.
    stretch = np.floor(np.concatenate([[0.0], np.cumsum(steps)]) + 1e-9).astype(np.int64)
    _, group, size = np.unique(
        stretch * len(log.ring) + log.sonar, return_inverse=True, return_counts=True
    )
    votes: NDArray[np.float64] = 1.0 / size[group]
    return votes
