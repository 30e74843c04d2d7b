"""Stale marking: readings that a log repeats although the sonar has not fired again."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.filters.protocol import Filtered
from sonarmap.log import SonarLog
from sonarmap.parameters import Space

__all__ = ["MarkStale", "mark_stale"]


@dataclass(frozen=True)
class MarkStale:
    """Marks exact repeats of a sonar's reading as stale, see `mark_stale`."""

    name: ClassVar[str] = "stale"
    source: ClassVar[str] = "Ours: robots log values again that were measured rows ago."

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with its repeats marked; it changes and rejects nothing."""
        return Filtered(mark_stale(log), np.zeros(len(log), bool))

    @classmethod
    def space(cls) -> Space:
        """Return nothing: it has no parameters."""
        return {}


def mark_stale(log: SonarLog) -> SonarLog:
    """Return the log with each exact repeat of a sonar's reading marked as stale.

    Robots log all their sonars at a time while these fire in turn, so a row holds values that
    were measured rows ago. Counted again, one echo is taken for many. The first reading of a run
    of equal ones stays fresh; a repeated no echo is a repeat too. Readings that were stale before
    stay so.

    Parameters
    ----------
    log : SonarLog
        Any log; truth and all other columns stay as they are.

    Returns
    -------
    SonarLog
        `build_map` leaves its stale readings out.

    Notes
    -----
    Values are all that is looked at, so the mark is a guess: a robot that stands still, or drives
    along a smooth wall, truly measures the same again and again, the more so the coarser the
    steps of its ranges, and a sonar that hears nothing for long is left with one reading. What is
    lost is little (the same evidence from much the same place), and what is gained is that no
    evidence counts twice. Simulated logs have no stale values and do not need this.
    """
    # Rows by sonar, in order of firing within each: a repeat equals its left neighbour.
    order = np.argsort(log.sonar, kind="stable")
    sonar, range_m = log.sonar[order], log.range_m[order]
    repeats = np.zeros(len(log), bool)
    repeats[order[1:]] = (sonar[1:] == sonar[:-1]) & (range_m[1:] == range_m[:-1])
    return log.replace(stale=log.stale | repeats)
