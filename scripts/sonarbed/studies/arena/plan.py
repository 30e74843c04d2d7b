"""`ArenaPlan`: in which rooms, with which sonars and seeds the entries meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import worlds
from sonarbed.studies.arena.entries import Entry
from sonarbed.studies.arena.jobs import DriveJob, Room, RunJob
from sonarmap.errors import InputError, positive, whole

__all__ = ["FIRST_SEED", "ArenaPlan", "full", "quick"]

FIRST_SEED = 1_000_000
"""Generated rooms of the arena have seeds from here on: whoever tunes or trains keeps below."""
FORMAT_VERSION = 1


@dataclass(frozen=True)
class ArenaPlan:
    """What all entries are judged on.

    Parameters
    ----------
    rooms : tuple of Room
        Shipped rooms and generated ones.
    sonars : tuple of str
        Presets.
    seeds : int
        Drives a room and sonar, seeds from 0.
    scans : int
        Length of a drive.
    resolution_m : float
        Side of a map's cell, metres.
    """

    rooms: tuple[Room, ...]
    sonars: tuple[str, ...]
    seeds: int
    scans: int
    resolution_m: float = 0.05

    def __post_init__(self) -> None:
        from sim.sonar.presets import preset

        whole("seeds", self.seeds, least=1)
        whole("scans", self.scans, least=1)
        positive("resolution_m", self.resolution_m)
        if not self.rooms or not self.sonars:
            raise InputError("the arena must have a room and a sonar")
        for name in self.sonars:
            preset(name)

    @property
    def identity(self) -> dict[str, Any]:
        """What decides the drives: a folder belongs to one of these; entries may be added."""
        return {
            "format": FORMAT_VERSION,
            "sonarbed": version("sonarbed"),
            "rooms": [room.name for room in self.rooms],
            "sonars": list(self.sonars),
            "seeds": self.seeds,
            "scans": self.scans,
            "resolution_m": self.resolution_m,
        }

    def drives(self) -> Iterator[DriveJob]:
        """Yield the drives, room by room."""
        for room in self.rooms:
            for sonar in self.sonars:
                for seed in range(self.seeds):
                    yield DriveJob(room, sonar, seed, self.scans, self.resolution_m)

    def runs(self, entries: Sequence[Entry], timeout_s: float) -> Iterator[RunJob]:
        """Yield the runs of some entries, drive by drive: what a drive needs is read once."""
        for drive in self.drives():
            for entry in entries:
                yield RunJob(drive, entry, timeout_s)


def full() -> ArenaPlan:
    """Return the table that is published: 8 shipped rooms and 24 generated ones."""
    styles = sorted(worlds.styles())
    generated = [Room(styles[k % len(styles)], FIRST_SEED + k) for k in range(24)]
    shipped = [Room(name) for name in worlds.names()]
    return ArenaPlan((*shipped, *generated), ("physical", "thesis"), seeds=3, scans=300)


def quick() -> ArenaPlan:
    """Return a table to look at before the full one: under three minutes on two cores."""
    styles = sorted(worlds.styles())
    generated = [Room(style, FIRST_SEED + k) for k, style in enumerate(styles[:2])]
    shipped = [Room(name) for name in ("office", "l-shape")]
    return ArenaPlan((*shipped, *generated), ("physical",), seeds=1, scans=100)
