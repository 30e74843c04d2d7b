"""The gamma-variance test: readings along a straight wall change evenly with the way driven.

While a robot drives straight past a flat wall, a sonar that meets it within its region of constant
depth reads a range that is linear in the way s: the slope gamma = (change of reading) / (way
driven) is the sine of the angle between path and wall. Known from a public implementation of a
sonar-based localiser, read as a specification (its numbers are the defaults): a buffer of 10
readings, a new one only after 5 cm of way, begun anew when the heading has changed by more than
0.174 rad; slopes between neighbours in the buffer; accepted when their sample variance passes a
chi-squared test against what sigma_r = 15 mm of range and an error of the way growing with its root
(factor 0.05) explain; a reading belongs to the wall if innovation^2 / variance < 15::

    gamma_j = (R_{j+1} - R_j) / d_j,   d_j = s_{j+1} - s_j,   j = 1 ... n
    var_j   = (2 sigma_r^2 + gamma_mean^2 k^2 |d_j|) / d_j^2
    accept    if (n - 1) sample_variance(gamma) / mean(var) <= chi2(1 - alpha, n - 1),  n >= 4

Ours, for it filters readings here and does not localise:

* The way is the robot's displacement along its heading at the begin of the straight run.
* A buffer that fails is tried again without each one of its readings, and kept without the one
  that lets it fail least, if that passes: one wrong reading does not hide a wall.
* A line R = a + gamma s is fitted to each accepted buffer, and every reading of that sonar while
  the buffer lasted, too close ones apart, is judged by the gate of 15: right if it is near any such
  line, wrong if near none. What no accepted buffer covers (turns, clutter) gets no opinion.
* Doubt is the probability that the reading is not of the line, by the normal density of its
  innovation against an even density over the ring's range, `wrong_share` of all readings being
  wrong beforehand.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from sonarmap.errors import InputError, non_negative, one_of, positive, whole
from sonarmap.filters.protocol import Filtered
from sonarmap.log import Cause, SonarLog
from sonarmap.parameters import Real, Space, Whole

__all__ = ["GammaVariance"]

Action = Literal["mend", "reject"]


@dataclass(frozen=True, slots=True)
class _Line:
    """A line R = mean_m + gamma (s - way_m), and how sure it is."""

    mean_m: float
    gamma: float
    way_m: float
    count: int
    spread: float

    @classmethod
    def through(cls, s: NDArray[np.float64], r: NDArray[np.float64]) -> _Line:
        """Return the least-squares line."""
        way, mean = float(s.mean()), float(r.mean())
        spread = float(((s - way) ** 2).sum())
        return cls(mean, float(((s - way) * (r - mean)).sum()) / spread, way, s.size, spread)

    def at(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the ranges on the line."""
        on_line: NDArray[np.float64] = self.mean_m + self.gamma * (s - self.way_m)
        return on_line

    def variance(self, s: NDArray[np.float64], sigma_m: float) -> NDArray[np.float64]:
        """Return the variance of a reading's distance from the line."""
        leverage = 1 / self.count + (s - self.way_m) ** 2 / self.spread
        wide: NDArray[np.float64] = sigma_m**2 * (1 + leverage)
        return wide


