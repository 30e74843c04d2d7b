"""`sonarbed worlds generate`: rooms without end, as files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.choices import listed
from sonarbed.options import Json, Param, check_writable
from sonarmap.errors import InputError
from worlds.generation.catalogue import STYLES

if TYPE_CHECKING:
    from worlds import Plan, World

__all__ = ["generate"]

# A sheet of more rooms shows nothing of any.
_MOST_ON_SHEET = 100
_MOST_SEEDS = 1_000_000
_ALL = "all"


def generate(
    style: Annotated[
        list[str],
        typer.Option(
            metavar="NAME",
            help=f"{listed([*STYLES, _ALL])}; repeatable. Or package.module:Name of your own.",
        ),
    ],
    seed: Annotated[
        str,
        typer.Option(metavar="SEED|FIRST:END", help="One seed, or those from FIRST to before END."),
    ] = "0",
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write STYLE-SEED.toml files into it.")
    ] = None,
    robot_radius: Annotated[
        float, typer.Option(metavar="METRES", help="Radius of the robot that shall drive there.")
    ] = 0.18,
    param: Param = None,
    png: Annotated[
        Path | None,
        typer.Option(help=f"Draw a sheet of the rooms, {_MOST_ON_SHEET} at most, as .png file."),
    ] = None,
    as_json: Json = False,
) -> None:
    r"""Make rooms of a style, one a seed: always the same one.

    A room is a plain TOML file, with a route that keeps clear of
    everything. What there is already, and is the same, stays.

    Example:

      sonarbed worlds generate --style office --seed 0:10 \
        --out rooms --png rooms.png

      sonarbed worlds generate --style office --out wide \
        --param door_min_m=1.1 --param door_max_m=1.3
    """
    from sonarbed.console import print_json, progress, say
    from sonarmap.files import make_folder

    if out is None and png is None:
        raise InputError("--out DIR is missing: where to write the rooms (or --png for a picture)")
    seeds = _seeds(seed)
    kinds = _kinds(style, param)
    check_writable(png, ".png")
    if out is not None:
        make_folder(out)
    files: list[Path] = []
    shown: list[World] = []
    with progress() as bars:
        for plan in bars.track(
            _plans(kinds, seeds, robot_radius),
            total=len(kinds) * len(seeds),
            description="Generating rooms",
        ):
            if out is not None:
                files.append(_written(plan, out / f"{plan.name}.toml"))
            if png is not None and len(shown) < _MOST_ON_SHEET:
                shown.append(plan.world())
    if png is not None:
        from sonarbed.reporting.pictures import draw_rooms

        draw_rooms(shown, png)
    if as_json:
        print_json({"files": [str(path) for path in files], "png": str(png) if png else None})
        return
    if files:
        count = f"{len(files)} rooms" if files[1:] else "1 room"
        say(f"{count}: {files[0]}" + (f" to {files[-1].name}" if files[1:] else ""))
    if png is not None:
        say(f"Drawn: {png}")


def _seeds(text: str) -> range:
    """Return the seeds that SEED or FIRST:END stands for."""
    match = re.fullmatch(r"(\d{1,18})(?::(\d{1,18}))?", text.strip(), re.ASCII)
    if match is None:
        raise InputError(f"--seed must be a whole number >= 0 or FIRST:END, got {text!r}")
    first = int(match[1])
    end = first + 1 if match[2] is None else int(match[2])
    if not 0 < end - first <= _MOST_SEEDS:
        raise InputError(
            f"--seed FIRST:END must be 1 to {_MOST_SEEDS} seeds, got {text!r}: {end - first}"
        )
    return range(first, end)


def _kinds(names: list[str], settings: list[str] | None) -> list[Any]:
    """Return the styles of the names, with the parameters given as NAME=VALUE."""
    import worlds
    from sonarmap.parameters import from_text

    chosen = list(dict.fromkeys(STYLES.shipped if names == [_ALL] else names))
    if settings and len(chosen) != 1:
        raise InputError(f"--param needs one --style, got {len(chosen)}")
    texts: dict[str, str] = {}
    for setting in settings or []:
        key, equals, text = setting.partition("=")
        if not key or not equals:
            raise InputError(f"--param must be NAME=VALUE, got {setting!r}")
        if key in texts:
            raise InputError(f"--param {key} is given twice")
        texts[key] = text
    found = []
    for name in chosen:
        typed = from_text(f"style {name!r}", type(worlds.style(name)), texts) if texts else {}
        found.append(worlds.style(name, **typed))
    return found


def _plans(kinds: list[Any], seeds: range, robot_radius_m: float) -> Iterator[Plan]:
    import worlds

    for kind in kinds:
        for seed in seeds:
            yield worlds.plan(kind, seed, robot_radius_m=robot_radius_m)


def _written(plan: Plan, path: Path) -> Path:
    """Write a room's file, unless it is there already; return its path."""
    from sonarmap.files import atomic_path

    data = plan.to_toml().encode()
    if path.is_file():
        if path.read_bytes() != data:
            raise InputError(f"{path}: another file is there already: remove it, or another --out")
        return path
    with atomic_path(path) as beside:
        beside.write_bytes(data)
    return path
