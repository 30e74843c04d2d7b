"""`sonarbed score`: a map judged by the truth."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from sonarbed.options import Json, Setting

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sonarmap import OccupancyMap, SonarLog
    from worlds import TruthGrid, World

__all__ = ["score"]

# Readings that pass the walls by mirrors spread a map beyond its room: in ours up to 80 % with the
# physical sonar. Below this nobody need wonder.
_MUCH_OUTSIDE = 0.25
_BY_ODOMETRY = (
    "Which cells were observable follows from the poses of odometry, the log's own: their errors "
    "count as errors of the map."
)


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
        typer.Option(
            help="The log: only cells that its sonars could have observed are scored, from the "
            "true poses of a simulated log, by odometry of a real one."
        ),
    ] = None,
    align: Annotated[
        bool,
        typer.Option(
            "--align",
            help="Find where the frame of the log and its map lies in the room; by odometry.",
        ),
    ] = False,
    seed: Annotated[int, typer.Option(help="Seed of the alignment.")] = 0,
    setting: Setting = None,
    as_json: Json = False,
) -> None:
    """Score a map against the truth of its room.

    Example, after `sonarbed map drive.parquet --out map`:

      sonarbed score map --world thesis-exp1 --log drive.parquet
    """
    import sonarmap as sm
    import worlds
    from sonarbed.console import print_json, print_table, say, score_rows, working
    from sonarbed.options import load_world
    from sonarmap.account import contacts_of
    from sonarmap.mapfile import read_map_and_notes

    built, notes = read_map_and_notes(map_)
    room = load_world(world, setting)
    drive = None if log is None else sm.read_log(log)
    contacts, motion = None, None
    poses: Literal["true", "odometry"] | None = None
    if align:
        if drive is None:
            raise sm.InputError("--align compares the readings with the room: give their --log")
        with working("aligning"):
            motion = worlds.align(drive, room, seed=seed)
        room = motion.world_in_log_frame(room)
        notes += (f"Aligned: {motion}.",)
    if drive is not None:
        _check_room(drive, room)
        poses = "odometry" if align or drive.truth is None else "true"
        if poses == "odometry":
            notes += (_BY_ODOMETRY,)
        contacts = contacts_of(drive)
        notes += (str(contacts),) if contacts is not None and contacts.touched else ()
    with working("scoring"):
        truth = worlds.truth(room, built.grid)
        observable = (
            None if drive is None or poses is None else truth.observable(drive, poses=poses)
        )
        scores = sm.score_map(built, truth, observable=observable).to_dict()
    outside = _share_outside(built, room)
    if outside > _MUCH_OUTSIDE:
        note = (
            f"{outside:.0%} of what the map knows lies outside of the bounds of {room.name!r}: its "
            "frame is not the room's, or readings went past the walls. Only what lies in the room "
            "is scored."
        )
        notes += (note,)
    for note in notes:
        typer.echo(note, err=True)
    cells = _cells(truth, observable)
    if as_json:
        print_json(
            {
                **scores,
                "cells": cells,
                "known_outside_share": outside,
                **({} if poses is None else {"poses": poses}),
                **({} if motion is None else {"alignment": motion.to_dict()}),
                **({} if contacts is None else contacts.to_dict()),
                **({"notes": list(notes)} if notes else {}),
            }
        )
        return
    kind = "not hidden" if log is None else f"observable, poses {poses}"
    print_table(
        f"{map_}: {scores['counts']['cells']} cells ({kind})",
        ["score", "map"],
        score_rows({"map": scores}),
    )
    not_scored = ", ".join(f"{n} {why.replace('_', ' ')}" for why, n in cells["unused"].items())
    say(f"{cells['used']} of {cells['in_map']} cells scored; not scored: {not_scored or 'none'}")


def _cells(truth: TruthGrid, observable: NDArray[np.bool_] | None) -> dict[str, Any]:
    """Return what became of the cells of a map: how many are scored, and why the others not."""
    from worlds import HIDDEN

    hidden = int((truth.state == HIDDEN).sum())
    whole = int(truth.state.size)
    used = whole - hidden if observable is None else int(observable.sum())
    unused = {"hidden": hidden, "never_observable": whole - hidden - used}
    return {"in_map": whole, "used": used, "unused": {why: n for why, n in unused.items() if n}}


def _share_outside(built: OccupancyMap, room: World) -> float:
    """Return how much of what a map calls free or occupied lies outside of a room's bounds."""
    import numpy as np

    rows, cols = np.nonzero(built.free | built.occupied)
    if not rows.size:
        return 0.0
    (x_m, y_m), size = built.grid.origin_xy_m, built.grid.resolution_m
    x_min, y_min, x_max, y_max = room.bounds_m
    # A cell that the bounds cut belongs to the room.
    left, bottom = x_m + cols * size, y_m + rows * size
    outside = (left > x_max) | (left + size < x_min) | (bottom > y_max) | (bottom + size < y_min)
    return float(outside.mean())


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
