"""Means and correlations with the interval that goes with them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats

__all__ = ["Estimate", "mean_of", "rank_correlation"]

LEVEL = 0.95


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its 95 % interval; the interval is NaN when there is none.

    Parameters
    ----------
    value, low, high : float
        The number and the ends of its interval.
    left_out : int
        Values that it does not count, for they are not defined: NaN or infinite.
    """

    value: float
    low: float
    high: float
    left_out: int = 0

    def __str__(self) -> str:
        return self.text()

    def text(self, digits: int = 3, unit: str = "", *, factor: float = 1.0) -> str:
        """Return the number with its interval, as ``0.123 (0.101 to 0.145) unit``."""
        value, low, high = (
            f"{number * factor:.{digits}f}" for number in (self.value, self.low, self.high)
        )
        interval = "" if math.isnan(self.low) else f" ({low} to {high})"
        without = f", {self.left_out} undefined left out" if self.left_out else ""
        return f"{value}{interval} {unit}".strip() + without

    @property
    def sign(self) -> int:
        """-1 or 1 when the whole interval lies on that side of 0, else 0: not decided."""
        if self.low > 0:
            return 1
        return -1 if self.high < 0 else 0


def mean_of(values: Sequence[float] | ArrayLike) -> Estimate:
    """Return the mean of independent values (such as one a seed) with Student's interval.

    Values that are not finite do not count, and the estimate says how many these are.
    """
    given = np.asarray(values, float)
    numbers = given[np.isfinite(given)]
    left_out = given.size - numbers.size
    if numbers.size == 0:
        return Estimate(math.nan, math.nan, math.nan, left_out)
    mean = float(numbers.mean())
    if numbers.size == 1:
        return Estimate(mean, math.nan, math.nan, left_out)
    half = float(
        stats.t.ppf(0.5 + LEVEL / 2, numbers.size - 1)
        * numbers.std(ddof=1)
        / math.sqrt(numbers.size)
    )
    return Estimate(mean, mean - half, mean + half, left_out)


def rank_correlation(x: ArrayLike, y: ArrayLike) -> float:
    """Return Spearman's rank correlation of two measures over the same sets; 0 if one is flat."""
    a, b = np.asarray(x, float), np.asarray(y, float)
    both = np.isfinite(a) & np.isfinite(b)
    a, b = a[both], b[both]
    if a.size < 3 or np.ptp(a) == 0 or np.ptp(b) == 0:
        return 0.0
    return float(stats.spearmanr(a, b).statistic)
