"""The jobs of the arena: a drive, and an entry's run on it."""

from __future__ import annotations

import json
import math
import re
import signal
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sim
import sonarmap as sm
import worlds
from sim.runs.jobs import Store, digest_of, open_store
from sim.runs.jobs.job import DIGITS
from sonarbed.studies.arena.entries import Entry
from sonarmap import InputError, SonarLog

__all__ = ["DriveJob", "Room", "RunJob", "Seen", "grid_of", "seen_of"]

# The world's own bounds would give its walls away: the grid reaches so much farther, and some of
# this more, drawn, on each side.
_PADDING_M, _MORE_M = 1.5, 0.5
# A stream of its own for the grid.
_GRID_STREAM = 7
# Where a function lies in memory is no parameter of it.
_ADDRESS = re.compile(r" at 0x[0-9a-f]+")


@dataclass(frozen=True)
class Room:
    """A shipped room by its name, or a generated one by its style and seed.

    Parameters
    ----------
    key : str
        The name, or the style.
    seed : int or None
        Of the generated room.
    """

    key: str
    seed: int | None = None

    @property
    def name(self) -> str:
        """What tables call it."""
        return self.key if self.seed is None else f"{self.key}-{self.seed}"

    @property
    def group(self) -> str:
        """Whether it ships or is generated."""
        return "shipped" if self.seed is None else "generated"

    def world(self) -> worlds.World:
        """Return the room."""
        return worlds.load(self.key) if self.seed is None else worlds.generate(self.key, self.seed)


@dataclass(frozen=True)
class DriveJob:
    """Simulate a drive.

    Parameters
    ----------
    room : Room
        Where.
    sonar : str
        Preset.
    seed, scans : int
        Of the drive.
    resolution_m : float
        Side of the cells that its maps will have, metres.
    """

    room: Room
    sonar: str
    seed: int
    scans: int
    resolution_m: float

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"{self.room.name}, {self.sonar}, seed {self.seed}"

    @property
    def description(self) -> Mapping[str, Any]:
        """All that decides its log."""
        return {
            "room": self.room.name,
            "sonar": self.sonar,
            "seed": self.seed,
            "scans": self.scans,
            "resolution_m": self.resolution_m,
            "sonarbed": version("sonarbed"),
        }

    @cached_property
    def digest(self) -> str:
        """Digest of the description."""
        return digest_of(self.description)[:DIGITS]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Its log."""
        return (f"drives/{self.room.name}-{self.sonar}-{self.seed:03d}-{self.digest}.parquet",)

    def run(self, store: Store) -> int:
        """Simulate and write the log."""
        log = sim.simulate(
            self.room.world(),
            scans=self.scans,
            seed=self.seed,
            sonar=self.sonar,
            engine="segments",
        )
        with store.writing(self.outputs[0]) as path:
            log.write(path)
        return len(log)


@dataclass(frozen=True)
class RunJob:
    """Let an entry map a drive, and judge the map.

    Parameters
    ----------
    drive : DriveJob
        Which drive; its log is there.
    entry : Entry
        Who maps.
    timeout_s : float
        How long it may take, seconds.
    """

    drive: DriveJob
    entry: Entry
    timeout_s: float

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"{self.entry.label} on {self.drive.label}"

    @property
    def description(self) -> Mapping[str, Any]:
        """All that decides its row."""
        return {
            "drive": dict(self.drive.description),
            "method": self.entry.method,
            "filter": self.entry.filter,
            "parameters": _parameters(self.entry),
            # Two that come out alike are two all the same.
            **({} if self.entry.variant == "published" else {"variant": self.entry.variant}),
        }

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Its row."""
        return (f"runs/{self.drive.digest}/{digest_of(self.description)[:DIGITS]}.json",)

    def run(self, store: Store) -> int:
        """Map, judge, and write the row."""
        seen = _drive_there(store, self.drive)
        filter_, method = self.entry.made()
        given = seen.log if self.entry.is_oracle else seen.blind
        before = _fingerprint(given)
        # Processor time: what else runs on the machine does not count.
        begin = time.process_time()
        with _limited(self.timeout_s):
            filtered = filter_.apply(given)
            shown = filtered.log.replace(truth=None)
            mapped = _fingerprint(shown)
            built = method.map(shown, seen.truth.grid)
        seconds = time.process_time() - begin
        if (_fingerprint(given), _fingerprint(shown)) != (before, mapped):
            raise InputError(f"{self.entry.label} has changed the log that it was given")
        score = sm.score_map(built, seen.truth, observable=seen.observable)
        paths = sm.score_paths(built, seen.truth, observable=seen.observable)
        told = score.to_dict()
        readings = sm.score_readings(seen.log, filtered.log.replace(truth=seen.log.truth))
        row = {
            "room": self.drive.room.name,
            "group": self.drive.room.group,
            "sonar": self.drive.sonar,
            "seed": self.drive.seed,
            "scans": self.drive.scans,
            "entry": self.entry.label,
            "method": self.entry.method,
            "filter": self.entry.filter,
            "variant": self.entry.variant,
            "seconds": seconds,
            "cells": score.cells,
            "walls": score.truth_occupied,
            "loss_bits": score.loss_bits,
            "sheet_loss_bits": score.sheet_loss_bits,
            "wrong_share": seen.wrong_share,
            **{name: value for name, value in told.items() if name != "counts"},
            **{f"paths_{name}": value for name, value in paths.to_dict().items()},
            **{f"readings_{name}": value for name, value in _numbers(readings.to_dict()).items()},
        }
        with store.writing(self.outputs[0]) as path:
            path.write_text(json.dumps(row, sort_keys=True) + "\n", encoding="utf-8")
        return len(seen.log)


