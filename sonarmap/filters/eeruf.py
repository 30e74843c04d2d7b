"""EERUF's test: the comparison of consecutive readings, which finds most cross-talk."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative
from sonarmap.filters.protocol import Filtered
from sonarmap.log import SonarLog
from sonarmap.parameters import Real, Space

__all__ = ["EerufTest", "eeruf_accepts"]

# Assumed: twice what a robot at 0.25 m/s drives in a scan of 100 ms, and far below the jumps.
TOLERANCE_M = 0.05


@dataclass(frozen=True)
class EerufTest:
    """Rejects readings that agree with neither neighbour in time, see `eeruf_accepts`.

    Parameters
    ----------
    tolerance_m : float
        Ranges that differ by no more agree, metres, >= 0.
    """

    name: ClassVar[str] = "eeruf"
    source: ClassVar[str] = (
        "Borenstein and Koren, Error Eliminating Rapid Ultrasonic Firing for Mobile Robot Obstacle "
        "Avoidance, IEEE Transactions on Robotics and Automation 11(1), 1995, section III."
    )

    tolerance_m: float = TOLERANCE_M

    def __post_init__(self) -> None:
        non_negative("tolerance_m", self.tolerance_m)

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with the readings rejected that are not accepted."""
        rejected = log.rejected | ~eeruf_accepts(log, self.tolerance_m)
        return Filtered(log.replace(rejected=rejected), np.zeros(len(log), bool))

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {"tolerance_m": Real(0.005, 0.3)}


def eeruf_accepts(log: SonarLog, tolerance_m: float = TOLERANCE_M) -> NDArray[np.bool_]:
    """Return which readings agree with the one before or after of the same sonar.

    Sonars that fire with alternating delays hear their own echoes at the same range again, but
    each other's sound at a range that jumps from scan to scan. Borenstein and Koren, "Error
    Eliminating Rapid Ultrasonic Firing for Mobile Robot Obstacle Avoidance", IEEE Transactions
    on Robotics and Automation 11(1), 1995, section III.

    Parameters
    ----------
    log : SonarLog
        Fired with alternating delays, as `sim.Eeruf`.
    tolerance_m : float
        Ranges that differ by no more agree, metres, >= 0.

    Returns
    -------
    ndarray of bool, shape (n,)
        Both readings of an agreeing pair are accepted, and two that agree on no echo or on too
        close as well. A stale reading is accepted as the reading that it repeats; one that was
        rejected before is not, and is nobody's neighbour.
    """
    non_negative("tolerance_m", tolerance_m)
    fresh = np.flatnonzero(log.usable)
    # Rows by sonar, in order of firing within each: neighbours are consecutive readings.
    order = fresh[np.argsort(log.sonar[fresh], kind="stable")]
    sonar, range_m = log.sonar[order], log.range_m[order]
    with np.errstate(invalid="ignore"):  # inf - inf
        near = np.abs(np.diff(range_m)) <= tolerance_m
    agree = (near | (range_m[1:] == range_m[:-1])) & (sonar[1:] == sonar[:-1])
    accepted = np.zeros(len(log), bool)
    accepted[order[1:]] |= agree
    accepted[order[:-1]] |= agree
    if log.stale.any():
        accepted = _as_repeated(accepted, log)
    return accepted & ~log.rejected


def _as_repeated(accepted: NDArray[np.bool_], log: SonarLog) -> NDArray[np.bool_]:
    """Return `accepted` with each stale row as the last fresh row of its sonar."""
    result = accepted.copy()
    for sonar in range(len(log.ring)):
        rows = np.flatnonzero(log.sonar == sonar)
        last = np.maximum.accumulate(np.where(log.stale[rows], -1, np.arange(rows.size)))
        known = last >= 0
        result[rows[known]] = accepted[rows[last[known]]]
    return result
