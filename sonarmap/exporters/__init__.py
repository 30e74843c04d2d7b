"""Exporters of logs for other programs, one file a format.

An exporter is a callable ``(log, path) -> None``. One that ships is a module here and a line in
`sonarmap.catalogue`, under the suffix of its files. An installed package adds its own by an entry
point::

    [project.entry-points."sonarbed.exporters"]
    bag = "my_package.bags:write_bag"

and any other is used without registration, as the callable or as ``package.module:Name``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sonarmap.catalogue import EXPORTERS
from sonarmap.errors import InputError, did_you_mean
from sonarmap.exporters.protocol import Exporter, FileExporter

if TYPE_CHECKING:
    from sonarmap.log import SonarLog

__all__ = ["Exporter", "FileExporter", "export_log", "exporter_for"]


def export_log(
    log: SonarLog,
    path: str | Path,
    format: str | Exporter | None = None,  # noqa: A002 - the word of the command line
) -> None:
    """Write a log in the format of other programs.

    Parameters
    ----------
    log : SonarLog
        The log.
    path : str or Path
        The file to write.
    format : str or callable, optional
        The name of an exporter ("csv"), ``package.module:Name`` of one, or one of one's own: any
        callable ``(log, path) -> None``. By default the suffix of the file decides.

    Raises
    ------
    InputError
        If the format is unknown, or the file cannot be written.
    """
    exporter_for(path, format)(log, Path(path))


def exporter_for(path: str | Path, format: str | Exporter | None = None) -> Exporter:  # noqa: A002
    """Return the exporter that `export_log` uses for the same path and format."""
    if format is None:
        suffix = Path(path).suffix.lower()
        if suffix.removeprefix(".") not in EXPORTERS:
            hint = did_you_mean(suffix, [f".{name}" for name in EXPORTERS])
            raise InputError(f"{path}: no format for files that end in {suffix!r}{hint}")
        format = suffix.removeprefix(".")  # noqa: A001
    exporter: Exporter = EXPORTERS.find(format) if isinstance(format, str) else format
    if not callable(exporter):
        raise InputError(f"format must be callable with (log, path), got {exporter!r}")
    return exporter
