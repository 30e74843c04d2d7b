"""What became of the readings of a log, and in how many of its scans the robot touched something.

Of the readings: how many were used, and why the others were not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.log import SonarLog

__all__ = ["ContactAccount", "ReadingAccount", "account_by", "account_of", "contacts_of"]

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

    def __add__(self, other: ReadingAccount) -> ReadingAccount:
        """Return the account of both logs together."""
        unused = {
            name: self.unused.get(name, 0) + other.unused.get(name, 0)
            for name in _REASONS
            if name in self.unused or name in other.unused
        }
        return ReadingAccount(self.readings + other.readings, self.used + other.used, unused)


@dataclass(frozen=True)
class ContactAccount:
    """In how much of a drive the robot touched something.

    Parameters
    ----------
    touched : int
        Scans, or packets, in which it did.
    of : int
        How many there are.
    unit : {"scans", "packets"}
        What the log consists of.
    """

    touched: int
    of: int
    unit: str

    def __str__(self) -> str:
        """Return a sentence for people; an empty one if nothing was touched."""
        if not self.touched:
            return ""
        return (
            f"In {self.touched} {self.unit} the robot touched something "
            f"({self.share:.1%} of the drive): odometry is off."
        )

    @property
    def share(self) -> float:
        """Share of the drive in which it touched something."""
        return self.touched / self.of if self.of else 0.0

    def to_dict(self) -> dict[str, Any]:
        """Return the counts as JSON-able values."""
        return {f"collision_{self.unit}": self.touched, "collision_share": self.share}

    def __add__(self, other: ContactAccount) -> ContactAccount:
        """Return the account of both drives together."""
        return ContactAccount(self.touched + other.touched, self.of + other.of, self.unit)


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


def account_by(log: SonarLog, method: object) -> ReadingAccount:
    """Return the account of a log's readings by what a mapping method uses, if it tells."""
    uses = getattr(method, "uses", None)
    return account_of(log, None if uses is None else uses(log))


def contacts_of(log: SonarLog) -> ContactAccount | None:
    """Return in how many scans of a simulated log the robot touched something.

    Of a log of status packets, which repeat old values, the packets that bring a new one count.
    None for the log of a real robot: it does not tell.
    """
    if log.truth is None:
        return None
    touched = np.unique(log.scan[log.truth.collision & ~log.stale]).size
    unit = "packets" if log.provenance.get("packets") else "scans"
    return ContactAccount(int(touched), int(np.unique(log.scan).size), unit)
