"""`load`: from a file, or the name of a shipped room, to a `World`."""

from __future__ import annotations

from pathlib import Path
from typing import Any, overload

from sonarmap.errors import InputError
from worlds.readers import WorldReader, reader_for
from worlds.rooms import label_of, place_of
from worlds.world import World

__all__ = ["load"]


# Two signatures, so that parameters may be given as ``**values`` and none is taken for a reader.
@overload
def load(name_or_path: str | Path, /, **parameters: float) -> World: ...
@overload
def load(
    name_or_path: str | Path, /, *, reader: WorldReader | str, **parameters: float
) -> World: ...
def load(name_or_path: str | Path, /, *, reader: Any = None, **parameters: float) -> World:
    """Return a world.

    Parameters
    ----------
    name_or_path : str or Path
        Name of a shipped room (see `worlds.names`) or path of a file, whose suffix picks the
        reader (see `worlds.readers.READERS`). As text also ``package.module:Name:path``, a path
        with the reader to read it by, wherever a command takes a world.
    reader : callable or str, optional
        What reads the file in place of the reader of its suffix: a callable
        ``(path, **parameters) -> World``, or ``package.module:Name`` of one.
    **parameters : float
        Parameters of the room to set, such as ``gap_m=0.6``.

    Raises
    ------
    InputError
        If the room is unknown, no reader knows the suffix, the file cannot be read, or something
        in it breaks a rule; the message names the file, the key and the rule.
    """
    place = place_of(name_or_path)
    path = place.path
    try:
        world = reader_for(path, place.reader if reader is None else reader)(path, **parameters)
        if not isinstance(world, World):
            raise InputError(f"its world reader must return a World, got {type(world).__name__}")
        return world
    except FileNotFoundError:
        raise InputError(f"{label_of(path)}: no such file") from None
    except OSError as error:
        raise InputError(f"{label_of(path)}: cannot be read: {error.strerror or error}") from None
    except InputError as error:
        raise InputError(f"{label_of(path)}: {error}") from None
