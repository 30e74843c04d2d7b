"""Two filters that know the truth: the ceiling above every filter that does not.

Both need a simulated log. `OracleDrop` rejects every wrong reading, `OracleMend` gives it the
range that a sonar which never loses an echo would have read, within what the ring can tell.
What is wrong is what `sonarmap.Cause` says: bounce, cross-talk, dropout.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.filters.protocol import Filtered
from sonarmap.log import Cause, LogTruth, SonarLog
from sonarmap.parameters import Space
from sonarmap.rings import SonarRing

__all__ = ["OracleDrop", "OracleMend"]


@dataclass(frozen=True)
class OracleDrop:
    """Rejects every wrong reading, by the truth."""

    name: ClassVar[str] = "oracle-drop"
    source: ClassVar[str] = "Ours: it knows the truth, and shows the ceiling of rejecting."

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with its wrong readings rejected; doubt is 1 for these, 0 for the others.

        Raises
        ------
        InputError
            If the log has no truth.
        """
        truth = log.require_truth(f"the filter {self.name!r}")
        wrong = _wrong(log, truth)
        judged = log.replace(rejected=log.rejected | wrong, doubt=_doubt(log, wrong))
        return _with_opinions(log, judged, truth)

    @classmethod
    def space(cls) -> Space:
        """Return nothing: it has no parameters."""
        return {}


@dataclass(frozen=True)
class OracleMend:
    """Mends every wrong reading to the true range in its cone, by the truth."""

    name: ClassVar[str] = "oracle-mend"
    source: ClassVar[str] = "Ours: it knows the truth, and shows the ceiling of mending."

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with its wrong readings mended; doubt is what they deserved before.

        Raises
        ------
        InputError
            If the log has no truth.
        """
        truth = log.require_truth(f"the filter {self.name!r}")
        wrong = _wrong(log, truth)
        range_m = np.where(wrong, _true_reading_m(log.ring, truth), log.range_m)
        return _with_opinions(log, log.replace(range_m=range_m, doubt=_doubt(log, wrong)), truth)

    @classmethod
    def space(cls) -> Space:
        """Return nothing: it has no parameters."""
        return {}


def _wrong(log: SonarLog, truth: LogTruth) -> NDArray[np.bool_]:
    wrong: NDArray[np.bool_] = log.usable & (truth.cause > Cause.OUT_OF_RANGE)
    return wrong


def _doubt(log: SonarLog, wrong: NDArray[np.bool_]) -> NDArray[np.float64]:
    return np.where(log.usable, wrong.astype(float), log.doubt)


def _true_reading_m(ring: SonarRing, truth: LogTruth) -> NDArray[np.float64]:
    """Return the readings of a sonar that never loses an echo: REP 117 outside of its limits."""
    nearest = truth.cone_range_m
    reading: NDArray[np.float64] = np.where(
        nearest > ring.range_max_m, np.inf, np.where(nearest < ring.range_min_m, -np.inf, nearest)
    )
    return reading


def _with_opinions(before: SonarLog, after: SonarLog, truth: LogTruth) -> Filtered:
    known = before.usable
    return Filtered(
        after,
        after.range_m != before.range_m,
        np.where(known, _true_reading_m(before.ring, truth), np.nan),
        np.where(known, truth.cause, -1),
    )
