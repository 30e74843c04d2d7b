"""Consistency with the learned map: how likely each reading is wrong, why, and what it should be.

The whole log is mapped by the learned mapper. Rays through that map, over the cone of each reading,
tell how likely the sound could get as far as it read, and where it should have turned; a small
network, trained like the mapper, makes of this the probability of each cause, and of each of some
predicted ranges that it is right (`sonarmap.learned.readings`).

A wrong reading leaves marks in the map too, but only its own: many others, from other places, speak
against it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, one_of, within
from sonarmap.filters.protocol import Filtered
from sonarmap.grid import GridSpec
from sonarmap.learned.growing import joined
from sonarmap.log import SonarLog
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space
from sonarmap.rings import SonarRing

if TYPE_CHECKING:
    from sonarmap.methods.learned import Learned

__all__ = ["CausalConsistency", "Consistency", "ConsistencyReport"]

Mode = Literal["doubt", "reject", "mend"]


@dataclass(frozen=True, eq=False)
class ConsistencyReport:
    """What the filter did.

    Parameters
    ----------
    threshold : float
        Readings of at least this doubt were rejected or mended.
    confidence : ndarray, shape (n,)
        Probability that the predicted range is within 10 cm of the truth; NaN where none is.
    """

    threshold: float
    confidence: NDArray[np.float64]


@dataclass(frozen=True)
class Consistency:
    """Doubts, rejects or mends readings by the learned map of their log.

    Parameters
    ----------
    mode : {"doubt", "reject", "mend"}
        What becomes of a reading whose doubt is at least the threshold: nothing, it is rejected,
        or it gets the predicted range if that is sure enough, and else is rejected. All readings
        have their doubt in any case.
    lost_share : float
        Share of the right readings that one is willing to lose, in [0.0003, 0.2]: decides the
        threshold, as it was on rooms that the filter was not fitted to.
    least_confidence : float
        How sure the predicted range must be, in [0, 1]: the probability that it is within 10 cm of
        the truth. For mending only.
    weights : str, optional
        File of other weights, see `sonarmap.methods.learned.Learned`.

    Notes
    -----
    Stale, rejected and too close readings are not judged: they keep their doubt, and have no
    prediction.
    """

    name: ClassVar[str] = "consistency"
    source: ClassVar[str] = (
        "Ours: survival along the cone in the learned map, judged by a small trained network."
    )

    mode: Mode = "reject"
    lost_share: float = 0.01
    least_confidence: float = 0.5
    weights: str | None = None

    def __post_init__(self) -> None:
        one_of("mode", self.mode, get_args(Mode))
        within("lost_share", self.lost_share, 0.0003, 0.2)
        within("least_confidence", self.least_confidence, 0, 1)
        if self.weights is not None and not isinstance(self.weights, str):
            raise InputError(f"weights must be the path of a file, got {self.weights!r}")

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with doubts, and with readings rejected or mended as the mode says.

        What is mended is marked in `Filtered.changed`. The report is a `ConsistencyReport`.

        Raises
        ------
        InputError
            If the weights cannot be read or have no judge of readings.
        """
        from sonarmap.mapping import grid_over

        judged = log.usable & (log.range_m >= 0)
        if not judged.any():
            return self.by_map(log, None)
        of = log.select(judged)
        return self.by_map(log, self._mapper.map(of, grid_over(of)))

    def begin(self, ring: SonarRing, grid: GridSpec) -> CausalConsistency:
        """Return a filter that takes readings one at a time, and judges by the map of the past."""
        return CausalConsistency(self, ring, grid)

    def by_map(self, log: SonarLog, m: OccupancyMap | None) -> Filtered:
        """Return what `apply` does, by a learned map that is at hand; None if none is judged."""
        from sonarmap.learned.readings import FEATURES, judge
        from sonarmap.learned.weights import shipped

        weights = shipped(self.weights)
        if "threshold" not in weights.reading:
            raise InputError(f"{self.weights}: the weights judge no readings")
        if weights.reading["mean"].size != len(FEATURES):
            raise InputError(
                f"{self.weights}: the judge of readings must have {len(FEATURES)} features, got "
                f"{weights.reading['mean'].size}: the weights are of another version"
            )
        threshold = float(
            np.interp(self.lost_share, weights.reading["lost_share"], weights.reading["threshold"])
        )
        n = len(log)
        judged = log.usable & (log.range_m >= 0)
        doubt, predicted_m = log.doubt.copy(), np.full(n, np.nan)
        confidence, cause = np.full(n, np.nan), np.full(n, -1, np.int8)
        if m is not None and judged.any():
            said = judge(weights.reading, log.select(judged), m)
            doubt[judged], predicted_m[judged] = said.doubt, said.predicted_m
            confidence[judged] = said.confidence
            cause[judged] = said.causes.argmax(axis=1)
        wrong = judged & (doubt >= threshold)
        range_m, rejected = log.range_m, log.rejected
        if self.mode == "mend":
            sure = wrong & (confidence >= self.least_confidence)
            range_m = np.where(sure, predicted_m, range_m)
            rejected = rejected | (wrong & ~sure)
        elif self.mode == "reject":
            rejected = rejected | wrong
        after = log.replace(range_m=range_m, rejected=rejected, doubt=doubt)
        report = ConsistencyReport(threshold, confidence)
        return Filtered(after, range_m != log.range_m, predicted_m, cause, report)

    @property
    def _mapper(self) -> Learned:
        from sonarmap.methods.learned import Learned

        return Learned(self.weights)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {"lost_share": Real(0.0003, 0.2, log=True)}


class CausalConsistency:
    """Judges readings as they come, by the learned map of those before them.

    Parameters
    ----------
    method : Consistency
        The filter.
    ring, grid
        The sonars, and the cells of its map.
    """

    def __init__(self, method: Consistency, ring: SonarRing, grid: GridSpec) -> None:
        self._method = method
        self._map = method._mapper.begin(ring, grid)
        self._before: SonarLog | None = None

    def add(self, readings: SonarLog) -> Filtered:
        """Return what the filter makes of new readings; then they are part of the past.

        What comes next of a sonar is not known: each is judged as the last one of a log is.
        """
        before = self._before
        both = readings if before is None else joined([before, readings])
        made = self._method.by_map(both, self._map.map)
        self._map.add(readings)
        # The newest reading of each sonar is what the next ones are compared with.
        newest = {int(number): row for row, number in enumerate(both.sonar)}
        self._before = both.select(np.array(sorted(newest.values()), dtype=int))
        rows = np.arange(0 if before is None else len(before), len(both))
        report: ConsistencyReport = made.report
        predicted_m, cause = made.predicted_range_m, made.likely_cause
        assert predicted_m is not None
        assert cause is not None
        return Filtered(
            made.log.select(rows),
            made.changed[rows],
            predicted_m[rows],
            cause[rows],
            ConsistencyReport(report.threshold, report.confidence[rows]),
        )
