"""Prediction by linear features, in the style of O'Sullivan and others.

O'Sullivan, Collins, Mansfield, Haskett, Eaton, Linear Feature Prediction for Confidence Estimation
of Sonar Readings in Map Building, Artificial Life and Robotics 9, 2005: walls are predicted from
short readings, which are reliable, and readings that disagree with them count less. Only this idea
could be had; all else is ours:

1. Data points of a sonar's readings up to `short_m`, in order of firing, are joined to a segment as
   long as neighbours are no farther apart than `gap_m` and none is farther than `tolerance_m` from
   the line of least squares through all. Of at least `least_points` and `least_length_m`, it is a
   feature, as long as its points and `extend_m` more at each end.
2. The prediction for a reading is the nearest point of any feature in its cone.
3. A reading longer than that by more than `margin_m`, or a no echo, disagrees and is rejected or
   mended. One that is as long, within `margin_m`, agrees. A shorter one gets no opinion: something
   may stand before the wall. One that a feature was made of is never rejected.
4. A feature of n points is a wall with probability n / (n + `doubtful_points`): the doubt of a
   reading that disagrees with it; of one that agrees it is the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative, one_of, positive, whole
from sonarmap.filters.protocol import Filtered
from sonarmap.log import Cause, SonarLog
from sonarmap.parameters import Real, Space, Whole

__all__ = ["LinearFeature", "LinearFeaturesStyle"]

Action = Literal["mend", "reject"]


@dataclass(frozen=True, slots=True)
class LinearFeature:
    """A piece of wall that short readings lie on.

    Parameters
    ----------
    ends_m : tuple of float
        x, y of one end and of the other, metres.
    rows : tuple of int
        Readings of the log that it was made of.
    """

    ends_m: tuple[float, float, float, float]
    rows: tuple[int, ...]


@dataclass(frozen=True)
class LinearFeaturesStyle:
    """Judges readings by walls that short readings predict; see the module for the rules.

    `least_length_m` and `margin_m` were chosen by hand from six settings on one drive each in the
    rooms office, thesis-exp2, corridor, clutter and l-shape.

    Parameters
    ----------
    short_m : float
        Readings up to it make features, metres, > 0.
    gap_m, tolerance_m : float
        Largest distance between neighbours, and from the line, metres, > 0.
    least_points : int
        Points of a feature at least, >= 3.
    least_length_m : float
        Length of a feature at least, metres, > 0.
    extend_m : float
        How far a feature goes on at each end, metres, >= 0.
    margin_m : float
        A reading this much longer than predicted still agrees, metres, > 0.
    doubtful_points : float
        Points of which half of all features are no walls, > 0.
    action : {"mend", "reject"}
        What becomes of a reading that disagrees: the predicted range, or rejection.
    """

    name: ClassVar[str] = "linear-features-style"
    source: ClassVar[str] = (
        "After the idea of O'Sullivan and others, Linear Feature Prediction for Confidence "
        "Estimation of Sonar Readings in Map Building, 2005; rules and numbers ours."
    )

    short_m: float = 1.5
    gap_m: float = 0.2
    tolerance_m: float = 0.03
    least_points: int = 5
    least_length_m: float = 0.4
    extend_m: float = 0.1
    margin_m: float = 0.3
    doubtful_points: float = 2.0
    action: Action = "reject"

    def __post_init__(self) -> None:
        for name in (
            "short_m",
            "gap_m",
            "tolerance_m",
            "least_length_m",
            "margin_m",
            "doubtful_points",
        ):
            positive(name, getattr(self, name))
        least = whole("least_points", self.least_points, least=3)
        object.__setattr__(self, "least_points", least)
        non_negative("extend_m", self.extend_m)
        one_of("action", self.action, get_args(Action))

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with disagreeing readings rejected or mended; the report: the features."""
        features = self.features(log)
        if not features:
            return Filtered(log, np.zeros(len(log), bool), report=features)
        from sonarmap.kernels.segments import nearest_segment  # numba

        judged = log.usable & (log.range_m >= 0)
        range_m, which = nearest_segment(
            log.sensor_xy_m,
            log.axis_rad,
            log.ring.half_angle_rad,
            np.array([each.ends_m for each in features]),
        )
        # What the sonar could not have measured is no prediction.
        known = judged & (range_m >= log.ring.range_min_m) & (range_m <= log.ring.range_max_m)
        predicted_m = np.where(known, range_m, np.nan)
        made_one = np.zeros(len(log), bool)
        made_one[[row for each in features for row in each.rows]] = True
        with np.errstate(invalid="ignore"):  # NaN where nothing is predicted
            wrong = (log.range_m > predicted_m + self.margin_m) & ~made_one
            agrees = np.abs(log.range_m - predicted_m) <= self.margin_m
        points = np.array([len(each.rows) for each in features])[which]
        is_wall = points / (points + self.doubtful_points)
        doubt = np.where(wrong, is_wall, np.where(agrees, 1 - is_wall, log.doubt))
        cause = np.full(len(log), -1)
        cause[wrong] = Cause.BOUNCE
        cause[wrong & np.isposinf(log.range_m)] = Cause.DROPOUT
        after = log.replace(doubt=doubt)
        if self.action == "reject":
            after = after.replace(rejected=log.rejected | wrong)
        else:
            after = after.replace(range_m=np.where(wrong, predicted_m, log.range_m))
        return Filtered(after, after.range_m != log.range_m, predicted_m, cause, features)

    def features(self, log: SonarLog) -> tuple[LinearFeature, ...]:
        """Return the features that a log's short readings make."""
        short = log.usable & (log.range_m >= log.ring.range_min_m) & (log.range_m <= self.short_m)
        points = log.point_xy_m
        found: list[LinearFeature] = []
        for sonar in range(len(log.ring)):
            rows = np.flatnonzero(short & (log.sonar == sonar))
            begin = 0
            while begin < rows.size:
                end = self._grown(points[rows], begin)
                feature = self._feature(points[rows[begin:end]], rows[begin:end])
                if feature is not None:
                    found.append(feature)
                begin = end
        return tuple(found)

    def _grown(self, xy: NDArray[np.float64], begin: int) -> int:
        """Return the end of the longest run of points from `begin` on that lie on a line."""
        end = begin + 1
        while end < len(xy):
            apart = math.hypot(*(xy[end] - xy[end - 1]))
            if apart > self.gap_m or _off_line(xy[begin : end + 1]) > self.tolerance_m:
                break
            end += 1
        return end

    def _feature(self, xy: NDArray[np.float64], rows: NDArray[np.int64]) -> LinearFeature | None:
        if rows.size < self.least_points:
            return None
        centre, direction = _line(xy)
        along = (xy - centre) @ direction
        low, high = float(along.min()), float(along.max())
        if high - low < self.least_length_m:
            return None
        ends = [centre + t * direction for t in (low - self.extend_m, high + self.extend_m)]
        (x0, y0), (x1, y1) = ((float(x), float(y)) for x, y in ends)
        return LinearFeature((x0, y0, x1, y1), tuple(int(row) for row in rows))

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "short_m": Real(0.5, 3.0),
            "gap_m": Real(0.05, 0.5),
            "tolerance_m": Real(0.01, 0.1, log=True),
            "least_points": Whole(3, 15),
            "extend_m": Real(0.0, 0.5),
            "margin_m": Real(0.03, 0.5, log=True),
        }


def _line(xy: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the centre and the direction of the line of total least squares."""
    centre = xy.mean(axis=0)
    dx, dy = (xy - centre).T
    # Twice the angle of the larger axis of the points' ellipse.
    angle = 0.5 * math.atan2(2 * float((dx * dy).sum()), float((dx**2 - dy**2).sum()))
    return centre, np.array([math.cos(angle), math.sin(angle)])


def _off_line(xy: NDArray[np.float64]) -> float:
    """Return the largest distance of points from their line."""
    centre, (cos, sin) = _line(xy)
    dx, dy = (xy - centre).T
    return float(np.abs(dy * cos - dx * sin).max())
