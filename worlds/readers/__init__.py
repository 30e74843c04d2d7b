"""World readers: the suffix of a file picks the reader, in this one place.

A reader is a callable ``(path, **parameters) -> World``. One that ships is a line in `READERS`.
An installed package adds its own by an entry point named after the suffix::

    [project.entry-points."sonarbed.world_readers"]
    ".svg" = "my_package.drawing:read_svg"

and any other is used without registration: ``worlds.load("room.svg", reader=read_svg)``, or
``my_module:read_svg:room.svg`` wherever a world is named.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from sonarmap.errors import InputError, did_you_mean
from sonarmap.registry import Registry

if TYPE_CHECKING:
    from worlds.world import World

__all__ = ["READERS", "WorldReader", "reader_for"]


class WorldReader(Protocol):
    """What turns a file into a world.

    Messages of its `InputError` need not name the file: `worlds.load` puts it in front of them.
    """

    def __call__(self, path: Path, /, **parameters: float) -> World:
        """Return the world of a file, its parameters set in place of their defaults."""


READERS: Registry[WorldReader] = Registry(
    "world reader",
    "sonarbed.world_readers",
    {".toml": "worlds.readers.toml.reader:read_toml"},
)
"""World readers by suffix, in lower case with its dot."""

# What a file without a suffix is taken for: a pipe such as /dev/stdin has none.
_DEFAULT = ".toml"


def reader_for(path: Path, reader: WorldReader | str | None = None) -> WorldReader:
    """Return the reader of a file.

    Parameters
    ----------
    path : Path
        The file; it need not exist.
    reader : callable or str, optional
        A reader of one's own, ``package.module:Name`` of one, or a suffix in `READERS`. By
        default the suffix of the file decides.

    Raises
    ------
    InputError
        If no reader is known for the suffix, or `reader` is none.
    """
    if reader is None:
        suffix = path.suffix.lower() or _DEFAULT
        if suffix not in READERS:
            hint = did_you_mean(suffix, READERS)
            raise InputError(f"no world reader for files that end in {suffix!r}{hint}")
        return READERS[suffix]
    found = READERS.find(reader) if isinstance(reader, str) else reader
    if not callable(found):
        raise InputError(f"world reader must be callable, got {found!r}")
    return found
