"""`sonarbed worlds`: the rooms; and the commands below it, each in a file of its own."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from sonarbed.commands.worlds_check import check
from sonarbed.commands.worlds_generate import generate
from sonarbed.commands.worlds_materials import materials
from sonarbed.options import Json, Png, Setting

if TYPE_CHECKING:
    from worlds import World

__all__ = ["BELOW", "WorldsCommand", "worlds"]


def list_(as_json: Json = False) -> None:
    """List the rooms that ship.

    Example:

      sonarbed worlds list
    """
    _list_rooms(as_json)


_below = typer.Typer(rich_markup_mode="rich")
_below.command("generate")(generate)
_below.command("check")(check)
_below.command("materials")(materials)
_below.command("list")(list_)
_group: Any = typer.main.get_command(_below)
BELOW: tuple[str, ...] = tuple(_group.commands)
"""Words after ``sonarbed worlds`` that are commands of their own, not rooms."""


class WorldsCommand(TyperCommand):
    """`worlds`, which shows rooms, or the command below it that its first word names.

    A group could not show ``worlds office``: it takes the first word for a command.
    """

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Return the context of this command, or of the one below."""
        if args and args[0] in BELOW:
            command = _group.commands[args[0]]
            return command.make_context(f"{info_name} {args[0]}", args[1:], parent, **extra)
        return super().make_context(info_name, args, parent, **extra)


def worlds(
    name: Annotated[
        str | None,
        typer.Argument(
            help="A room or a world file to show; module:reader:file with a reader of your own. "
            f"Or one of the commands {', '.join(BELOW)}."
        ),
    ] = None,
    png: Png = None,
    setting: Setting = None,
    as_json: Json = False,
) -> None:
    """List the rooms, or show one with what is assumed of it.

    Also 'worlds generate' makes rooms from a style and a seed, 'worlds
    check' says what is doubtful in one, 'worlds materials' lists the
    materials, and 'worlds list' the rooms.

    Example:

      sonarbed worlds office --png office.png

      sonarbed worlds generate --style office --out rooms

      sonarbed worlds check rooms/office-0000.toml
    """
    from sonarmap.errors import InputError

    if name is None:
        if png is not None:
            raise InputError("--png needs the name of a room")
        _list_rooms(as_json)
    else:
        _show(name, png, setting, as_json)


def _list_rooms(as_json: bool) -> None:
    import worlds as rooms
    from sonarbed.console import print_json, print_table

    known = [rooms.load(name) for name in rooms.names()]
    if as_json:
        print_json([_described(world) for world in known])
        return
    print_table(
        "Rooms",
        ["name", "what", "size", "solids"],
        [[w.name, w.title, _size(w), str(len(w.solids))] for w in known],
    )


def _show(name: str, png: Path | None, setting: list[str] | None, as_json: bool) -> None:
    from sonarbed.console import print_json, print_table, say
    from sonarbed.options import check_writable, load_world

    check_writable(png, ".png")
    world = load_world(name, setting)
    if png is not None:
        from sonarbed.reporting.pictures import draw_world

        draw_world(world, png)
    if as_json:
        print_json(_described(world))
        return
    say(f"{world.name}: {world.title}\n{world.source}")
    print_table(
        f"Solids, {_size(world)}",
        ["name", "material", "mirrors beyond", "height"],
        [
            [
                solid.name,
                solid.material.name,
                f"{math.degrees(solid.material.critical_incidence_rad):.0f}°",
                f"{solid.height_m:g} m",
            ]
            for solid in world.solids
        ],
    )
    for where, note in world.notes.items():
        say(f"{where}: {note}")
    for parameter, value in world.parameters.items():
        say(f"parameter {parameter} = {value:g}  (--set {parameter}=...)")
    if png is not None:
        say(f"Drawn: {png}")


def _described(world: World) -> dict[str, object]:
    return {
        "name": world.name,
        "title": world.title,
        "source": world.source,
        "bounds_m": list(world.bounds_m),
        "start": asdict(world.start),
        "route_m": [list(point) for point in world.route_m],
        "solids": [
            {"name": s.name, "material": s.material.name, "height_m": s.height_m}
            for s in world.solids
        ],
        "parameters": dict(world.parameters),
        "notes": dict(world.notes),
    }


def _size(world: World) -> str:
    x_min, y_min, x_max, y_max = world.bounds_m
    return f"{x_max - x_min:g} x {y_max - y_min:g} m"
