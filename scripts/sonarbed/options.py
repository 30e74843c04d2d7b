"""Options that several commands share, and what they turn into."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from worlds import World

__all__ = [
    "Json",
    "Param",
    "Png",
    "Setting",
    "check_log_out",
    "check_writable",
    "load_world",
    "make_part",
]

Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs instead of a table.")]
Setting = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=NUMBER", help="A parameter of the room; repeatable."),
]
Png = Annotated[Path | None, typer.Option("--png", help="Draw a picture into this .png file.")]
Param = Annotated[
    list[str] | None,
    typer.Option("--param", metavar="NAME=VALUE", help="A parameter of it; repeatable."),
]

_LOG_SUFFIXES = (".parquet", ".pq", "")


def make_part(kind: str, name: str, settings: list[str] | None, **short: Any) -> Any:
    """Return the mapping method or reading filter that the options of a command describe.

    Parameters
    ----------
    kind : {"method", "filter"}
        What it is.
    name : str
        Its name, or ``package.module:Name``.
    settings : list of str or None
        ``NAME=VALUE`` each, as ``--param`` takes them.
    **short
        Parameters that other options gave, None where they did not.
    """
    import sonarmap as sm
    from sonarmap.parameters import from_text

    registry, make = {
        "method": (sm.methods(), sm.method),
        "filter": (sm.filters(), sm.filter),
    }[kind]
    texts: dict[str, str] = {}
    for setting in settings or []:
        key, equals, text = setting.partition("=")
        if not key or not equals:
            raise sm.InputError(f"--param must be NAME=VALUE, got {setting!r}")
        if key in texts:
            raise sm.InputError(f"--param {key} is given twice")
        texts[key] = text
    parameters = {key: value for key, value in short.items() if value is not None}
    if texts:
        part = registry.find(name)  # type: ignore[attr-defined]  # a Registry finds paths, too
        typed = from_text(f"{kind} {name!r}", part if isinstance(part, type) else type(part), texts)
        both = sorted(typed.keys() & parameters.keys())
        if both:
            raise sm.InputError(f"--param {both[0]} is given by another option, too")
        parameters |= typed
    return make(name, **parameters)


def load_world(name: str, settings: list[str] | None) -> World:
    """Return the world of a name or file with parameters given as NAME=NUMBER."""
    import worlds
    from sonarmap import InputError

    parameters: dict[str, float] = {}
    for setting in settings or []:
        key, _, text = setting.partition("=")
        try:
            number = float(text)
        except ValueError:
            key = ""
        # "reader" is how `worlds.load` is told who reads the file, and no room's number.
        if not key.isidentifier() or key == "reader":
            raise InputError(f"--set must be NAME=NUMBER, got {setting!r}")
        if key in parameters:
            raise InputError(f"--set {key} is given twice")
        parameters[key] = number
    return worlds.load(name, **parameters)


def check_log_out(path: Path) -> None:
    """Raise `InputError` if no log could be written to `path`, or its name says it is no log."""
    from sonarmap import InputError

    # A folder or a device is refused for what it is, whatever it is called.
    is_other = path.exists() and not path.is_file()
    if not is_other and path.suffix.lower() not in _LOG_SUFFIXES:
        raise InputError(
            f"{path}: a log is a Parquet file: its name must end with .parquet or .pq, or have no "
            "suffix; `sonarbed export` writes other formats"
        )
    check_writable(path)


def check_writable(path: Path | None, suffix: str = "") -> None:
    """Raise `InputError` if no file could be written to `path`: before the work, not after it.

    Parameters
    ----------
    path : Path or None
        The file to be written; None is fine.
    suffix : str
        What its name must end with.
    """
    from sonarmap import InputError
    from sonarmap.files import atomic_path

    if path is None:
        return
    if not path.name.endswith(suffix):
        raise InputError(f"{path}: the file's name must end with {suffix}")

    class _Tried(Exception):  # noqa: N818 - no error: it makes `atomic_path` leave all as it was
        pass

    with suppress(_Tried), atomic_path(path):
        raise _Tried
