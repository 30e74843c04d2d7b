"""Tables of numbers in text files whose errors say where they stand: ``file:line: column: ...``."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError
from sonarmap.files import read_text
from sonarmap.log import RANGE_LIMIT_M, SonarLog
from sonarmap.rings import SonarRing

__all__ = ["Table", "csv_rows", "log_of", "ranges_m", "unwrapped_rad", "word_rows"]

Rows = list[tuple[int, list[str]]]

_DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?", re.IGNORECASE)


def word_rows(path: Path) -> Rows:
    """Return (line number, words) of each line that is not blank."""
    return _rows(path, [line.split() for line in read_text(path).splitlines()])


def csv_rows(path: Path) -> Rows:
    """Return (line number, fields) of each line that is not blank; values hold no line breaks.

    Columns are separated by commas or, as spreadsheets write them where the comma is the decimal
    sign, by semicolons or tabs; numbers may then have a decimal comma.
    """
    lines = read_text(path).splitlines()
    header = next((line for line in lines if line.strip()), "")
    separator = next((mark for mark in (";", "\t") if mark in header), ",")
    rows = [[field.strip() for field in row] for row in csv.reader(lines, delimiter=separator)]
    if separator != ",":
        rows = [[_with_point(field) for field in row] for row in rows]
    elif "," not in header and len(header.split()) > 1:
        raise InputError(f"{path}: its columns must be separated by commas, semicolons or tabs")
    return _rows(path, rows)


def _with_point(field: str) -> str:
    return field.replace(",", ".") if _DECIMAL_COMMA.fullmatch(field) else field


@dataclass(frozen=True)
class Table:
    """Numbers by column name, and the place of each.

    Parameters
    ----------
    path : Path
        The file, for messages.
    columns : sequence of str
        Names of the columns.
    lines : sequence of int
        Line number of each row in the file.
    values : ndarray, shape (rows, columns)
        The numbers, all finite.
    """

    path: Path
    columns: Sequence[str]
    lines: Sequence[int]
    values: NDArray[np.float64]

    @classmethod
    def of(cls, path: Path, columns: Sequence[str], rows: Rows) -> Table:
        """Return the table of `rows`, or raise `InputError` for the first value that is none."""
        if not rows:
            raise InputError(f"{path}: is empty, at least one row of values is needed")
        values = np.empty((len(rows), len(columns)))
        for i, (line, words) in enumerate(rows):
            if len(words) != len(columns):
                raise InputError(
                    f"{path}:{line}: must have {len(columns)} columns "
                    f"({columns[0]} to {columns[-1]}), got {len(words)}"
                )
            for j, (column, word) in enumerate(zip(columns, words, strict=True)):
                values[i, j] = _number(f"{path}:{line}: {column}", word)
        return cls(path, columns, [line for line, _ in rows], values)

    def column(self, name: str) -> NDArray[np.float64]:
        """Return a column, shape (rows,)."""
        column: NDArray[np.float64] = self.values[:, self.columns.index(name)]
        return column

    def times_s(self, name: str, per_second: float) -> NDArray[np.float64]:
        """Return the column of times in seconds, which must not run backwards."""
        times = self.column(name)
        self.check(name, np.diff(times, prepend=times[:1]) < 0, "not less than the row before")
        return times / per_second

    def check(self, name: str, bad: NDArray[np.bool_], rule: str) -> None:
        """Raise `InputError` for the first row of column `name` that is marked in `bad`."""
        if bad.any():
            row = int(np.argmax(bad))
            raise InputError(
                f"{self.path}:{self.lines[row]}: {name}: must be {rule}, "
                f"got {self.column(name)[row]:.15g}"
            )


def ranges_m(
    table: Table, names: Sequence[str], ring: SonarRing, no_echo_mm: float
) -> NDArray[np.float64]:
    """Return readings given in millimetres as a log has them, shape (rows, sonars).

    The code for no echo and whatever is not nearer than the ring's maximum range becomes +inf
    (a sonar that hears nothing reports its limit), what is nearer than its minimum -inf.
    """
    limit_mm = RANGE_LIMIT_M * 1000
    ranges = []
    for name in names:
        mm = table.column(name)
        table.check(name, (mm < 0) | (mm > limit_mm), f"within [0, {limit_mm:g}] mm")
        range_m = mm / 1000
        range_m[(mm == no_echo_mm) | (range_m >= ring.range_max_m)] = np.inf
        range_m[range_m < ring.range_min_m] = -np.inf
        ranges.append(range_m)
    range_m = np.column_stack(ranges)
    if (range_m == -np.inf).all():
        # Nothing but noise at the transducers does that; a slip of units often.
        longest = max(float(table.column(name).max()) for name in names)
        raise InputError(
            f"{table.path}: ranges must be in millimetres, and some of them not nearer than the "
            f"{ring.range_min_m * 1000:g} mm of ring {ring.name!r}; the longest is {longest:g}: "
            "metres?"
        )
    return range_m


def unwrapped_rad(heading_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return headings in radians without the jumps by whole turns, starting as given."""
    return np.unwrap(np.deg2rad(heading_deg))


def log_of(
    ring: SonarRing,
    time_s: NDArray[np.float64],
    xy_m: tuple[NDArray[np.float64], NDArray[np.float64]],
    heading_rad: NDArray[np.float64],
    range_m: NDArray[np.float64],
    provenance: dict[str, object],
) -> SonarLog:
    """Return the log of scans: each row's readings share its time and its pose."""
    scans, sonars = range_m.shape
    x_m, y_m = xy_m
    return SonarLog(
        ring=ring,
        scan=np.repeat(np.arange(scans), sonars),
        sonar=np.tile(np.arange(sonars), scans),
        time_s=np.repeat(time_s, sonars),
        x_m=np.repeat(x_m, sonars),
        y_m=np.repeat(y_m, sonars),
        heading_rad=np.repeat(heading_rad, sonars),
        range_m=range_m.ravel(),
        provenance=provenance,
    )


def _rows(path: Path, fields: list[list[str]]) -> Rows:
    rows = [(number, row) for number, row in enumerate(fields, start=1) if any(row)]
    if not rows:
        raise InputError(f"{path}: is empty, at least one row of values is needed")
    return rows


def _number(place: str, word: str) -> float:
    try:
        number = float(word)
    except ValueError:
        raise InputError(f"{place}: must be a number, got {word!r}") from None
    if not math.isfinite(number):
        raise InputError(f"{place}: must be a finite number, got {word!r}")
    return number
