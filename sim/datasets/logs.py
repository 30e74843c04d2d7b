"""The job that takes one log of a data set."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from sim.datasets.parts import SONAR_FIELDS, make_driver, make_sonar, odometry_of, packets_of
from sim.datasets.rooms import RoomSource, StoredRoom, pose_anywhere, stored_room
from sim.runs.jobs import Store, digest_of
from sim.runs.jobs.job import DIGITS
from sim.runs.simulation import simulate
from sim.sonar.protocol import Sonar
from sonarmap import Cause, LogTruth, SonarLog, SonarRing
from sonarmap.parquet import write_columns
from worlds import World

__all__ = ["LOG_COLUMN", "RECORD", "LogJob"]

LOG_COLUMN = "log"
"""The column that tells logs apart when many files are read as one table."""
RECORD = "dataset"
"""Where the provenance of a log has what the manifest says of it."""


@dataclass(frozen=True)
class LogJob:
    """Take a log.

    Parameters
    ----------
    room : RoomSource
        Where.
    split : str
        To which split the room belongs.
    number : int
        Which log of the room, from 0.
    seed : int
        Of all that is random in the drive.
    settings : tuple of (key, value)
        What was chosen and drawn for it.
    ring : SonarRing or None
        Its ring; None for that of the sonar.
    """

    room: RoomSource
    split: str
    number: int
    seed: int
    settings: tuple[tuple[str, Any], ...]
    ring: SonarRing | None = None

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"room {self.room.name}, log {self.number:05d}, seed {self.seed}"

    @property
    def description(self) -> Mapping[str, Any]:
        """All that decides its readings."""
        return {
            "room": self.room.name,
            "key": self.room.key,
            "number": self.number,
            "seed": self.seed,
            "settings": dict(self.settings),
            "ring": None if self.ring is None else self.ring.to_dict(),
            "sonarbed": version_here(),
        }

    @cached_property
    def digest(self) -> str:
        """Digest of the description."""
        return digest_of(self.description)

    @property
    def log_id(self) -> str:
        """What the log is called in the columns of the data set."""
        return self.digest[:DIGITS]

    @property
    def outputs(self) -> tuple[str, ...]:
        """Its file, in partitions as Hive names them."""
        folder = f"logs/split={self.split}/room={self.room.name}"
        return (f"{folder}/{self.number:05d}-{self.log_id}.parquet",)

    def run(self, store: Store) -> int:
        """Simulate the drive and write its log."""
        settings = dict(self.settings)
        room = stored_room(store, self.room.file, self.room.key)
        log = simulate(
            self._world(room, settings),
            scans=settings["scans"],
            seed=self.seed,
            driver=make_driver(settings, room.world),
            sonar=_sonar(self.settings, self.ring),
            engine=settings["engine"],
            odometry=odometry_of(settings),
            packets=packets_of(settings),
        )
        log = log.replace(provenance={**log.provenance, RECORD: self._record(log, room)})
        with store.writing(self.outputs[0]) as path:
            _write(log, path, self.log_id)
        return len(log)

    def _world(self, room: StoredRoom, settings: Mapping[str, Any]) -> World:
        if settings["start"] == "room":
            return room.world
        # A stream of its own: what the drive draws does not depend on where it begins.
        pose = pose_anywhere(room, np.random.default_rng([self.seed, 1]))
        world = dataclasses.replace(room.world, start=pose)
        world.__dict__["faces"] = room.world.faces  # the start changes nothing of them
        return world

    def _record(self, log: SonarLog, room: StoredRoom) -> dict[str, Any]:
        """Return what the manifest says of a log."""
        truth = log.require_truth("the manifest")
        causes = np.bincount(truth.cause, minlength=len(Cause))
        settings = dict(self.settings)
        return {
            "log": self.log_id,
            "file": self.outputs[0],
            "split": self.split,
            "room": self.room.name,
            "number": self.number,
            "seed": self.seed,
            "driver": settings["driver"],
            "sonar": settings["sonar"],
            "ring": log.ring.name,
            "sonars": len(log.ring),
            "engine": settings["engine"],
            "scans": int(np.unique(log.scan).size),
            "readings": len(log),
            "duration_s": float(log.time_s[-1] - log.time_s[0]),
            "path_m": float(np.hypot(np.diff(truth.x_m), np.diff(truth.y_m)).sum()),
            "collision_scans": int(np.unique(log.scan[truth.collision]).size),
            **{cause.name.lower(): int(causes[cause]) for cause in Cause},
            "settings": settings,
            "room_sha256": room.sha256,
            "digest": self.digest,
            "sonarbed": version_here(),
        }


@lru_cache(maxsize=1)
def version_here() -> str:
    """Return the version that takes the logs; asked for once, for it reads a file."""
    return version("sonarbed")


def _sonar(settings: tuple[tuple[str, Any], ...], ring: SonarRing | None) -> Sonar:
    tables = ("sonar", "air.", "sonar_parameters.", *(f"{table}." for table in SONAR_FIELDS))
    return _sonar_of(tuple(pair for pair in settings if pair[0].startswith(tables)), ring)


# A physical sonar computes tables of its beam: logs in a row often have the same one.
@lru_cache(maxsize=8)
def _sonar_of(settings: tuple[tuple[str, Any], ...], ring: SonarRing | None) -> Sonar:
    return make_sonar(dict(settings), ring)


def _write(log: SonarLog, path: Path, log_id: str) -> None:
    """Write a log as `SonarLog.write` does, with a column that names it."""
    assert log.truth is not None, "a simulated log has truth"
    columns = {LOG_COLUMN: np.full(len(log), log_id)}
    columns |= {name: getattr(log, name) for name in SonarLog.DTYPES}
    columns |= {LogTruth.PREFIX + name: getattr(log.truth, name) for name in LogTruth.DTYPES}
    write_columns(path, columns, ring=log.ring.to_dict(), provenance=dict(log.provenance))
