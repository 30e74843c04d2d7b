"""What a filter did to a log, judged reading by reading by the truth.

Two truths are asked: the nearest surface in the cone, which is what a sonar that never loses an
echo would read, and the first surface on the axis, where mapping believes the echo to be.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from sonarmap.errors import InputError, first_row, one_of
from sonarmap.filters.protocol import Filtered
from sonarmap.log import Cause, SonarLog

__all__ = ["Against", "Beyond", "Group", "RangeErrors", "ReadingScore", "When", "score_readings"]

Group = Literal["all", "wrong", "right"]
When = Literal["before", "after"]
Against = Literal["cone", "axis"]

# Errors of a tenth of a metre and more show in a map of 5 or 10 cm cells; 0.3 m is a robot's
# length.
BEYOND_M = (0.1, 0.3)
# An updated reading is near to a truth up to here.
NEAR_M = 0.1
# What a filter that rejects by its doubt may cost: one right reading in a hundred.
LOST_SHARE = 0.01
# Forgives the rounding of an error that equals a limit.
_SLACK_M = 1e-9


@dataclass(frozen=True, slots=True)
class Beyond:
    """Readings whose error is larger than a limit.

    Parameters
    ----------
    limit_m : float
        The limit, metres.
    too_long, too_short : int
        Readings that are more than that above, or below, the truth.
    """

    limit_m: float
    too_long: int
    too_short: int


@dataclass(frozen=True, slots=True)
class RangeErrors:
    """The errors of a number of readings against one truth.

    Parameters
    ----------
    readings : int
        Number of readings.
    median_m, p95_m : float
        Median and 95th percentile of the absolute error, metres; NaN for no reading.
    beyond : tuple of Beyond
        Beyond 0.1 m and 0.3 m.
    """

    readings: int
    median_m: float
    p95_m: float
    beyond: tuple[Beyond, ...]

    @classmethod
    def of(cls, error_m: NDArray[np.float64]) -> RangeErrors:
        """Return the summary of signed errors, metres (reading less truth), shape (n,)."""
        size = np.abs(error_m)
        median_m, p95_m = np.percentile(size, [50, 95]).tolist() if size.size else (math.nan,) * 2
        beyond = tuple(
            Beyond(
                limit_m,
                int((error_m > limit_m + _SLACK_M).sum()),
                int((error_m < -limit_m - _SLACK_M).sum()),
            )
            for limit_m in BEYOND_M
        )
        return cls(int(size.size), median_m, p95_m, beyond)

    def to_dict(self) -> dict[str, Any]:
        """Return the summary as JSON-able values; None for what is not defined."""
        shares = [
            {
                **asdict(beyond),
                "share": _defined(_ratio(beyond.too_long + beyond.too_short, self.readings)),
                "share_too_long": _defined(_ratio(beyond.too_long, self.readings)),
                "share_too_short": _defined(_ratio(beyond.too_short, self.readings)),
            }
            for beyond in self.beyond
        ]
        return {
            "readings": self.readings,
            "median_m": _defined(self.median_m),
            "p95_m": _defined(self.p95_m),
            "beyond": shares,
        }


@dataclass(frozen=True, eq=False)
class ReadingScore:
    """The judged readings, one row each; every number follows from them.

    Two scores add up (``a + b``): the sum is the score of the readings of both.

    Parameters
    ----------
    cause : ndarray of int, shape (n,)
        A `Cause` each: why the reading was what it was before.
    updated : ndarray of bool, shape (n,)
        Which readings were changed.
    cone_before_m, cone_after_m, axis_before_m, axis_after_m : ndarray, shape (n,)
        Reading less truth, metres: against the nearest surface in the cone and against the first
        on the axis, before and after.
    rejected : ndarray of bool, shape (n,), optional
        Which readings were rejected. None: no reading was.
    doubt : ndarray, shape (n,), optional
        Probability that a reading is wrong, by the filter; NaN for no opinion, the default.
    """

    cause: NDArray[np.int8]
    updated: NDArray[np.bool_]
    cone_before_m: NDArray[np.float64]
    cone_after_m: NDArray[np.float64]
    axis_before_m: NDArray[np.float64]
    axis_after_m: NDArray[np.float64]
    rejected: NDArray[np.bool_] = None  # type: ignore[assignment]  # filled below
    doubt: NDArray[np.float64] = None  # type: ignore[assignment]  # filled below

    def __post_init__(self) -> None:
        for name, unmarked in (("rejected", False), ("doubt", math.nan)):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.full(np.size(self.cause), unmarked))
        for name in self.__dataclass_fields__:
            column = np.array(getattr(self, name))
            column.flags.writeable = False
            object.__setattr__(self, name, column)

    def __len__(self) -> int:
        return int(self.cause.size)

    def __add__(self, other: ReadingScore) -> ReadingScore:
        return ReadingScore(
            **{
                name: np.concatenate([getattr(self, name), getattr(other, name)])
                for name in self.__dataclass_fields__
            }
        )

    @property
    def is_wrong(self) -> NDArray[np.bool_]:
        """Which readings were wrong before: bounce, cross-talk, dropout."""
        wrong: NDArray[np.bool_] = self.cause > Cause.OUT_OF_RANGE
        return wrong

    @property
    def is_mended(self) -> NDArray[np.bool_]:
        """Which wrong readings were updated and are now within 0.1 m of either truth."""
        return self.is_wrong & self.updated & self._near

    @property
    def is_spoiled(self) -> NDArray[np.bool_]:
        """Which right readings were updated and are now farther than 0.1 m from both truths."""
        return ~self.is_wrong & self.updated & ~self._near

    @property
    def wrong(self) -> int:
        """Number of wrong readings."""
        return int(self.is_wrong.sum())

    @property
    def right(self) -> int:
        """Number of right readings: direct, off axis, out of range."""
        return len(self) - self.wrong

    @property
    def wrong_updated(self) -> int:
        """Number of wrong readings that were updated: hits."""
        return int((self.is_wrong & self.updated).sum())

    @property
    def right_updated(self) -> int:
        """Number of right readings that were updated: false alarms."""
        return int((~self.is_wrong & self.updated).sum())

    @property
    def mended(self) -> int:
        """Number of wrong readings that were mended."""
        return int(self.is_mended.sum())

    @property
    def spoiled(self) -> int:
        """Number of right readings that were spoiled."""
        return int(self.is_spoiled.sum())

    @property
    def caught(self) -> int:
        """Number of wrong readings that were rejected."""
        return int((self.is_wrong & self.rejected).sum())

    @property
    def lost(self) -> int:
        """Number of right readings that were rejected."""
        return int((~self.is_wrong & self.rejected).sum())

    @property
    def caught_share(self) -> float:
        """Share of the wrong readings that were rejected; NaN if none was wrong."""
        return _ratio(self.caught, self.wrong)

    @property
    def lost_share(self) -> float:
        """Share of the right readings that were rejected; NaN if none was right."""
        return _ratio(self.lost, self.right)

    @property
    def roc_auc(self) -> float:
        """Area under the ROC curve of the doubt over the readings that have one.

        The probability that a wrong reading is doubted more than a right one, equal doubts
        counting half (Mann and Whitney's statistic); NaN unless both kinds are there.
        """
        doubt, wrong = self._doubted
        positives, negatives = int(wrong.sum()), int((~wrong).sum())
        if not positives or not negatives:
            return math.nan
        ranks = rankdata(doubt)
        above = ranks[wrong].sum() - positives * (positives + 1) / 2
        return float(above / (positives * negatives))

    @property
    def caught_at_lost_1_percent(self) -> float:
        """Share of the wrong readings caught by the lowest threshold of doubt that is allowed.

        A reading is caught, or lost, when its doubt is at least the threshold; at most 1 % of the
        right readings may be lost. Over the readings that have a doubt; NaN unless both kinds are
        there.
        """
        doubt, wrong = self._doubted
        if not wrong.any() or wrong.all():
            return math.nan
        right = np.sort(doubt[~wrong])[::-1]
        allowed = int(LOST_SHARE * right.size + _SLACK_M)
        # All above the first right reading that may not be lost.
        return float((doubt[wrong] > right[allowed]).mean())

    @property
    def _doubted(self) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        known = ~np.isnan(self.doubt)
        return self.doubt[known], self.is_wrong[known]

    @property
    def precision(self) -> float:
        """Share of the updated readings that were wrong; NaN if none was updated."""
        return _ratio(self.wrong_updated, self.wrong_updated + self.right_updated)

    @property
    def recall(self) -> float:
        """Share of the wrong readings that were updated; NaN if none was wrong."""
        return _ratio(self.wrong_updated, self.wrong)

    @property
    def mended_share(self) -> float:
        """Share of the wrong readings that were mended; NaN if none was wrong."""
        return _ratio(self.mended, self.wrong)

    @property
    def spoiled_share(self) -> float:
        """Share of the right readings that were spoiled; NaN if none was right."""
        return _ratio(self.spoiled, self.right)

    def errors(self, group: Group, when: When, against: Against) -> RangeErrors:
        """Return the errors of a group of readings, before or after, against a truth.

        Raises
        ------
        InputError
            If a word is unknown.
        """
        for name, word, known in (
            ("group", group, get_args(Group)),
            ("when", when, get_args(When)),
            ("against", against, get_args(Against)),
        ):
            one_of(name, word, known)
        errors_m: NDArray[np.float64] = getattr(self, f"{against}_{when}_m")
        wrong = self.is_wrong
        wanted = {"all": np.ones_like(wrong), "wrong": wrong, "right": ~wrong}[group]
        return RangeErrors.of(errors_m[wanted])

    def to_dict(self) -> dict[str, Any]:
        """Return scores and counts as JSON-able values; None for a score that is not defined."""
        scores = (
            "precision",
            "recall",
            "mended_share",
            "spoiled_share",
            "caught_share",
            "lost_share",
            "roc_auc",
            "caught_at_lost_1_percent",
        )
        counts = (
            "wrong",
            "right",
            "wrong_updated",
            "right_updated",
            "mended",
            "spoiled",
            "caught",
            "lost",
        )
        return {
            **{name: _defined(getattr(self, name)) for name in scores},
            "counts": {"readings": len(self), **{name: getattr(self, name) for name in counts}},
            "causes": {cause.name.lower(): self._counts_of(cause) for cause in Cause},
            "rejected": {
                cause.name.lower(): int((self.rejected & (self.cause == cause)).sum())
                for cause in Cause
            },
            "errors": {
                group: {
                    when: {
                        against: self.errors(group, when, against).to_dict()
                        for against in get_args(Against)
                    }
                    for when in get_args(When)
                }
                for group in get_args(Group)
            },
        }

    @property
    def _near(self) -> NDArray[np.bool_]:
        nearest_m = np.minimum(np.abs(self.cone_after_m), np.abs(self.axis_after_m))
        near: NDArray[np.bool_] = nearest_m <= NEAR_M + _SLACK_M
        return near

    def _counts_of(self, cause: Cause) -> dict[str, int]:
        rows = self.cause == cause
        return {
            "readings": int(rows.sum()),
            "updated": int((rows & self.updated).sum()),
            "mended": int((rows & self.is_mended).sum()),
            "spoiled": int((rows & self.is_spoiled).sum()),
        }


def score_readings(before: SonarLog, after: SonarLog | Filtered) -> ReadingScore:
    """Score what a filter made of a log's readings.

    Parameters
    ----------
    before : SonarLog
        The log as it was recorded; its truth judges both.
    after : SonarLog or Filtered
        The same readings of the same drive, filtered; its ``rejected`` and ``doubt`` count too.

    Returns
    -------
    ReadingScore
        Of all readings but those that were stale (they only repeat another reading) or rejected
        already before.

    Raises
    ------
    InputError
        If the logs are not of the same drive, or `before` has no truth.

    Notes
    -----
    Readings and truths are taken within the ring's own limits, which are all that it can tell
    apart: no echo, and anything farther, is the maximum range; too close, and anything nearer,
    is the minimum range. No echo of nothing in range is thus no error, and no echo of a wall at
    1 m is, on a ring for 3 m, too long by 2 m.
    """
    if isinstance(after, Filtered):
        after = after.log
    truth = before.require_truth("the score of readings")
    _check_same_drive(before, after)
    judged = before.usable
    ring = before.ring

    def error_m(range_m: NDArray[np.float64], true_m: NDArray[np.float64]) -> NDArray[np.float64]:
        reading, true = (
            values[judged].clip(ring.range_min_m, ring.range_max_m) for values in (range_m, true_m)
        )
        error: NDArray[np.float64] = reading - true
        return error

    return ReadingScore(
        cause=truth.cause[judged],
        updated=(before.range_m != after.range_m)[judged],
        cone_before_m=error_m(before.range_m, truth.cone_range_m),
        cone_after_m=error_m(after.range_m, truth.cone_range_m),
        axis_before_m=error_m(before.range_m, truth.axis_range_m),
        axis_after_m=error_m(after.range_m, truth.axis_range_m),
        rejected=after.rejected[judged],
        doubt=after.doubt[judged],
    )


def _check_same_drive(before: SonarLog, after: SonarLog) -> None:
    if len(before) != len(after):
        raise InputError(
            f"both logs must have the same readings, got {len(before)} before and "
            f"{len(after)} after"
        )
    if before.ring != after.ring:
        raise InputError(
            f"both logs must have the same ring, got {before.ring.name!r} and {after.ring.name!r}"
        )
    for name in ("scan", "sonar", "time_s"):
        old, new = getattr(before, name), getattr(after, name)
        first_row(f"after.{name}", old != new, new, "what it was before")


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else math.nan


def _defined(value: float) -> float | None:
    return value if math.isfinite(value) else None
