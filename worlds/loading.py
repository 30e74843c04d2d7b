"""`load`: from a world file, or the name of a shipped room, to a `World`."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from sonarmap.errors import InputError
from worlds.building import build
from worlds.rooms import label_of, path_of
from worlds.schema import parse_world
from worlds.world import World

__all__ = ["load"]


def load(name_or_path: str | Path, **parameters: float) -> World:
    """Return a world.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a shipped room (see `worlds.names`) or path of a world file.
    **parameters : float
        Parameters of the room to set, such as ``gap_m=0.6``.

    Raises
    ------
    InputError
        If the room is unknown, the file cannot be read, or something in it breaks a rule; the
        message names the file, the key and the rule.
    """
    path = path_of(name_or_path)
    try:
        table, values = parse_world(_read(path), parameters)
        return build(path.stem, table, values)
    except InputError as error:
        raise InputError(f"{label_of(path)}: {error}") from None


def _read(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError("no such file") from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError("is not a world file: not UTF-8 text") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is not TOML: {error}") from None
