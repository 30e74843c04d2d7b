"""What an importer of logs is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from sonarmap.errors import InputError

if TYPE_CHECKING:
    from sonarmap.log import SonarLog
    from sonarmap.rings import SonarRing

__all__ = ["FileImporter", "Importer"]


class Importer(Protocol):
    """What turns the files of a real robot into a log; any such callable is one."""

    def __call__(self, paths: Sequence[str | Path], ring: SonarRing | None, /) -> SonarLog:
        """Return the log of some files, taken with a ring of sonars; None: the format's own."""


@dataclass(frozen=True)
class FileImporter:
    """An importer that says which files it wants, and is called with as many.

    Parameters
    ----------
    name : str
        What messages call the format.
    files : tuple of str
        What each file is, in order.
    read : callable
        Takes the files one by one and then the ring; returns a `SonarLog`.
    about : str
        What help adds to the files.
    ring_needed : str or None
        For a format that has no ring of its own, the name of one as an example in the message
        that asks for it.
    """

    name: str
    files: tuple[str, ...]
    read: Callable[..., SonarLog]
    about: str = ""
    ring_needed: str | None = None

    def __call__(self, paths: Sequence[str | Path], ring: SonarRing | None, /) -> SonarLog:
        """Return the log of the files, or raise `InputError` if they are not as many as wanted."""
        if len(paths) != len(self.files):
            raise InputError(
                f"format {self.name!r} must get {len(self.files)} "
                f"file{'s'[: len(self.files) - 1]} ({', '.join(self.files)}), got {len(paths)}"
            )
        if ring is None and self.ring_needed is not None:
            raise InputError(
                f"format {self.name!r} needs the ring of the robot, e.g. {self.ring_needed!r}"
            )
        return self.read(*paths, ring)
