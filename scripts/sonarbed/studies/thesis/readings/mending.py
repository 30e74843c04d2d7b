"""What HSR did to the readings of one drive: by cause, by place, and in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import get_args

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.thesis.on_axis import heard_on_axis
from sonarbed.studies.thesis.readings.places import Place, places_of
from sonarmap.scores.readings import Against, When

__all__ = ["Counts", "Mending", "MendingTask", "mended", "share_over_drives"]


@dataclass(frozen=True, slots=True)
class Counts:
    """Readings of some kind, and what became of them.

    Parameters
    ----------
    wrong, mended : int
        Wrong readings, and those of them that were mended.
    right, spoiled : int
        Right readings, and those of them that were spoiled.
    """

    wrong: int
    mended: int
    right: int
    spoiled: int

    @classmethod
    def of(cls, score: sm.ReadingScore, rows: NDArray[np.bool_]) -> Counts:
        """Return the counts of some rows of a score."""
        wrong = score.is_wrong & rows
        return cls(
            int(wrong.sum()),
            int((score.is_mended & rows).sum()),
            int((rows & ~score.is_wrong).sum()),
            int((score.is_spoiled & rows).sum()),
        )


@dataclass(frozen=True)
class Mending:
    """What became of a drive's readings.

    Parameters
    ----------
    all : Counts
        Of all readings.
    by_cause, by_place : mapping
        Of the readings of each `Cause` and `Place`.
    errors : mapping
        For "before cone", "before axis", "after cone" and "after axis": median and 95 % of the
        error, metres, then the shares too long and too short by 0.1 m and by 0.3 m.
    points_m : ndarray, shape (n, 2)
        New data points of the mended and spoiled readings, at the true poses.
    is_mended : ndarray of bool, shape (n,)
        Which of these were mended.
    on_axis : Counts
        Of the other readings, when none that was heard off the axis takes part in HSR.
    """

    all: Counts
    by_cause: dict[sm.Cause, Counts]
    by_place: dict[Place, Counts]
    errors: dict[str, tuple[float, ...]]
    points_m: NDArray[np.float64]
    is_mended: NDArray[np.bool_]
    on_axis: Counts


@dataclass(frozen=True)
class MendingTask:
    """The work of one drive."""

    world: worlds.World
    log: sm.SonarLog
    params: sm.HsrParams


def mended(task: MendingTask) -> Mending:
    """Run HSR over a drive and judge its readings."""
    # Stale and rejected readings are not judged.
    log = task.log.select(task.log.usable)
    truth = log.require_truth("the study of readings")
    repaired = sm.hsr(log, task.params).log
    score = sm.score_readings(log, repaired)
    places = places_of(log, task.world)
    changed = score.is_mended | score.is_spoiled
    errors = {}
    for when, against in product(get_args(When), get_args(Against)):
        found = score.errors("all", when, against)
        shares = [
            count / found.readings
            for beyond in found.beyond
            for count in (beyond.too_long, beyond.too_short)
        ]
        errors[f"{when} {against}"] = (found.median_m, found.p95_m, *shares)
    return Mending(
        all=Counts.of(score, np.ones(len(score), bool)),
        by_cause={cause: Counts.of(score, truth.cause == cause) for cause in sm.Cause},
        by_place={place: Counts.of(score, places == place) for place in Place},
        errors=errors,
        points_m=repaired.at_true_poses().point_xy_m[changed],
        is_mended=score.is_mended[changed],
        on_axis=_counts_on_axis(log, task.params),
    )


def _counts_on_axis(log: sm.SonarLog, params: sm.HsrParams) -> Counts:
    heard = heard_on_axis(log)
    score = sm.score_readings(heard, sm.hsr(heard, params).log)
    return Counts.of(score, score.cause != sm.Cause.OFF_AXIS)


def share_over_drives(counts: Sequence[Counts], part: str, whole: str) -> Estimate:
    """Return the mean share of one count in another over drives; drives without are left out."""
    share = mean_of(
        [
            getattr(each, part) / getattr(each, whole) if getattr(each, whole) else np.nan
            for each in counts
        ]
    )
    # Student's interval does not know that a share ends at 0 and 1.
    low, high = (float(np.clip(bound, 0, 1)) for bound in (share.low, share.high))
    return replace(share, low=low, high=high)
