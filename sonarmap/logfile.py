"""Sonar logs as Parquet files: one row a reading, ring and provenance in the metadata."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sonarmap.errors import InputError
from sonarmap.files import atomic_path
from sonarmap.log import LogTruth, SonarLog
from sonarmap.rings import SonarRing

__all__ = ["read_log", "write_log"]

FORMAT_VERSION = 2
_KEY = b"sonarbed"
_TRUTH = "truth_"


def read_log(path: str | Path) -> SonarLog:
    """Read a log that `SonarLog.write` wrote.

    Parameters
    ----------
    path : str or Path
        A Parquet file.

    Returns
    -------
    SonarLog

    Raises
    ------
    InputError
        If the file is missing, truncated, of another kind or version, has no reading, lacks a
        column, or holds a value that breaks a rule of `SonarLog`; the message starts with the
        file.
    """
    path = Path(path)
    try:
        # Not `read_table`: that would take a folder of logs for one log, and a folder called
        # `scan=3` for a column.
        with pq.ParquetFile(path) as file:
            table = file.read()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{path}: is not a readable Parquet file: {reason}") from None
    try:
        return _from_table(table)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_log(log: SonarLog, path: str | Path) -> None:
    """Write `log` to `path`; an older file there is replaced only when all is written."""
    columns = {name: getattr(log, name) for name in SonarLog.DTYPES}
    if log.truth is not None:
        columns |= {_TRUTH + name: getattr(log.truth, name) for name in LogTruth.DTYPES}
    arrays = {
        # Names repeat thousands of times: stored once each.
        name: pa.array(values.astype(object)).dictionary_encode()
        if values.dtype.kind == "U"
        else pa.array(values)
        for name, values in columns.items()
    }
    about = {
        "format_version": FORMAT_VERSION,
        "ring": log.ring.to_dict(),
        "provenance": dict(log.provenance),
    }
    table = pa.table(arrays).replace_schema_metadata({_KEY: json.dumps(about, sort_keys=True)})
    with atomic_path(path) as beside:
        pq.write_table(table, beside)


def _from_table(table: pa.Table) -> SonarLog:
    about = _about(table)
    if table.num_rows == 0:
        raise InputError("the log is empty: it has no reading")
    has_truth = any(name.startswith(_TRUTH) for name in table.column_names)
    columns = {name: _column(table, name) for name in SonarLog.DTYPES}
    truth = (
        LogTruth(**{name: _column(table, _TRUTH + name) for name in LogTruth.DTYPES})
        if has_truth
        else None
    )
    return SonarLog(
        ring=SonarRing.from_dict(about["ring"]),
        **columns,
        truth=truth,
        provenance=about["provenance"],
    )


def _about(table: pa.Table) -> dict[str, Any]:
    metadata = table.schema.metadata or {}
    if _KEY not in metadata:
        raise InputError("is a Parquet file but not a sonar log (no 'sonarbed' metadata)")
    damaged = InputError("its 'sonarbed' metadata is damaged")
    try:
        about: dict[str, Any] = json.loads(metadata[_KEY])
        version = about["format_version"]
    except (ValueError, TypeError, KeyError):
        raise damaged from None
    if version != FORMAT_VERSION:
        raise InputError(f"format version must be {FORMAT_VERSION}, got {version!r}")
    if not all(isinstance(about.get(part), dict) for part in ("ring", "provenance")):
        raise damaged
    return about


def _column(table: pa.Table, name: str) -> Any:
    if name not in table.column_names:
        raise InputError(f"column {name!r} is missing")
    column = table.column(name)
    if column.null_count:
        raise InputError(f"column {name!r} must have no empty values, got {column.null_count}")
    if pa.types.is_dictionary(column.type):
        column = column.cast(pa.string())
    values = column.to_numpy()
    return values.astype(str) if values.dtype == object else values
