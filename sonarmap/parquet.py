"""Columns of readings as Parquet files, the ring and the provenance in their metadata."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from sonarmap.errors import InputError
from sonarmap.files import atomic_path

__all__ = ["FORMAT_VERSION", "read_columns", "write_columns"]

FORMAT_VERSION = 3
"""1: no ``truth_source`` and ``truth_level_db``. 2: no ``rejected`` and ``doubt``."""
_KEY = b"sonarbed"


def write_columns(
    path: str | Path,
    columns: Mapping[str, NDArray[Any]],
    *,
    ring: Mapping[str, Any],
    provenance: Mapping[str, Any],
) -> None:
    """Write columns to `path`; an older file there is replaced only when all is written."""
    arrays = {
        # Names repeat thousands of times: stored once each.
        name: pa.array(values.astype(object)).dictionary_encode()
        if values.dtype.kind == "U"
        else pa.array(values)
        for name, values in columns.items()
    }
    about = {"format_version": FORMAT_VERSION, "ring": ring, "provenance": provenance}
    table = pa.table(arrays).replace_schema_metadata({_KEY: json.dumps(about, sort_keys=True)})
    with atomic_path(path) as beside:
        pq.write_table(table, beside)


def read_columns(path: str | Path) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return the columns of a file and its ``format_version``, ``ring`` and ``provenance``.

    Raises
    ------
    InputError
        If the file is missing, truncated, of another kind or version, has no reading, or a column
        has empty values; the message starts with the file.
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
        about = _about(table)
        if table.num_rows == 0:
            raise InputError("the log is empty: it has no reading")
        return {name: _column(table, name) for name in table.column_names}, about
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


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
    if type(version) is not int or not 1 <= version <= FORMAT_VERSION:
        raise InputError(f"format version must be 1 to {FORMAT_VERSION}, got {version!r}")
    if not all(isinstance(about.get(part), dict) for part in ("ring", "provenance")):
        raise damaged
    return about


def _column(table: pa.Table, name: str) -> NDArray[Any]:
    column = table.column(name)
    if column.null_count:
        raise InputError(f"column {name!r} must have no empty values, got {column.null_count}")
    if pa.types.is_dictionary(column.type):
        column = column.cast(pa.string())
    values: NDArray[Any] = column.to_numpy()
    return values.astype(str) if values.dtype == object else values
