"""`sonarbed score`: a map judged by the truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sonarbed.options import Json, Setting

if TYPE_CHECKING:
    from sonarmap import SonarLog
    from worlds import World

__all__ = ["score"]


def score(
    map_: Annotated[
        Path,
        typer.Argument(
            metavar="MAP",
            help="A map's folder or its map.npz, or the map.yaml of any ROS map_server pair.",
        ),
    ],
    world: Annotated[str, typer.Option(help="The room that was mapped, or its file.")],
    log: Annotated[
        Path | None,
        typer.Option(help="The log: only cells that its sonars could have observed are scored."),
    ] = None,
    setting: Setting = None,
    as_json: Json = False,
) -> None:
    """Score a map against the truth of its room.

    Example, after `sonarbed map drive.parquet --out map`:

      sonarbed score map --world thesis-exp1 --log drive.parquet
    """
    import sonarmap as sm
    import worlds
    from sonarbed.console import print_json, print_table, score_rows, working
    from sonarbed.options import load_world
    from sonarmap.mapfile import read_map_and_notes

    built, notes = read_map_and_notes(map_)
    for note in notes:
        typer.echo(note, err=True)
    room = load_world(world, setting)
    drive = None if log is None else sm.read_log(log)
    if drive is not None:
        _check_room(drive, room)
    with working("scoring"):
        truth = worlds.truth(room, built.grid)
        observable = None if drive is None else truth.observable(drive)
        scores = sm.score_map(built, truth, observable=observable).to_dict()
    if as_json:
        print_json(scores)
        return
    cells = "observable" if log is not None else "not hidden"
    print_table(
        f"{map_}: {scores['counts']['cells']} cells ({cells})",
        ["score", "map"],
        score_rows({"map": scores}),
    )


def _check_room(drive: SonarLog, room: World) -> None:
    """Refuse the log of another room: scores against a wrong truth look like any other."""
    from sonarmap import InputError

    simulated_in = drive.provenance.get("world", room.name)
    if simulated_in != room.name:
        raise InputError(f"--log must be of the world {room.name!r}, got one of {simulated_in!r}")
    parameters = dict(room.parameters)
    for name, value in drive.provenance.get("world_parameters", {}).items():
        if parameters.get(name, value) != value:
            raise InputError(
                f"--log is of a room with {name} = {value:g}, not {parameters[name]:g}: "
                f"give --set {name}={value:g}"
            )
