"""What became of the readings of a log: how many were used, and why the others were not."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.log import SonarLog

__all__ = ["ReadingAccount", "account_of"]

_REASONS = ("stale", "rejected", "too close", "no echo", "too long")


@dataclass(frozen=True)
class ReadingAccount:
    """Readings of a log that were used, and the others by the first reason that holds.

    Parameters
    ----------
    readings : int
        Readings of the log.
    used : int
        Of these, used.
    unused : mapping of str to int
        The others: stale, rejected, too close, no echo, too long; only reasons that occur.
    """

    readings: int
    used: int
    unused: Mapping[str, int]

    def __str__(self) -> str:
        """One line: ``812 of 1000 readings used; not used: 150 stale, 38 no echo``."""
        line = f"{self.used} of {self.readings} readings used"
        if self.unused:
            line += "; not used: " + ", ".join(f"{n} {name}" for name, n in self.unused.items())
        return line

    def to_dict(self) -> dict[str, Any]:
        """Return the counts as JSON-able values."""
        unused = {name.replace(" ", "_"): count for name, count in self.unused.items()}
        return {"in_log": self.readings, "used": self.used, "unused": unused}


def account_of(log: SonarLog, used: NDArray[np.bool_] | None = None) -> ReadingAccount:
    """Return the account of a log's readings.

    Parameters
    ----------
    log : SonarLog
        The readings.
    used : ndarray of bool, shape (n,), optional
        Which of them were used. By default all that are neither stale, rejected nor too close,
        for what else a method leaves out only itself can tell.
    """
    too_close = log.range_m == -np.inf
    if used is None:
        used = log.usable & ~too_close
    marks = (log.stale, log.rejected, too_close, log.range_m == np.inf, np.ones(len(log), bool))
    left, unused = ~used, {}
    for name, mark in zip(_REASONS, marks, strict=True):
        count = int((left & mark).sum())
        if count:
            unused[name] = count
        left = left & ~mark
    return ReadingAccount(len(log), int(used.sum()), unused)
