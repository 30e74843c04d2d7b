"""`sonarbed simulate`: drives in known rooms."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.options import Json, Setting

if TYPE_CHECKING:
    from worlds import World

__all__ = ["simulate"]


def simulate(
    world: Annotated[str, typer.Argument(help="A room (see `sonarbed worlds`) or a world file.")],
    out: Annotated[
        Path, typer.Option(help="The log to write (Parquet); for several seeds a folder.")
    ],
    seed: Annotated[
        str, typer.Option(metavar="SEED|FROM:TO", help="A seed, or a range, TO not included.")
    ] = "0",
    scans: Annotated[int, typer.Option(help="How many scans to take.")] = 500,
    driver: Annotated[
        str,
        typer.Option(help="thesis, straight, route, follow-left, follow-right or wander."),
    ] = "thesis",
    sonar: Annotated[str, typer.Option(help="thesis or aria.")] = "thesis",
    engine: Annotated[str, typer.Option(help="bullet.")] = "bullet",
    jobs: Annotated[int, typer.Option(help="Processes, for several seeds.")] = 1,
    setting: Setting = None,
    gui: Annotated[bool, typer.Option("--gui", help="Show the engine's window.")] = False,
    as_json: Json = False,
) -> None:
    """Drive the simulated AmigoBot through a room and write its log with the truth.

    Example: sonarbed simulate office --driver route --seed 0:20 --jobs 2 --out logs
    """
    from sonarbed.options import load_world

    room = load_world(world, setting)
    arguments = {"scans": scans, "driver": driver, "sonar": sonar, "engine": engine}
    seeds = _seeds(seed)
    if ":" in seed:
        _many(room, out, seeds, jobs, arguments, as_json)
    else:
        _one(room, out, seeds[0], arguments | {"gui": gui}, as_json)


def _one(room: World, out: Path, seed: int, arguments: dict[str, Any], as_json: bool) -> None:
    import sim
    from sonarbed.console import print_json, progress
    from sonarmap.files import atomic_path

    # Found out before the drive, not after it: whether the log can be written there.
    with atomic_path(out) as beside:
        with progress(shown=not as_json) as bars:
            task = bars.add_task(f"{room.name}, scans", total=arguments["scans"])
            log = sim.simulate(
                room, seed=seed, on_scan=lambda scan: bars.update(task, advance=1), **arguments
            )
        log.write(beside)
    entry = {"seed": seed, "file": str(out), "readings": len(log), "causes": _causes(log)}
    if as_json:
        print_json(entry)
    else:
        _print_causes(room.name, [entry])


def _many(
    room: World,
    folder: Path,
    seeds: list[int],
    jobs: int,
    arguments: dict[str, Any],
    as_json: bool,
) -> None:
    from sim.batch import simulate_many
    from sonarbed.console import print_json, progress

    with progress(shown=not as_json) as bars:
        task = bars.add_task(f"{room.name}, logs", total=len(seeds))
        manifest = simulate_many(
            room,
            folder,
            seeds=seeds,
            jobs=jobs,
            on_done=lambda seed: bars.update(task, advance=1),
            **arguments,
        )
    if as_json:
        print_json(manifest)
    else:
        _print_causes(room.name, manifest["logs"])


def _seeds(text: str) -> list[int]:
    from sonarmap.errors import InputError

    first, colon, last = text.partition(":")
    try:
        seeds = list(range(int(first), int(last))) if colon else [int(first)]
    except ValueError:
        seeds = []
    if not seeds or seeds[0] < 0:
        raise InputError(f"--seed must be a number >= 0 or a range such as 0:20, got {text!r}")
    return seeds


def _causes(log: Any) -> dict[str, int]:
    from sonarmap import Cause

    return {cause.name: int((log.truth.cause == cause).sum()) for cause in Cause}


def _print_causes(room: str, entries: list[dict[str, Any]]) -> None:
    from sonarbed.console import print_table

    causes = list(entries[0]["causes"])
    print_table(
        f"{room}: readings by cause",
        ["file", "readings", *(name.lower().replace("_", " ") for name in causes)],
        [
            [
                str(entry["file"]),
                str(entry["readings"]),
                *(f"{entry['causes'][name] / entry['readings']:.1%}" for name in causes),
            ]
            for entry in entries
        ],
    )