@dataclass(frozen=True, eq=False)
class Seen:
    """A drive with what is shown of it, and what is not.

    Parameters
    ----------
    log, blind : SonarLog
        With truth, and as entries are given it.
    truth : TruthGrid
        Of the grid that the maps have.
    observable : ndarray of bool
        The cells that are judged.
    wrong_share : float
        Of the readings.
    """

    log: SonarLog
    blind: SonarLog
    truth: worlds.TruthGrid
    observable: NDArray[np.bool_]
    wrong_share: float


# Runs come drive by drive, so that a worker reads each once or twice.
@lru_cache(maxsize=4)
def _drive_there(store: Store, drive: DriveJob) -> Seen:
    with store.reading(drive.outputs[0]) as file:
        data = file.read()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.parquet"
        path.write_bytes(data)
        log = sm.read_log(path)
    world = drive.room.world()
    grid = grid_of(world, drive)
    truth = worlds.truth(world, grid)
    known = log.require_truth("the arena")
    wrong = ~np.isin(known.cause, [cause.value for cause in sm.Cause if cause.is_right])
    blind = log.replace(truth=None, provenance={})
    return Seen(log, blind, truth, truth.observable(log), float(wrong.mean()))


def seen_of(drive: DriveJob, folder: str | Path) -> Seen:
    """Return a drive of an arena's folder."""
    return _drive_there(open_store(folder), drive)


def grid_of(world: worlds.World, drive: DriveJob) -> sm.GridSpec:
    """Return a grid whose edges do not tell where the walls are."""
    rng = np.random.default_rng([drive.seed, _GRID_STREAM, *drive.room.name.encode()])
    left, bottom, right, top = _PADDING_M + rng.uniform(0, _MORE_M, 4)
    x_min, y_min, x_max, y_max = world.bounds_m
    size = drive.resolution_m
    # On no lattice: walls at whole decimetres would lie on the cells' edges.
    shape = (
        math.ceil((y_max + top - (y_min - bottom)) / size),
        math.ceil((x_max + right - (x_min - left)) / size),
    )
    return sm.GridSpec(size, (x_min - left, y_min - bottom), shape)


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    """Raise `InputError` in the block after so many seconds, as far as Python is asked.

    Compiled code that never returns is not stopped; nor is anything beside the main thread.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or not hasattr(signal, "setitimer"):
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise InputError(f"took longer than the {seconds:g} s of --timeout")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _fingerprint(log: SonarLog) -> str:
    digest = sha256()
    for name in SonarLog.DTYPES:
        digest.update(np.ascontiguousarray(getattr(log, name)).tobytes())
    return digest.hexdigest()


def _parameters(entry: Entry) -> str:
    """Return the parameters as text: another default is another run."""
    text = repr(entry.made())
    return _ADDRESS.sub("", text)


def _numbers(told: Mapping[str, Any]) -> dict[str, float | None]:
    return {
        name: value
        for name, value in told.items()
        if value is None or isinstance(value, int | float)
    }
