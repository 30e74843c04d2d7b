"""Many drives of one world, a seed each, in parallel processes."""

from __future__ import annotations

import json
import multiprocessing
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

import numpy as np

from sim.simulation import simulate
from sonarmap import Cause, InputError, SonarLog
from sonarmap.files import atomic_path, make_folder
from worlds import World

__all__ = ["MANIFEST", "deaf_children", "log_entry", "simulate_many"]

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
        The other arguments of `simulate`, but `on_scan`.

    Returns
    -------
    dict
        ``world``, ``world_parameters``, ``arguments`` and ``logs``: of each its seed, file,
        readings, readings by cause, and in how many scans the robot touched something.
    """
    if jobs < 1:
        raise InputError(f"jobs must be >= 1, got {jobs!r}")
    if len(set(seeds)) != len(seeds) or not seeds:
        raise InputError(f"seeds must be at least one and none twice, got {list(seeds)!r}")
    folder = make_folder(folder)
    # Fresh processes: a forked one would share the engine's and the compiler's threads.
    context = multiprocessing.get_context("spawn")
    # Made before any process: the first of its kind starts a helper that unblocks signals.
    stop = context.Event()
    futures: list[Future[dict[str, Any]]] = []
    try:
        with ProcessPoolExecutor(min(jobs, len(seeds)), context, _begin, (stop,)) as pool:
            try:
                with deaf_children():
                    for seed in seeds:
                        futures.append(pool.submit(_simulate_one, world, folder, seed, arguments))
                for future in as_completed(futures):
                    done = future.result()
                    if on_done is not None:
                        on_done(done["seed"])
            except BaseException:
                # On Ctrl-C or a failure what has begun stops, and the rest never begins.
                stop.set()
                pool.shutdown(cancel_futures=True)
                raise
    except BrokenProcessPool:
        raise InputError("a process was killed (out of memory?): give it fewer jobs") from None
    finally:
        # Also after an interruption: the manifest tells of the logs that are there.
        manifest = {
            "world": world.name,
            "world_parameters": dict(world.parameters),
            "arguments": {name: _told(value) for name, value in arguments.items()},
            "logs": sorted(
                (future.result() for future in futures if _succeeded(future)),
                key=lambda entry: entry["seed"],
            ),
        }
        if manifest["logs"]:
            with atomic_path(folder / MANIFEST) as path:
                path.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    return manifest


def log_entry(log: SonarLog, seed: int, file: str) -> dict[str, Any]:
    """Return what a manifest tells of a simulated log, see `simulate_many`."""
    truth = log.require_truth("the manifest")
    causes = np.bincount(truth.cause, minlength=len(Cause))
    return {
        "seed": seed,
        "file": file,
        "readings": len(log),
        "causes": {cause.name: int(causes[cause]) for cause in Cause},
        "collision_scans": int(np.unique(log.scan[truth.collision]).size),
    }


# Set in a worker process: the parent's signal to stop.
_stop: Event | None = None


def _begin(stop: Event) -> None:
    global _stop
    _stop = stop


class _Stopped(Exception):  # noqa: N818 - nobody sees it: its future is dropped
    """The parent does not want this drive any more."""


def _stop_if_told(scan: int) -> None:
    if _stop is not None and _stop.is_set():
        raise _Stopped


@contextmanager
def deaf_children() -> Iterator[None]:
    """Let processes that begin in the block never hear Ctrl-C, from their first line on.

    A terminal sends it to all processes; it is for the parent, which tells the others to stop.
    They inherit the parent's mask of signals. For the parent it waits for the end of the block:
    it must not meet a process half begun, nor be lost, as with `signal.SIG_IGN`.
    """
    can_mask = hasattr(signal, "pthread_sigmask")
    is_main = threading.current_thread() is threading.main_thread()
    heard: list[int] = []
    if is_main:
        # The mask alone is not enough: threads of numerical libraries have their own.
        handler = signal.signal(signal.SIGINT, lambda number, frame: heard.append(number))
    if can_mask:
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if can_mask:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if is_main:
            signal.signal(signal.SIGINT, handler)
    if heard:
        signal.raise_signal(signal.SIGINT)


def _succeeded(future: Future[dict[str, Any]]) -> bool:
    return future.done() and not future.cancelled() and future.exception() is None


def _simulate_one(
    world: World, folder: Path, seed: int, arguments: Mapping[str, Any]
) -> dict[str, Any]:
    log = simulate(world, seed=seed, on_scan=_stop_if_told, **arguments)
    name = f"seed-{seed:04d}.parquet"
    log.write(folder / name)
    return log_entry(log, seed, name)


def _told(value: Any) -> Any:
    return value if isinstance(value, str | int | float | bool | None) else repr(value)
