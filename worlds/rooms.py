"""Which rooms are shipped, and where their files are."""

from __future__ import annotations

from pathlib import Path

from sonarmap.errors import InputError, did_you_mean

__all__ = ["label_of", "names", "path_of"]

_FOLDER = Path(__file__).parent / "rooms"


def names() -> tuple[str, ...]:
    """Return the names of the rooms that are shipped, sorted."""
    return tuple(sorted(path.stem for path in _FOLDER.glob("*.toml")))


def path_of(name_or_path: str | Path) -> Path:
    """Return the world file of a shipped room, or the path given.

    A text that is neither the name of a room nor looks like a path (a folder in it, or the
    ending ``.toml``) is taken for a misspelt name.
    """
    if isinstance(name_or_path, str) and name_or_path in names():
        return _FOLDER / f"{name_or_path}.toml"
    path = Path(name_or_path)
    looks_like_a_path = path.suffix == ".toml" or len(path.parts) > 1 or path.is_file()
    if isinstance(name_or_path, str) and not looks_like_a_path:
        raise InputError(f"unknown world {name_or_path!r}{did_you_mean(name_or_path, names())}")
    return path


def label_of(path: Path) -> str:
    """Return how messages call a world file: shipped ones as ``rooms/NAME.toml``."""
    return f"rooms/{path.name}" if path.parent == _FOLDER else str(path)
