"""`sonarbed simulate`: drives in known rooms."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.choices import listed, simulator
from sonarbed.options import Json, Setting, check_writable

if TYPE_CHECKING:
    from worlds import World

__all__ = ["simulate"]

# More is a slip of the pen, not a wish: their logs would fill a disk.
_MOST_SEEDS = 10_000


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
        typer.Option(
            help=f"{listed(simulator('drivers'))}; auto is the room's route, else wander."
        ),
    ] = "auto",
    sonar: Annotated[str, typer.Option(help=f"{listed(simulator('sonar_presets'))}.")] = "physical",
    packets: Annotated[
        bool,
        typer.Option(
            "--packets",
            help="Log the robot's status packets, every 100 ms, with old values repeated.",
        ),
    ] = False,
    engine: Annotated[str, typer.Option(help=f"{listed(simulator('engines'))}.")] = "bullet",
    jobs: Annotated[int, typer.Option(help="Processes, for several seeds.")] = 1,
    setting: Setting = None,
    gui: Annotated[bool, typer.Option("--gui", help="Show the engine's window.")] = False,
    as_json: Json = False,
) -> None:
    r"""Drive the simulated AmigoBot through a room and write its log with the truth.

    A driver, a sonar or an engine may be your own, as package.module:Name.

    Examples, one drive and twenty:

      sonarbed simulate thesis-exp1 --out drive.parquet

      sonarbed simulate office --driver route \
        --seed 0:20 --jobs 2 --out logs
    """
    from sonarbed.console import print_json
    from sonarbed.options import load_world
    from sonarmap import InputError

    seeds = _seeds(seed)
    if gui and ":" in seed:
        raise InputError("--gui shows one drive: give one seed")
    room = load_world(world, setting)
    arguments = {"scans": scans, "driver": driver, "sonar": sonar, "engine": engine}
    if packets:
        from sim.runs.packets import StatusPackets

        arguments["packets"] = StatusPackets()
    if ":" in seed:
        told = _many(room, out, seeds, jobs, arguments)
        logs = told["logs"]
    else:
        told = _one(room, out, seeds[0], arguments | {"gui": gui})
        logs = [told]
    if as_json:
        print_json(told)
    else:
        _print_causes(f"{room.name}: {out}, {len(seeds)} x {scans} scans", logs)


def _one(room: World, out: Path, seed: int, arguments: dict[str, Any]) -> dict[str, Any]:
    import sim
    from sim.runs.many import log_entry
    from sonarbed.console import progress

    check_writable(out)
    with progress() as bars:
        task = bars.add_task(f"{room.name}, scans", total=arguments["scans"])
        log = sim.simulate(room, seed=seed, on_scan=lambda scan: bars.advance(task), **arguments)
    log.write(out)
    return log_entry(log, seed, str(out))


def _many(
    room: World, folder: Path, seeds: range, jobs: int, arguments: dict[str, Any]
) -> dict[str, Any]:
    from sim.runs.many import simulate_many
    from sonarbed.console import progress

    with progress() as bars:
        task = bars.add_task(f"{room.name}, logs", total=len(seeds))
        return simulate_many(
            room,
            folder,
            seeds=seeds,
            jobs=jobs,
            on_done=lambda seed: bars.advance(task),
            **arguments,
        )


def _seeds(text: str) -> range:
    from sonarmap import InputError

    first, colon, last = text.partition(":")
    try:
        seeds = range(int(first), int(last) if colon else int(first) + 1)
    except ValueError:
        seeds = range(0)
    if not seeds or seeds[0] < 0:
        raise InputError(f"--seed must be a number >= 0 or a range such as 0:20, got {text!r}")
    if len(seeds) > _MOST_SEEDS:
        raise InputError(f"--seed must be at most {_MOST_SEEDS} seeds, got {text!r}")
    return seeds


def _print_causes(title: str, logs: list[dict[str, Any]]) -> None:
    from sonarbed.console import print_table, say

    readings = sum(entry["readings"] for entry in logs)
    counts = {name: sum(entry["causes"][name] for entry in logs) for name in logs[0]["causes"]}
    print_table(
        title,
        ["cause", "readings", "share"],
        [
            *(
                [name.lower().replace("_", " "), str(count), f"{count / readings:.1%}"]
                for name, count in counts.items()
            ),
            ["all", str(readings), "100.0%"],
        ],
    )
    touched = sum(entry["collision_scans"] for entry in logs)
    if touched:
        say(f"In {touched} scans the robot touched something: odometry is off.")
