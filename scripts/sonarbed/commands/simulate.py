"""`sonarbed simulate`: drives in known rooms."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.choices import listed, simulator
from sonarbed.options import Json, Setting, check_log_out

if TYPE_CHECKING:
    from sonarmap.account import ContactAccount, ReadingAccount
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
            help=f"{listed(simulator('drivers'))}. Auto is the room's route, else wander."
        ),
    ] = "auto",
    sonar: Annotated[str, typer.Option(help=f"{listed(simulator('sonar_presets'))}.")] = "physical",
    ring: Annotated[
        str | None,
        typer.Option(
            help="Another ring for the sonars: a name (see `sonarbed rings`) or a TOML file."
        ),
    ] = None,
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
    arguments = {"scans": scans, "driver": driver, "sonar": sonar, "ring": ring, "engine": engine}
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
        in_packets = f" in {_sum(logs, 'packets')} packets" if packets else ""
        _print_causes(f"{room.name}: {out}, {len(seeds)} x {scans} scans{in_packets}", logs)


def _one(room: World, out: Path, seed: int, arguments: dict[str, Any]) -> dict[str, Any]:
    import sim
    from sim.runs.arguments import DriveArguments
    from sim.runs.many import log_entry
    from sonarbed.console import progress

    DriveArguments.of(room, seed=seed, **arguments)  # before a folder is made for the log
    check_log_out(out)
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

    # What `int` takes besides, as "1_0" or " 1", is a slip of the pen.
    found = re.fullmatch(r"([0-9]{1,100})(?::([0-9]{1,100}))?", text)
    first, last = (0, 0) if found is None else (int(found[1]), int(found[2] or int(found[1]) + 1))
    if first >= last:
        raise InputError(
            f"--seed must be a whole number >= 0 or a range such as 0:20, got {text!r}"
        )
    if last - first > _MOST_SEEDS:
        raise InputError(f"--seed must be at most {_MOST_SEEDS} seeds, got {text!r}")
    return range(first, last)


def _sum(logs: list[dict[str, Any]], name: str) -> int:
    return sum(entry[name] for entry in logs)


def _print_causes(title: str, logs: list[dict[str, Any]]) -> None:
    from sonarbed.console import print_table, say

    account, contacts = _accounts(logs)
    counts = {name: sum(entry["causes"][name] for entry in logs) for name in logs[0]["causes"]}
    counts |= {"all": account.used}
    counts |= {f"  {name}": _sum(logs, name) for name in ("no_echo", "too_close")}
    print_table(
        title,
        ["cause", "readings", "share"],
        [
            [name.lower().replace("_", " "), str(count), f"{count / account.used:.1%}"]
            for name, count in counts.items()
        ],
    )
    if account.unused:
        say(f"{account}.")
    if contacts.touched:
        say(str(contacts))


def _accounts(logs: list[dict[str, Any]]) -> tuple[ReadingAccount, ContactAccount]:
    """Return what became of the readings of all logs, and how often the robot touched something."""
    from sonarmap.account import ContactAccount, ReadingAccount

    unit = "packets" if "packets" in logs[0] else "scans"
    return (
        sum(
            (
                ReadingAccount(
                    entry["account"]["in_log"],
                    entry["account"]["used"],
                    {n.replace("_", " "): c for n, c in entry["account"]["unused"].items()},
                )
                for entry in logs
            ),
            ReadingAccount(0, 0, {}),
        ),
        ContactAccount(_sum(logs, f"collision_{unit}"), _sum(logs, unit), unit),
    )
