"""Importers of logs that real robots wrote, one file a format.

An importer is a callable ``(paths, ring) -> SonarLog``. One that ships is a module here and a line
in `sonarmap.catalogue`. An installed package adds its own by an entry point::

    [project.entry-points."sonarbed.importers"]
    my-robot = "my_package.log:read_my_robot"

and any other is used without registration, as the callable or as ``package.module:Name``.

Nothing heavy is loaded before a log is read, so that help can say which files a format wants.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sonarmap.catalogue import IMPORTERS
from sonarmap.errors import InputError
from sonarmap.importers.aria import read_aria
from sonarmap.importers.protocol import FileImporter, Importer
from sonarmap.importers.udacity import read_udacity

if TYPE_CHECKING:
    from sonarmap.log import SonarLog
    from sonarmap.rings import SonarRing

__all__ = ["FORMATS", "FileImporter", "Importer", "import_log", "read_aria", "read_udacity"]

FORMATS = IMPORTERS
"""The importers by the name of their format."""


def import_log(
    paths: Sequence[str | Path],
    format: str | Importer,  # noqa: A002 - the word of the command line
    ring: SonarRing | None = None,
) -> SonarLog:
    """Read a log that a real robot wrote.

    Parameters
    ----------
    paths : sequence of str or Path
        The files of the log, as many and in the order that the format asks for.
    format : str or callable
        A name in `FORMATS`, ``package.module:Name`` of an importer, or an importer of one's own:
        any callable ``(paths, ring) -> SonarLog``.
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
    from sonarmap.log import SonarLog  # numpy is loaded when a log is read

    importer = FORMATS.find(format) if isinstance(format, str) else format
    if not callable(importer):
        raise InputError(f"format must be callable with (paths, ring), got {importer!r}")
    log = importer(paths, ring)
    if not isinstance(log, SonarLog):
        label = format if isinstance(format, str) else getattr(format, "__name__", format)
        raise InputError(f"format {label!r} must return a SonarLog, got {type(log).__name__}")
    return log
