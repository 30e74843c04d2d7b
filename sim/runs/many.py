"""Many drives of one world, a seed each, in parallel."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from sim.runs.arguments import DriveArguments
from sim.runs.batch.drives import BatchDrive, simulate_batch
from sim.runs.compiled.drive import runs_compiled
from sim.runs.parallel import checked_jobs, run_all, stop_if_cancelled
from sim.runs.simulation import simulate
from sonarmap import Cause, InputError, SonarLog
from sonarmap.account import account_of, contacts_of
from sonarmap.errors import whole
from sonarmap.files import atomic_path, make_folder
from worlds import World

__all__ = ["MANIFEST", "log_entry", "simulate_many"]

MANIFEST = "manifest.json"


def simulate_many(
    world: World,
    folder: str | Path,
    *,
    seeds: Sequence[int],
    jobs: int = 1,
    on_done: Callable[[int], None] | None = None,
    **arguments: Any,
) -> dict[str, Any]:
    """Simulate a log for each seed into `folder` and return the manifest written beside them.

    Each log is that of `simulate`. Drives that run compiled, on the engine "segments", are shared
    out to threads, see `simulate_batch`, which also takes a room, a driver and a sonar for each;
    others to processes.

    Parameters
    ----------
    world : World
        The room.
    folder : str or Path
        Where ``seed-0000.parquet`` and so on, and ``manifest.json`` go.
    seeds : sequence of int
        The seeds, each >= 0, none twice.
    jobs : int
        How many processes work at once, >= 1; of compiled drives, threads.
    on_done : callable, optional
        Called with each seed whose log is written, for a progress bar.
    **arguments
        The other arguments of `simulate`, but `on_scan`.

    Returns
    -------
    dict
        ``world``, ``world_parameters``, ``arguments`` and ``logs``: of each what `log_entry`
        tells.
    """
    jobs, seeds = checked_jobs(jobs), _checked_seeds(seeds)
    # Refused here, not by the first process that works.
    asked = DriveArguments.of(world, seed=seeds[0], **arguments)
    folder = make_folder(folder)
    entries: dict[int, dict[str, Any]] = {}

    def done(index: int) -> None:
        if on_done is not None:
            on_done(seeds[index])

    try:
        if runs_compiled(asked):
            drives = (_batch_drive(asked, seed) for seed in seeds)
            for index, log in simulate_batch(drives, workers=jobs):
                entries[index] = _written(log, folder, seeds[index])
                done(index)
        else:
            one = partial(_simulate_one, world, folder, arguments)
            run_all(one, seeds, entries, jobs=jobs, on_done=done)
    finally:
        # Also after an interruption: the manifest lists the logs that are there.
        manifest = {
            "world": world.name,
            "world_parameters": dict(world.parameters),
            "arguments": {name: _plain(value) for name, value in arguments.items()},
            "logs": sorted(entries.values(), key=lambda entry: entry["seed"]),
        }
        if entries:
            with atomic_path(folder / MANIFEST) as path:
                path.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    return manifest


def _checked_seeds(seeds: Any) -> list[int]:
    if isinstance(seeds, str) or not hasattr(seeds, "__len__"):
        raise InputError(f"seeds must be whole numbers such as range(10), got {seeds!r}")
    numbers = [whole(f"seeds[{place}]", seed, least=0) for place, seed in enumerate(seeds)]
    if len(set(numbers)) != len(numbers) or not numbers:
        raise InputError(f"seeds must be at least one and none twice, got {numbers!r}")
    return numbers


def log_entry(log: SonarLog, seed: int, file: str) -> dict[str, Any]:
    """Return what a manifest records of a simulated log.

    Its seed, file and scans, of status packets their number too; the readings of the log and how
    many of them are new, for packets repeat old ones; of the new ones how many have no echo or are
    too close, and their causes; and in how many scans, or packets, the robot touched something.
    """
    truth = log.require_truth("the manifest")
    new, contacts = ~log.stale, contacts_of(log)
    assert contacts is not None, "a log with truth"
    causes = np.bincount(truth.cause[new], minlength=len(Cause))
    return {
        "seed": seed,
        "file": file,
        "scans": log.provenance["scans"],
        **({"packets": contacts.of} if contacts.unit == "packets" else {}),
        "readings": len(log),
        "account": account_of(log, new).to_dict(),
        "no_echo": int((log.range_m[new] == np.inf).sum()),
        "too_close": int((log.range_m[new] == -np.inf).sum()),
        "causes": {cause.name: int(causes[cause]) for cause in Cause},
        **contacts.to_dict(),
    }


def _simulate_one(
    world: World, folder: Path, arguments: Mapping[str, Any], seed: int
) -> dict[str, Any]:
    log = simulate(world, seed=seed, on_scan=lambda scan: stop_if_cancelled(), **arguments)
    return _written(log, folder, seed)


def _batch_drive(asked: DriveArguments, seed: int) -> BatchDrive:
    return BatchDrive(
        asked.world, asked.scans, seed, asked.driver, asked.sonar, odometry=asked.odometry
    )


def _written(log: SonarLog, folder: Path, seed: int) -> dict[str, Any]:
    """Write a log and return what the manifest tells of it."""
    name = f"seed-{seed:04d}.parquet"
    log.write(folder / name)
    return log_entry(log, seed, name)


def _plain(value: Any) -> Any:
    plain = value.item() if isinstance(value, np.generic) else value
    return plain if isinstance(plain, str | int | float | bool | None) else repr(plain)
