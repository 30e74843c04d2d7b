"""The drives that a search scores: simulated once, kept as Parquet, loaded once a process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.studies.tuning.space import Candidate
from sonarmap.errors import InputError

__all__ = ["SCORES", "Drive", "DriveName", "load_drives", "simulate_drive"]

# Scores by name, and whether a higher one is better.
SCORES = MappingProxyType({"map_score": True, "f1_10_cm": True, "brier": False})
_TEN_CM = 1  # index of the tolerance
# Where a drive's provenance says what it was made for.
_KEY = "tuning"


@dataclass(frozen=True)
class DriveName:
    """Which drive: everything that decides its readings."""

    room: str
    driver: str
    scans: int
    seed: int

    @classmethod
    def of(cls, room: str, *, scans: int, seed: int) -> DriveName:
        """Return the drive of a room: along its route, if it has one, else as in the thesis."""
        return cls(room, _driver(room), scans, seed)

    @property
    def file(self) -> str:
        """Name of its file."""
        return f"{self.room}-{self.driver}-{self.scans}-{self.seed:04d}.parquet"

    def to_dict(self) -> dict[str, str | int]:
        """Return what its provenance says, with the version that made it."""
        return {**asdict(self), "sonarbed": version("sonarbed")}


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive with the truth that its maps are scored by."""

    name: DriveName
    log: sm.SonarLog
    truth: worlds.TruthGrid
    observable: NDArray[np.bool_]

    def score(self, candidate: Candidate, score: str, max_range_m: float | None) -> float:
        """Return the score, over observable cells, of the map that a candidate makes."""
        log, hsr = self.log, candidate.hsr
        # Where no reading is within the threshold there is nothing to learn from: HSR is idle.
        if hsr is not None and ((log.range_m >= 0) & (log.range_m <= hsr.threshold_m)).any():
            log = sm.hsr(log, hsr).log
        built = sm.build_map(log, candidate.model, self.truth.grid, max_range_m=max_range_m)
        scored = sm.score_map(built, self.truth, observable=self.observable)
        return scored.f1(_TEN_CM) if score == "f1_10_cm" else float(getattr(scored, score))


def simulate_drive(task: tuple[Path, DriveName]) -> None:
    """Simulate a drive into a folder."""
    import sim  # the simulator: loaded only when a drive is missing

    folder, name = task
    log = sim.simulate(
        worlds.load(name.room), scans=name.scans, seed=name.seed, driver=name.driver, sonar="thesis"
    )
    log.replace(provenance={**log.provenance, _KEY: name.to_dict()}).write(folder / name.file)


@lru_cache(maxsize=1)
def load_drives(folder: Path, names: Sequence[DriveName]) -> tuple[Drive, ...]:
    """Return the drives of a folder, which `simulate_drive` has filled; kept for the next call.

    Raises
    ------
    InputError
        If a file is no log, has no truth, or is another drive's.
    """
    return tuple(_load(folder / name.file, name) for name in names)


def _load(path: Path, name: DriveName) -> Drive:
    log = sm.read_log(path)
    try:
        log.require_truth("the score of maps")
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    made_for = log.provenance.get(_KEY)
    if made_for != name.to_dict():
        raise InputError(
            f"{path}: must be the drive {name.to_dict()}, got {made_for}: remove it, and it is "
            "made again"
        )
    truth = _truth(name.room)
    return Drive(name, log, truth, truth.observable(log))


@lru_cache(maxsize=16)
def _driver(room: str) -> str:
    return "route" if worlds.load(room).route_m else "thesis"


@lru_cache(maxsize=16)
def _truth(room: str) -> worlds.TruthGrid:
    return worlds.truth(worlds.load(room))
