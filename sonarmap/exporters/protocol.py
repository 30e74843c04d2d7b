"""What an exporter of logs is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from sonarmap.log import SonarLog

__all__ = ["Exporter", "FileExporter"]


class Exporter(Protocol):
    """What writes a log as another program wants it; any such callable is one."""

    def __call__(self, log: SonarLog, path: Path, /) -> None:
        """Write the log to a file; an older one there is replaced only when all is written."""


@dataclass(frozen=True)
class FileExporter:
    """An exporter that says what its files hold.

    Parameters
    ----------
    write : callable
        Takes the log and the path.
    about : str
        What the file has of the log, and what it has not.
    """

    write: Callable[[SonarLog, Path], None]
    about: str

    def __call__(self, log: SonarLog, path: Path, /) -> None:
        """Write the log to a file."""
        self.write(log, path)