@dataclass(frozen=True)
class GammaVariance:
    """Judges readings along straight walls by the evenness of their slope; see the module.

    Parameters
    ----------
    buffer : int
        Readings of a buffer, >= least_slopes + 1.
    least_slopes : int
        Slopes that a test needs, >= 2.
    step_m : float
        Way after which a new reading enters the buffer, metres, > 0.
    turn_rad : float
        Change of heading that begins a new buffer, radians, > 0.
    alpha : float
        Share of even slopes that the test refuses, in (0, 1).
    sigma_m : float
        Standard deviation of a reading, metres, > 0.
    way_factor : float
        Standard deviation of a way is this times its root, in roots of metres, >= 0.
    gate : float
        A reading belongs to a line up to this innovation^2 / variance, > 0.
    wrong_share : float
        Share of wrong readings to begin with, in (0, 1).
    action : {"mend", "reject"}
        What becomes of a wrong reading: the line's range, or rejection.
    """

    name: ClassVar[str] = "gamma-variance"
    source: ClassVar[str] = (
        "A public sonar localiser's test of the slope along straight walls, by its description; "
        "the verdict on single readings ours."
    )

    buffer: int = 10
    least_slopes: int = 4
    step_m: float = 0.05
    turn_rad: float = 0.174
    alpha: float = 0.5
    sigma_m: float = 0.015
    way_factor: float = 0.05
    gate: float = 15.0
    wrong_share: float = 0.2
    action: Action = "reject"

    def __post_init__(self) -> None:
        least = whole("least_slopes", self.least_slopes, least=2)
        object.__setattr__(self, "least_slopes", least)
        object.__setattr__(self, "buffer", whole("buffer", self.buffer, least=least + 1))
        for name in ("step_m", "turn_rad", "sigma_m", "gate"):
            positive(name, getattr(self, name))
        non_negative("way_factor", self.way_factor)
        for name in ("alpha", "wrong_share"):
            if not 0 < getattr(self, name) < 1:
                raise InputError(f"{name} must be in (0, 1), got {getattr(self, name)!r}")
        one_of("action", self.action, get_args(Action))

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with wrong readings rejected or mended, and its doubts."""
        near, line_m, doubt = self._judged(log)
        wrong = ~np.isnan(line_m) & ~near
        cause = np.full(len(log), -1)
        cause[wrong & (log.range_m > line_m)] = Cause.BOUNCE
        cause[wrong & np.isposinf(log.range_m)] = Cause.DROPOUT
        after = log.replace(doubt=np.where(np.isnan(doubt), log.doubt, doubt))
        if self.action == "reject":
            after = after.replace(rejected=log.rejected | wrong)
        else:
            after = after.replace(range_m=np.where(wrong, line_m, log.range_m))
        return Filtered(after, after.range_m != log.range_m, line_m, cause)

    def _judged(
        self, log: SonarLog
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64], NDArray[np.float64]]:
        """Return which readings are near a line, their ranges on the nearest one, and doubts."""
        nearest = np.full(len(log), np.inf)
        line_m, doubt = np.full(len(log), np.nan), np.full(len(log), np.nan)
        for sonar in range(len(log.ring)):
            rows = np.flatnonzero(log.usable & (log.sonar == sonar) & (log.range_m >= 0))
            one = log.select(rows)
            for run, s in self._straight_runs(one):
                for first, last, line in self._lines(one.range_m[run], s, one.ring.range_max_m):
                    span = slice(first, last + 1)
                    at = rows[run[span]]
                    expected = line.at(s[span])
                    variance = line.variance(s[span], self.sigma_m)
                    ratio = (log.range_m[at] - expected) ** 2 / variance
                    # Written the first time whatever the ratio: a no echo's is infinite.
                    better = (ratio < nearest[at]) | np.isnan(line_m[at])
                    at, ratio = at[better], ratio[better]
                    nearest[at] = ratio
                    line_m[at] = np.clip(expected[better], 0, log.ring.range_max_m)
                    doubt[at] = self._doubt(ratio, variance[better], log.ring.range_max_m)
        return nearest <= self.gate, line_m, doubt

    def _straight_runs(
        self, log: SonarLog
    ) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
        """Yield the rows of each straight run of a sonar, and the way along its heading."""
        begin = 0
        while begin < len(log):
            heading = log.heading_rad[begin]
            turned = np.abs((log.heading_rad[begin:] - heading + math.pi) % (2 * math.pi) - math.pi)
            beyond = turned > self.turn_rad
            end = begin + int(beyond.argmax()) if beyond.any() else len(log)
            rows = np.arange(begin, end)
            dx, dy = log.x_m[rows] - log.x_m[begin], log.y_m[rows] - log.y_m[begin]
            yield rows, math.cos(heading) * dx + math.sin(heading) * dy
            begin = end

    def _lines(
        self, r: NDArray[np.float64], s: NDArray[np.float64], limit_m: float
    ) -> Iterator[tuple[int, int, _Line]]:
        """Yield the first and last reading of each accepted buffer of a run, with its line."""
        entered: list[int] = []
        for k in range(r.size):
            if r[k] <= limit_m and (not entered or abs(s[k] - s[entered[-1]]) >= self.step_m):
                entered.append(k)
        size = min(self.buffer, len(entered))
        if size <= self.least_slopes:
            return
        for begin in range(len(entered) - size + 1):
            members = np.array(entered[begin : begin + size])
            kept = self._accepted(members, r, s)
            if kept is not None:
                yield int(members[0]), int(members[-1]), _Line.through(s[kept], r[kept])

    def _accepted(
        self, members: NDArray[np.int64], r: NDArray[np.float64], s: NDArray[np.float64]
    ) -> NDArray[np.int64] | None:
        """Return the members that pass the test together: all, all but one, or None."""
        if self._excess(r[members], s[members]) <= 1:
            return members
        if members.size <= self.least_slopes + 1:
            return None
        without = [np.delete(members, k) for k in range(members.size)]
        excess = [self._excess(r[each], s[each]) for each in without]
        best = int(np.argmin(excess))
        return without[best] if excess[best] <= 1 else None

    def _excess(self, r: NDArray[np.float64], s: NDArray[np.float64]) -> float:
        """Return the test's statistic over its limit."""
        d = np.diff(s)
        if (d == 0).any():  # two members at one place, once the one between is left out
            return math.inf
        gamma = np.diff(r) / d
        explained = (2 * self.sigma_m**2 + (gamma.mean() * self.way_factor) ** 2 * np.abs(d)) / d**2
        freedom = gamma.size - 1
        statistic = freedom * gamma.var(ddof=1) / explained.mean()
        return float(statistic / chdtri(freedom, self.alpha))

    def _doubt(
        self, ratio: NDArray[np.float64], variance: NDArray[np.float64], range_max_m: float
    ) -> NDArray[np.float64]:
        """Return P(wrong) of readings by how far they are from a line."""
        right = (1 - self.wrong_share) * np.exp(-ratio / 2) / np.sqrt(2 * math.pi * variance)
        wrong = self.wrong_share / range_max_m
        doubts: NDArray[np.float64] = wrong / (wrong + right)
        return doubts

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "buffer": Whole(5, 20),
            "step_m": Real(0.02, 0.2),
            "alpha": Real(0.001, 0.9, log=True),
            "sigma_m": Real(0.005, 0.05, log=True),
            "way_factor": Real(0.0, 0.2),
            "gate": Real(4.0, 100.0, log=True),
        }
