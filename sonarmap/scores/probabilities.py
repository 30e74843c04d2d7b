"""How good the probabilities of a map are: ranking, calibration, and what recalibration could win.

Cells are counted in narrow classes of their log-odds, so that the counts of many maps add up and
every number follows from them: cells whose log-odds differ by less than 0.02 count as equal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

__all__ = ["CLAMP", "ProbabilityCounts", "Reliability", "class_of", "log_loss_bits"]

CLAMP = 0.01
"""Every method's probabilities are clamped alike, or one confident error would cost infinitely
much: the worst cell scores 1 + log2(0.01) = -5.64 bits."""

# Log-odds of 1e-6, where all methods' probabilities end, are -13.8.
_WIDEST, _WIDTH = 14.0, 0.02
_CLASSES = round(2 * _WIDEST / _WIDTH)
# Naeini, Cooper and Hauskrecht, AAAI 2015, take ten bins and many after them fifteen.
RELIABILITY_BINS = 15


@dataclass(frozen=True, slots=True)
class Reliability:
    """One bin of a reliability diagram.

    Parameters
    ----------
    cells : int
        Cells in it.
    stated, true : float
        Mean of the P(occupied) that the map states for them, and share of them that is occupied.
    """

    cells: int
    stated: float
    true: float


@dataclass(frozen=True, eq=False)
class ProbabilityCounts:
    """Scored cells by their log-odds; counts of several maps add up (``a + b``).

    Parameters
    ----------
    free, occupied : ndarray of int, shape (1400,)
        Cells of each class that are free, and occupied, in truth.
    stated : ndarray, shape (1400,)
        Sum of their P(occupied).
    sheet_loss_bits : float
        Log loss of the blank sheet over the cells, bits, summed: the constant map with the room's
        own share of occupied cells, clamped. Of several rooms the sum of their sheets' losses.
    """

    CLASSES: ClassVar[int] = _CLASSES
    """How many classes there are."""

    free: NDArray[np.int64]
    occupied: NDArray[np.int64]
    stated: NDArray[np.float64]
    sheet_loss_bits: float

    @classmethod
    def of(cls, p: NDArray[np.float64], occupied: NDArray[np.bool_]) -> ProbabilityCounts:
        """Return the counts of cells with their P(occupied) and their truth, shape (n,)."""
        of_cell = class_of(p)
        return cls(
            np.bincount(of_cell[~occupied], minlength=_CLASSES),
            np.bincount(of_cell[occupied], minlength=_CLASSES),
            np.bincount(of_cell, weights=p, minlength=_CLASSES).astype(np.float64),
            _sheet_loss_bits(int(occupied.sum()), occupied.size),
        )

    def __add__(self, other: ProbabilityCounts) -> ProbabilityCounts:
        return ProbabilityCounts(
            self.free + other.free,
            self.occupied + other.occupied,
            self.stated + other.stated,
            self.sheet_loss_bits + other.sheet_loss_bits,
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ProbabilityCounts):
            return NotImplemented
        # Of cells alone: how they are parted into rooms decides on the sheets.
        return (
            np.array_equal(self.free, other.free)
            and np.array_equal(self.occupied, other.occupied)
            and np.allclose(self.stated, other.stated)
        )

    def __hash__(self) -> int:
        return hash((int(self.free.sum()), int(self.occupied.sum())))

    @property
    def precision_recall(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Precision and recall of the cells above each threshold, the strictest first."""
        hits = self.occupied[::-1].cumsum()
        marked = (self.free + self.occupied)[::-1].cumsum()
        some = marked > 0
        found = self.occupied.sum()
        recall = hits[some] / found if found else np.full(int(some.sum()), np.nan)
        return hits[some] / marked[some], recall

    @property
    def average_precision(self) -> float:
        """Area under the precision-recall curve: sum of precision times the recall it adds.

        1 if every occupied cell is more probable than every free one; the share of occupied cells
        for a constant map. NaN if no cell is occupied.
        """
        if not self.occupied.any():
            return math.nan
        precision, recall = self.precision_recall
        return float((precision * np.diff(recall, prepend=0.0)).sum())

    @property
    def reliability(self) -> tuple[Reliability, ...]:
        """The reliability diagram: 15 bins of equal count, as far as equal probabilities allow."""
        cells = self.free + self.occupied
        # A class belongs where its middle cell does.
        middle = cells.cumsum() - cells / 2
        bin_of = (middle * RELIABILITY_BINS / max(cells.sum(), 1)).astype(np.int64)
        bin_of = bin_of.clip(0, RELIABILITY_BINS - 1)
        count, hits, stated = (
            np.bincount(bin_of, weights=values, minlength=RELIABILITY_BINS)
            for values in (cells, self.occupied, self.stated)
        )
        return tuple(
            Reliability(int(n), float(s / n), float(h / n))
            for n, h, s in zip(count, hits, stated, strict=True)
            if n
        )

    @property
    def calibration_error(self) -> float:
        """Expected calibration error: mean distance of what is stated from what is true.

        Over the bins of `reliability`, weighted by their cells (Naeini et al., AAAI 2015); 0 for a
        map that is right about how sure it is, whatever it knows.
        """
        bins = self.reliability
        cells = sum(each.cells for each in bins)
        if not cells:
            return math.nan
        return sum(each.cells * abs(each.stated - each.true) for each in bins) / cells

    @property
    def recalibrated_loss_bits(self) -> float:
        """Log loss in bits, summed, after the best monotone recalibration of these very cells.

        The best non-decreasing function of P(occupied) is found by isotonic regression, clamped as
        all probabilities are. What is left is not overconfidence, but not knowing.
        """
        cells = self.free + self.occupied
        some = cells > 0
        if not some.any():
            return 0.0
        share = self.occupied[some] / cells[some]
        best = isotonic_regression(share, weights=cells[some].astype(float)).x
        return log_loss_bits(best, self.occupied[some], self.free[some])


def class_of(p: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the class of each P(occupied), 0 to 1399."""
    with np.errstate(divide="ignore"):
        log_odds = np.log(p) - np.log1p(-p)
    place = (np.clip(log_odds, -_WIDEST, _WIDEST) + _WIDEST) / _WIDTH
    classes: NDArray[np.int64] = np.minimum(place.astype(np.int64), _CLASSES - 1)
    return classes


def log_loss_bits(
    p: NDArray[np.float64], occupied: NDArray[np.int64], free: NDArray[np.int64]
) -> float:
    """Return the log loss in bits, summed over counts of cells with P(occupied), clamped."""
    clamped = p.clip(CLAMP, 1 - CLAMP)
    return float(-(occupied * np.log2(clamped) + free * np.log2(1 - clamped)).sum())


def _sheet_loss_bits(occupied: int, cells: int) -> float:
    share = np.array([occupied / cells if cells else 0.5])
    return log_loss_bits(share, np.array([occupied]), np.array([cells - occupied]))
