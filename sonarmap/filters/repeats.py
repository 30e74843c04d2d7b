"""Median of repeats: a reading against those of the same sonar from about the same place.

The oldest filter there is: the mean or median of three in the textbooks, the median of five in
flight-controller firmware (cleanflight, pull request 969, `rangefinder`), again and again in
drivers for ultrasonic rangers. These take the last readings of a sonar, wherever the robot was,
and put the median in place of each reading.

Ours are three additions. The window lies around a reading, not behind it, for a log is at hand
as a whole, and so the median does not lag. A repeat counts only if the robot has driven and turned
little since. And a reading may be rejected instead of replaced.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative, one_of, positive, whole
from sonarmap.filters.protocol import Filtered
from sonarmap.log import SonarLog
from sonarmap.parameters import Real, Space, Whole

__all__ = ["MedianOfRepeats"]

Action = Literal["mend", "reject"]
NoEcho = Literal["farthest", "ignore"]


@dataclass(frozen=True)
class MedianOfRepeats:
    """Replaces, or rejects, readings far from the median of their repeats.

    Parameters
    ----------
    each_side : int
        Readings of the same sonar that are looked at before and after a reading, >= 1; 2 is the
        firmware's median of five.
    tolerance_m : float
        A reading this near to the median stays as it is, metres, >= 0; 0 is the published rule,
        which replaces all.
    travel_m, turn_rad : float
        A reading is a repeat if the robot has moved and turned no more than this, metres and
        radians, > 0. Assumed.
    no_echo : {"farthest", "ignore"}
        Whether no echo is the longest of ranges, or no repeat.
    action : {"mend", "reject"}
        What becomes of a reading that is too far from the median.

    Notes
    -----
    The median is the lower one, so that it always is one of the readings, and of two that
    contradict each other the shorter, which is the more often right. A reading without any
    repeat is its own median and stays.
    """

    name: ClassVar[str] = "median-of-repeats"
    source: ClassVar[str] = (
        "Folklore; the median of five as in cleanflight's rangefinder (pull request 969), "
        "with the window and the gates ours."
    )

    each_side: int = 2
    tolerance_m: float = 0.0
    travel_m: float = 0.25
    turn_rad: float = math.radians(10)
    no_echo: NoEcho = "farthest"
    action: Action = "mend"

    def __post_init__(self) -> None:
        object.__setattr__(self, "each_side", whole("each_side", self.each_side, least=1))
        non_negative("tolerance_m", self.tolerance_m)
        positive("travel_m", self.travel_m)
        positive("turn_rad", self.turn_rad)
        one_of("no_echo", self.no_echo, get_args(NoEcho))
        one_of("action", self.action, get_args(Action))

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with the readings mended or rejected; the prediction is the median."""
        median_m = self._medians(log)
        with np.errstate(invalid="ignore"):  # inf - inf
            near = (np.abs(log.range_m - median_m) <= self.tolerance_m) | (log.range_m == median_m)
        far = ~np.isnan(median_m) & ~near
        if self.action == "reject":
            after = log.replace(rejected=log.rejected | far)
        else:
            after = log.replace(range_m=np.where(far, median_m, log.range_m))
        return Filtered(after, after.range_m != log.range_m, median_m)

    def _medians(self, log: SonarLog) -> NDArray[np.float64]:
        """Return the median around each reading, NaN where it may not be used."""
        used = log.usable
        if self.no_echo == "ignore":
            used = used & (log.range_m < np.inf)
        median_m = np.full(len(log), np.nan)
        for sonar in range(len(log.ring)):
            rows = np.flatnonzero(used & (log.sonar == sonar))
            if rows.size:
                median_m[rows] = self._medians_of_one(log.select(rows))
        return median_m

    def _medians_of_one(self, log: SonarLog) -> NDArray[np.float64]:
        """Return the median around each reading of one sonar."""
        n = len(log)
        # Column k holds the neighbour k - each_side rows on, NaN (sorted last) where there is none.
        window = np.full((n, 2 * self.each_side + 1), np.nan)
        for k, step in enumerate(range(-self.each_side, self.each_side + 1)):
            here = np.arange(max(0, -step), min(n, n - step))
            there = here + step
            moved = np.hypot(log.x_m[there] - log.x_m[here], log.y_m[there] - log.y_m[here])
            turned = np.abs(log.heading_rad[there] - log.heading_rad[here])
            turned = np.abs((turned + math.pi) % (2 * math.pi) - math.pi)
            repeat = (moved <= self.travel_m) & (turned <= self.turn_rad)
            window[here[repeat], k] = log.range_m[there[repeat]]
        count = (~np.isnan(window)).sum(axis=1)
        ranked: NDArray[np.float64] = np.sort(window, axis=1)[np.arange(n), (count - 1) // 2]
        return ranked

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "each_side": Whole(1, 5),
            "tolerance_m": Real(0.0, 0.5),
            "travel_m": Real(0.05, 1.0),
            "turn_rad": Real(math.radians(2), math.radians(45)),
        }
