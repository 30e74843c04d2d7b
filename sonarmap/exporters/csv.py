"""Logs as CSV tables: one row a reading, for spreadsheets and programs that know no Parquet."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sonarmap.exporters.protocol import FileExporter
from sonarmap.files import atomic_path

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from sonarmap.log import SonarLog

__all__ = ["CSV", "write_csv"]


def write_csv(log: SonarLog, path: str | Path) -> None:
    """Write a log as a CSV table with a header, one row a reading.

    Parameters
    ----------
    log : SonarLog
        The log. Its ring and its provenance are not in the table: the Parquet file keeps them.
    path : str or Path
        The file; an older one there is replaced only when all is written.

    Notes
    -----
    Columns are those of the Parquet file, ``truth_`` before the names of the truth's, with the
    units in their names. Numbers have as many digits as bring back the same bits; no echo is
    ``inf``, too close ``-inf``, no opinion ``nan``; marks are ``true`` or ``false``, causes the
    numbers of `sonarmap.Cause`. UTF-8, lines end with a line feed.
    """
    columns = {name: getattr(log, name) for name in log.DTYPES}
    if log.truth is not None:
        truth = log.truth
        columns |= {truth.PREFIX + name: getattr(truth, name) for name in truth.DTYPES}
    with atomic_path(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*map(_fields, columns.values()), strict=True))


def _fields(column: NDArray[Any]) -> list[Any]:
    # Python's own float is written with the fewest digits that bring it back.
    values: list[Any] = column.tolist()
    if column.dtype == bool:
        return ["true" if value else "false" for value in values]
    return values


CSV = FileExporter(write_csv, "one row a reading, without the ring and the provenance")
