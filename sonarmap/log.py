"""`SonarLog`: what a ring of sonars said, one row a reading, and what was true when known."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sonarmap.columns import column
from sonarmap.errors import InputError, first_row
from sonarmap.rings import SonarRing

__all__ = ["Cause", "LogTruth", "SonarLog"]

# Polaroid 6500 sheet: 35 ft = 10.7 m is the longest range of any sonar here. A range of twice
# that is a slip of units (millimetres read as metres), not a measurement.
RANGE_LIMIT_M = 20.0


class Cause(IntEnum):
    """Why a reading says what it says. The first three are right, the last three wrong."""

    DIRECT = 0
    """A straight echo that agrees with the true range on the acoustic axis."""
    OFF_AXIS = 1
    """A straight echo of something in the cone that is nearer than what the axis meets."""
    OUT_OF_RANGE = 2
    """No echo, and nothing in the cone within the maximum range."""
    BOUNCE = 3
    """An echo that came by way of one or more mirroring surfaces: too long."""
    CROSSTALK = 4
    """The sound of another transducer."""
    DROPOUT = 5
    """The echo of what stands in the cone was lost: no echo, or one from farther on the axis."""

    @property
    def is_right(self) -> bool:
        """Whether a reading of this cause tells the truth."""
        return self <= Cause.OUT_OF_RANGE


@dataclass(frozen=True, eq=False)
class LogTruth:
    """What a simulator knows of each reading; every array has shape (n,).

    Parameters
    ----------
    x_m, y_m, heading_rad : array_like
        True pose of the robot at the firing.
    axis_range_m : array_like
        True range of the first surface on the acoustic axis; +inf when none is in range.
    cone_range_m : array_like
        True range of the nearest surface in the cone, what a sonar that never loses an echo
        would read; +inf when none is in range.
    cause : array_like of int
        A `Cause` each.
    surface : array_like of str
        Name of the surface that sent the echo; empty for none.
    incidence_rad : array_like
        Angle between the last leg of the sound and that surface's normal; NaN for none.
    bounces : array_like of int
        Number of mirroring surfaces on the way.
    collision : array_like of bool
        Whether the robot touched something since the scan before.
    source : array_like of int, optional
        The sonar whose sound it was, as a number of the ring: `NO_SOURCE` for none,
        `OUTSIDE_SOURCE` for one that is not the robot's. By default none.
    level_db : array_like, optional
        How far the echo stood above the detection threshold, decibels; NaN for no echo and
        where the acoustic model knows no levels, which is the default.
    """

    NO_SOURCE: ClassVar[int] = -1
    OUTSIDE_SOURCE: ClassVar[int] = -2
    PREFIX: ClassVar[str] = "truth_"
    """What the names of its columns begin with in a file."""

    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    axis_range_m: NDArray[np.float64]
    cone_range_m: NDArray[np.float64]
    cause: NDArray[np.int8]
    surface: NDArray[np.str_]
    incidence_rad: NDArray[np.float64]
    bounces: NDArray[np.int16]
    collision: NDArray[np.bool_]
    source: NDArray[np.int16] = None  # type: ignore[assignment]  # filled below
    level_db: NDArray[np.float64] = None  # type: ignore[assignment]  # filled below

    DTYPES = MappingProxyType(
        {
            "x_m": np.float64,
            "y_m": np.float64,
            "heading_rad": np.float64,
            "axis_range_m": np.float64,
            "cone_range_m": np.float64,
            "cause": np.int8,
            "surface": np.str_,
            "incidence_rad": np.float64,
            "bounces": np.int16,
            "collision": np.bool_,
            "source": np.int16,
            "level_db": np.float64,
        }
    )

    def __post_init__(self) -> None:
        size = np.asarray(self.x_m).size
        for name, unknown in (("source", self.NO_SOURCE), ("level_db", math.nan)):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.full(size, unknown))
        for name, dtype in self.DTYPES.items():
            checked = column(f"truth.{name}", getattr(self, name), dtype, size)
            object.__setattr__(self, name, checked)
        for name in ("x_m", "y_m", "heading_rad"):
            values = getattr(self, name)
            first_row(f"truth.{name}", ~np.isfinite(values), values, "a finite number")
        known = np.isin(self.cause, [cause.value for cause in Cause])
        first_row("truth.cause", ~known, self.cause, f"0 to {len(Cause) - 1}")
        first_row("truth.source", self.source < self.OUTSIDE_SOURCE, self.source, ">= -2")

    def select(self, rows: ArrayLike) -> LogTruth:
        """Return the truth of the given rows (a mask, a slice or indices)."""
        return LogTruth(**{name: getattr(self, name)[rows] for name in self.DTYPES})


@dataclass(frozen=True, eq=False)
class SonarLog:
    """The readings of a drive, one row a reading, in the order of firing.

    Parameters
    ----------
    ring : SonarRing
        The sonars.
    scan, sonar : array_like of int, shape (n,)
        Number of the scan, not decreasing, and of the sonar in the ring.
    time_s : array_like, shape (n,)
        Time of the firing in seconds, not decreasing.
    x_m, y_m, heading_rad : array_like, shape (n,)
        Pose of the robot at that firing by its own odometry.
    range_m : array_like, shape (n,)
        The reading in metres; ``+inf`` no echo, ``-inf`` too close (REP 117).
    stale : array_like of bool, shape (n,), optional
        Marks a reading that repeats an older one of the same firing. None: no reading is.
    rejected : array_like of bool, shape (n,), optional
        Marks a reading that a filter takes for wrong and did not mend. None: no reading is.
    doubt : array_like, shape (n,), optional
        Probability that a reading is wrong, by a filter, in [0, 1]; NaN for no opinion, which is
        the default.
    truth : LogTruth, optional
        What was true; None for a real robot.
    provenance : mapping, optional
        Where the log comes from, as JSON-able values.

    Raises
    ------
    InputError
        If lengths differ, a value breaks its rule, or time runs backwards; the message names
        the column and the row.
    """

    ring: SonarRing
    scan: NDArray[np.int32]
    sonar: NDArray[np.int16]
    time_s: NDArray[np.float64]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    range_m: NDArray[np.float64]
    stale: NDArray[np.bool_] = None  # type: ignore[assignment]  # filled below
    rejected: NDArray[np.bool_] = None  # type: ignore[assignment]  # filled below
    doubt: NDArray[np.float64] = None  # type: ignore[assignment]  # filled below
    truth: LogTruth | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)

    DTYPES = MappingProxyType(
        {
            "scan": np.int32,
            "sonar": np.int16,
            "time_s": np.float64,
            "x_m": np.float64,
            "y_m": np.float64,
            "heading_rad": np.float64,
            "range_m": np.float64,
            "stale": np.bool_,
            "rejected": np.bool_,
            "doubt": np.float64,
        }
    )

    def __post_init__(self) -> None:
        size = np.asarray(self.range_m).size
        for name, unmarked in (("stale", False), ("rejected", False), ("doubt", math.nan)):
            if getattr(self, name) is None:
                object.__setattr__(self, name, np.full(size, unmarked))
        for name, dtype in self.DTYPES.items():
            object.__setattr__(self, name, column(name, getattr(self, name), dtype, size))
        object.__setattr__(self, "provenance", dict(self.provenance))
        for name in ("time_s", "x_m", "y_m", "heading_rad"):
            values = getattr(self, name)
            first_row(name, ~np.isfinite(values), values, "a finite number")
        for name in ("time_s", "scan"):
            values = getattr(self, name)
            backwards = np.diff(values, prepend=values[:1]) < 0
            first_row(name, backwards, values, "not less than the row before")
        unknown = (self.sonar < 0) | (self.sonar >= len(self.ring))
        first_row("sonar", unknown, self.sonar, f"0 to {len(self.ring) - 1}")
        seen = np.isfinite(self.range_m)
        absurd = np.isnan(self.range_m) | (
            seen & ((self.range_m < 0) | (self.range_m > RANGE_LIMIT_M))
        )
        first_row("range_m", absurd, self.range_m, f"within [0, {RANGE_LIMIT_M:g}] m, +inf or -inf")
        sure = np.isnan(self.doubt) | ((self.doubt >= 0) & (self.doubt <= 1))
        first_row("doubt", ~sure, self.doubt, "within [0, 1], or NaN")
        if self.truth is not None and self.truth.x_m.size != size:
            raise InputError(
                f"truth must have one row a reading, got {self.truth.x_m.size} for {size}"
            )

    def __len__(self) -> int:
        return int(self.range_m.size)

    def replace(self, **changes: Any) -> SonarLog:
        """Return a log with some columns replaced; the others are shared."""
        return dataclasses.replace(self, **changes)

    def select(self, rows: ArrayLike) -> SonarLog:
        """Return the log of the given rows (a mask, a slice or ordered indices)."""
        columns = {name: getattr(self, name)[rows] for name in self.DTYPES}
        truth = None if self.truth is None else self.truth.select(rows)
        return dataclasses.replace(self, **columns, truth=truth)

    def write(self, path: str | Path) -> None:
        """Write the log as Parquet, see `sonarmap.read_log`.

        An older file there is replaced only when all is written.
        """
        from sonarmap.parquet import write_columns  # pyarrow is heavy: loaded when files are used

        columns = {name: getattr(self, name) for name in self.DTYPES}
        if self.truth is not None:
            columns |= {
                LogTruth.PREFIX + name: getattr(self.truth, name) for name in LogTruth.DTYPES
            }
        write_columns(path, columns, ring=self.ring.to_dict(), provenance=dict(self.provenance))

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Which readings may be used, judged, and vouch for a wall: neither stale nor rejected."""
        usable: NDArray[np.bool_] = ~(self.stale | self.rejected)
        return usable

    @property
    def sensor_xy_m(self) -> NDArray[np.float64]:
        """Place of the sonar at each firing by odometry, metres, shape (n, 2)."""
        return self.ring.sensor_xy_m(self.sonar, self.x_m, self.y_m, self.heading_rad)

    @property
    def axis_rad(self) -> NDArray[np.float64]:
        """Direction of the acoustic axis at each firing by odometry, radians, shape (n,)."""
        axis: NDArray[np.float64] = self.heading_rad + self.ring.heading_rad[self.sonar]
        return axis

    @property
    def point_xy_m(self) -> NDArray[np.float64]:
        """Data point of each reading on its axis, metres, shape (n, 2); NaN without an echo."""
        reach = np.where(np.isfinite(self.range_m), self.range_m, np.nan)
        axis = self.axis_rad
        points: NDArray[np.float64] = self.sensor_xy_m + reach[:, None] * np.column_stack(
            [np.cos(axis), np.sin(axis)]
        )
        return points

    def at_true_poses(self) -> SonarLog:
        """Return the log with the true poses in place of odometry.

        Raises
        ------
        InputError
            If the log has no truth.
        """
        truth = self.require_truth("true poses")
        return self.replace(x_m=truth.x_m, y_m=truth.y_m, heading_rad=truth.heading_rad)

    def require_truth(self, purpose: str) -> LogTruth:
        """Return the truth, or raise `InputError` that says what it was needed for."""
        if self.truth is None:
            raise InputError(f"the log has no truth (a real robot's?), needed for {purpose}")
        return self.truth
