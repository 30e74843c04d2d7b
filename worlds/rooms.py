"""Which rooms are shipped, where their files are, and what a text that names a world means."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from sonarmap.errors import InputError, did_you_mean

__all__ = ["Place", "label_of", "names", "place_of"]

_FOLDER = Path(__file__).parent / "rooms"

# package.module:Name, and after another colon the file.
_OWN_READER = re.compile(r"(?P<reader>[A-Za-z_][\w.]*:[A-Za-z_][\w.]*)(:(?P<path>.+))?", re.DOTALL)


class Place(NamedTuple):
    """Where a world is read from.

    Parameters
    ----------
    path : Path
        The file.
    reader : str or None
        ``package.module:Name`` of the reader to read it by; None: its suffix decides.
    """

    path: Path
    reader: str | None = None


def names() -> tuple[str, ...]:
    """Return the names of the rooms that are shipped, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def place_of(name_or_path: str | Path) -> Place:
    """Return where the world of a name, a path or ``package.module:Name:path`` is read from.

    A text that is neither the name of a room nor looks like a path (a folder in it, a suffix, or
    a file that is there) is taken for a misspelt name.

    Raises
    ------
    InputError
        For a misspelt name, or a reader without a file.
    """
    if isinstance(name_or_path, str) and name_or_path in names():
        return Place(_FOLDER / f"{name_or_path}.toml")
    path = Path(name_or_path)
    if isinstance(name_or_path, Path) or path.is_file():
        return Place(path)
    if own := _OWN_READER.fullmatch(name_or_path):
        if own["path"] is None:
            raise InputError(
                f"world {name_or_path!r} names a reader but no file: give {name_or_path}:FILE"
            )
        return Place(Path(own["path"]), own["reader"])
    if path.suffix or len(path.parts) > 1:
        return Place(path)
    raise InputError(f"unknown world {name_or_path!r}{did_you_mean(name_or_path, names())}")


def label_of(path: Path) -> str:
    """Return how messages call a world file: shipped ones as ``rooms/NAME.toml``."""
    return f"rooms/{path.name}" if path.parent == _FOLDER else str(path)
