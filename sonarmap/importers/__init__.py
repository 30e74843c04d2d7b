"""Readers of logs that real robots wrote; a new format is one module here and one line below."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from sonarmap.errors import InputError, did_you_mean
from sonarmap.importers.aria import read_aria
from sonarmap.importers.udacity import read_udacity
from sonarmap.log import SonarLog
from sonarmap.rings import SonarRing

__all__ = ["FORMATS", "Importer", "import_log", "read_aria", "read_udacity"]

Importer = Callable[[Sequence[str | Path], SonarRing | None], SonarLog]


def import_log(
    paths: Sequence[str | Path],
    format: str,  # noqa: A002 - the word of the command line
    ring: SonarRing | None = None,
) -> SonarLog:
    """Read a log that a real robot wrote.

    Parameters
    ----------
    paths : sequence of str or Path
        The files of the log, as many and in the order that the format asks for.
    format : str
        A name in `FORMATS`.
    ring : SonarRing, optional
        The robot's sonars. "udacity" knows its own; "aria" must be told.

    Returns
    -------
    SonarLog
        Without truth; no reading is marked as stale, see `sonarmap.mark_stale`.

    Raises
    ------
    InputError
        If the format is unknown, the number of files is not the format's, or a file breaks a
        rule; the message names the file, the line and the column.
    """
    if format not in FORMATS:
        raise InputError(f"format {format!r} is unknown{did_you_mean(format, FORMATS)}")
    return FORMATS[format](paths, ring)


def _udacity(paths: Sequence[str | Path], ring: SonarRing | None) -> SonarLog:
    measurements, poses = _files("udacity", paths, "measurement.txt", "poses.txt")
    return read_udacity(measurements, poses, ring)


def _aria(paths: Sequence[str | Path], ring: SonarRing | None) -> SonarLog:
    (table,) = _files("aria", paths, "a CSV table")
    if ring is None:
        raise InputError("format 'aria' needs the ring of the robot, e.g. 'amigobot-aria'")
    return read_aria(table, ring)


def _files(name: str, paths: Sequence[str | Path], *wanted: str) -> Sequence[str | Path]:
    if len(paths) != len(wanted):
        raise InputError(
            f"format {name!r} must get {len(wanted)} file{'s'[: len(wanted) - 1]} "
            f"({', '.join(wanted)}), got {len(paths)}"
        )
    return paths


FORMATS: Mapping[str, Importer] = MappingProxyType({"udacity": _udacity, "aria": _aria})
