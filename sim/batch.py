"""Many drives of one world, a seed each, in parallel processes."""

from __future__ import annotations

import json
import multiprocessing
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import numpy as np

from sim.simulation import simulate
from sonarmap import Cause, InputError
from sonarmap.files import atomic_path, make_folder
from worlds import World

__all__ = ["MANIFEST", "simulate_many"]

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

    Parameters
    ----------
    world : World
        The room.
    folder : str or Path
        Where ``seed-0000.parquet`` and so on, and ``manifest.json`` go.
    seeds : sequence of int
        The seeds, each >= 0, none twice.
    jobs : int
        How many processes work at once, >= 1.
    on_done : callable, optional
        Called with each seed whose log is written, for a progress bar.
    **arguments
        The other arguments of `simulate`.

    Returns
    -------
    dict
        ``world``, ``arguments`` and for each log its seed, file, readings and causes.
    """
    if jobs < 1:
        raise InputError(f"jobs must be >= 1, got {jobs!r}")
    if len(set(seeds)) != len(seeds) or not seeds:
        raise InputError(f"seeds must be at least one and none twice, got {list(seeds)!r}")
    folder = make_folder(folder)
    entries = []
    # Fresh processes: a forked one would share the engine's and the compiler's threads.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(seeds)), mp_context=context) as pool:
        futures = [pool.submit(_simulate_one, world, folder, seed, arguments) for seed in seeds]
        try:
            for future in as_completed(futures):
                entries.append(future.result())
                if on_done is not None:
                    on_done(entries[-1]["seed"])
        except BaseException:
            # On Ctrl-C or a failure what has not begun never begins.
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    manifest = {
        "world": world.name,
        "world_parameters": dict(world.parameters),
        "arguments": {name: _told(value) for name, value in arguments.items()},
        "logs": sorted(entries, key=lambda entry: entry["seed"]),
    }
    with atomic_path(folder / MANIFEST) as path:
        path.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    return manifest


def _simulate_one(
    world: World, folder: Path, seed: int, arguments: Mapping[str, Any]
) -> dict[str, Any]:
    log = simulate(world, seed=seed, **arguments)
    name = f"seed-{seed:04d}.parquet"
    log.write(folder / name)
    causes = np.bincount(log.require_truth("the manifest").cause, minlength=len(Cause))
    return {
        "seed": seed,
        "file": name,
        "readings": len(log),
        "causes": {cause.name: int(causes[cause]) for cause in Cause},
    }


def _told(value: Any) -> Any:
    return value if isinstance(value, str | int | float | bool | None) else repr(value)
