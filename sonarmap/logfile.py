"""`read_log`: sonar logs from Parquet files, those of older versions too."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from sonarmap.errors import InputError
from sonarmap.log import LogTruth, SonarLog
from sonarmap.parquet import FORMAT_VERSION, read_columns
from sonarmap.rings import SonarRing

__all__ = ["read_log"]

# Columns that a version brought; a file of an older one is read as if nothing were known of them.
_SINCE = MappingProxyType(
    {"rejected": 3, "doubt": 3, LogTruth.PREFIX + "source": 2, LogTruth.PREFIX + "level_db": 2}
)


def read_log(path: str | Path) -> SonarLog:
    """Read a log that `SonarLog.write` wrote.

    Parameters
    ----------
    path : str or Path
        A Parquet file of any format version; what an older one lacks is filled in as unknown.

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
    columns, about = read_columns(path)
    try:
        version = about["format_version"]
        has_truth = any(name.startswith(LogTruth.PREFIX) for name in columns)
        return SonarLog(
            ring=SonarRing.from_dict(about["ring"]),
            **_chosen(columns, SonarLog.DTYPES, "", version),
            truth=LogTruth(**_chosen(columns, LogTruth.DTYPES, LogTruth.PREFIX, version))
            if has_truth
            else None,
            provenance=about["provenance"],
        )
    except InputError as error:
        raise InputError(f"{Path(path)}: {error}") from None


def _chosen(
    columns: Mapping[str, Any], names: Iterable[str], prefix: str, version: int
) -> dict[str, Any]:
    """Return the columns of a log or its truth, without those that the version did not have."""
    chosen = {}
    for name in names:
        stored = prefix + name
        if stored in columns:
            chosen[name] = columns[stored]
        elif version == FORMAT_VERSION or _SINCE.get(stored, 0) <= version:
            raise InputError(f"column {stored!r} is missing")
    return chosen
