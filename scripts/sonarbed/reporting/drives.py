"""Simulated drives: each described by a `DriveSpec`, and kept in one `DriveStore`."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import sim
import sonarmap as sm
import worlds
from sim import Driver, Sonar, StatusPackets
from sonarbed.reporting.parallel import OnProgress, no_progress, parallel_map
from sonarmap.account import ContactAccount, ReadingAccount, account_by, account_of, contacts_of
from sonarmap.errors import InputError

__all__ = [
    "DriveSpec",
    "DriveStore",
    "DrivesAccount",
    "ScorableDrive",
    "account_of_drives",
    "usual_driver",
]

# Where the provenance of a stored log says which drive it is.
_KEY = "drive"
# Digits of the digest in a file's name: those of a million drives differ with a chance of 99.8 %.
_DIGITS = 12
# Logs and truths that a process keeps in memory; a drive of 500 scans takes about 1 MB.
_KEPT = 64


@lru_cache(maxsize=_KEPT)
def usual_driver(room: str) -> str:
    """Return who drives in the studies: along a room's route, else on the thesis's own circle."""
    return "route" if worlds.load(room).route_m else "thesis"


@dataclass(frozen=True, eq=False)
class DriveSpec:
    """Everything that decides the readings of a simulated drive.

    Two of them are equal when they describe the same drive.

    Parameters
    ----------
    room : str
        A shipped room, or the path of a room's file, of which the content counts.
    scans : int
        Length in scans of all sonars.
    seed : int
        Of all that is random.
    driver : str or Driver
        Who drives, see `sim.simulate`.
    sonar : str or Sonar
        The sonars, see `sim.simulate`.
    engine : str
        "bullet" or "segments".
    packets : StatusPackets, optional
        Log what status packets report.
    parameters : tuple of (name, value)
        The room's own, in the order of their names, see `worlds.load`.
    """

    room: str
    scans: int
    seed: int
    driver: str | Driver = "auto"
    sonar: str | Sonar = "thesis"
    engine: str = "bullet"
    packets: StatusPackets | None = None
    parameters: tuple[tuple[str, float], ...] = ()

    @cached_property
    def description(self) -> Mapping[str, Any]:
        """All of it as JSON-able values, with the version that simulates it."""
        described = {field.name: _json_able(getattr(self, field.name)) for field in fields(self)}
        room = Path(self.room)
        if self.room not in worlds.names() and room.is_file():
            described["room"] = sha256(room.read_bytes()).hexdigest()
        return {**described, "sonarbed": version("sonarbed")}

    @cached_property
    def digest(self) -> str:
        """A digest of the description, the same in every process."""
        return sha256(json.dumps(self.description, sort_keys=True).encode()).hexdigest()

    @property
    def file_name(self) -> str:
        """Name of its log: what people look for, then what keeps all drives apart."""
        driver = self.driver if isinstance(self.driver, str) else type(self.driver).__name__.lower()
        sonar = self.sonar if isinstance(self.sonar, str) else self.sonar.name
        parts = (Path(self.room).stem, driver, sonar, str(self.scans), f"{self.seed:04d}")
        return "-".join((*parts, self.digest[:_DIGITS])) + ".parquet"

    def load_world(self) -> worlds.World:
        """Return the room with its parameters."""
        return worlds.load(self.room, **dict(self.parameters))

    def simulate(self) -> sm.SonarLog:
        """Return the log of the drive, whose provenance holds the description."""
        log = sim.simulate(
            self.load_world(),
            scans=self.scans,
            seed=self.seed,
            driver=self.driver,
            sonar=self.sonar,
            engine=self.engine,
            packets=self.packets,
        )
        return log.replace(provenance={**log.provenance, _KEY: self.description})

    def __eq__(self, other: object) -> bool:
        return isinstance(other, DriveSpec) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)


@dataclass(frozen=True, eq=False)
class ScorableDrive:
    """A drive with what its maps are scored by.

    Parameters
    ----------
    spec : DriveSpec
        Which drive.
    log : SonarLog
        Its readings, with truth.
    truth : TruthGrid
        The true cells of its room.
    observable : ndarray of bool
        The cells that its readings could have observed.
    """

    spec: DriveSpec
    log: sm.SonarLog
    truth: worlds.TruthGrid
    observable: NDArray[np.bool_]


@dataclass(frozen=True)
class DriveStore:
    """A folder of drives: each is simulated once, and kept as a log.

    What is read stays in the memory of a process for the next time.

    Parameters
    ----------
    folder : Path
        Where the logs are.
    """

    folder: Path

    def path_of(self, spec: DriveSpec) -> Path:
        """Return where the log of a drive is, or will be."""
        return self.folder / spec.file_name

    def simulate_missing(
        self,
        specs: Sequence[DriveSpec],
        label: str = "driving",
        *,
        jobs: int = 1,
        on_progress: OnProgress = no_progress,
    ) -> None:
        """Simulate the drives that are not here yet, by `jobs` processes.

        Each log is written as soon as it is done: after an interruption only the others are made.
        """
        missing = [spec for spec in dict.fromkeys(specs) if not self.path_of(spec).exists()]
        if missing:
            parallel_map(self._simulate, missing, label, jobs=jobs, on_progress=on_progress)

    def log(self, spec: DriveSpec) -> sm.SonarLog:
        """Return the log of a drive that is here.

        Raises
        ------
        InputError
            If the file is no log, has no truth, or is another drive's.
        """
        path = self.path_of(spec)
        log = _read(path, _changed_ns(path))
        found = log.provenance.get(_KEY)
        if found != spec.description:
            raise InputError(
                f"{path}: must be the drive {spec.description}, got {found}: remove it, and it is "
                "made again"
            )
        return log

    def scorable(self, spec: DriveSpec, *, resolution_m: float = 0.05) -> ScorableDrive:
        """Return a drive that is here with the truth in cells of that size."""
        log, path = self.log(spec), self.path_of(spec)
        truth = _truth(spec.room, spec.parameters, resolution_m)
        observable = _observable(path, _changed_ns(path), truth)
        return ScorableDrive(spec, log, truth, observable)

    def account(self) -> DrivesAccount:
        """Return the account of all drives that are here, whatever is made of them."""
        logs = (sm.read_log(path) for path in sorted(self.folder.glob("*.parquet")))
        return _summed((log, account_of(log)) for log in logs)

    def _simulate(self, spec: DriveSpec) -> None:
        spec.simulate().write(self.path_of(spec))


@dataclass(frozen=True)
class DrivesAccount:
    """What became of the readings of some drives, and how often the robots touched something.

    Parameters
    ----------
    drives : int
        How many drives.
    readings : ReadingAccount
        Of all their readings.
    contacts : ContactAccount
        Of all their scans.
    """

    drives: int
    readings: ReadingAccount
    contacts: ContactAccount

    @property
    def lines(self) -> tuple[str, ...]:
        """Lines for people."""
        drives = "1 drive" if self.drives == 1 else f"{self.drives} drives"
        touched = (str(self.contacts),) if self.contacts.touched else ()
        return (f"{drives}, {self.readings}", *touched)

    def to_dict(self) -> dict[str, Any]:
        """Return the counts as JSON-able values."""
        return {"drives": self.drives, **self.readings.to_dict(), **self.contacts.to_dict()}


def account_of_drives(
    store: DriveStore, specs: Sequence[DriveSpec], method: sm.MappingMethod
) -> DrivesAccount:
    """Return the account of drives that are here, by what a mapping method uses of them."""
    return _summed((log, account_by(log, method)) for log in map(store.log, specs))


def _summed(accounts: Iterable[tuple[sm.SonarLog, ReadingAccount]]) -> DrivesAccount:
    drives, readings, contacts = 0, ReadingAccount(0, 0, {}), ContactAccount(0, 0, "scans")
    for log, account in accounts:
        of_drive = contacts_of(log)
        assert of_drive is not None, "a drive that is kept has its truth"
        drives, readings, contacts = drives + 1, readings + account, contacts + of_drive
    return DrivesAccount(drives, readings, contacts)


# Keyed by the time of the last change too: a file that is made again is read again.
@lru_cache(maxsize=_KEPT)
def _read(path: Path, changed_ns: int) -> sm.SonarLog:
    log = sm.read_log(path)
    try:
        log.require_truth("the score of maps")
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return log


@lru_cache(maxsize=_KEPT)
def _truth(
    room: str, parameters: tuple[tuple[str, float], ...], resolution_m: float
) -> worlds.TruthGrid:
    return worlds.truth(worlds.load(room, **dict(parameters)), resolution_m=resolution_m)


@lru_cache(maxsize=_KEPT)
def _observable(path: Path, changed_ns: int, truth: worlds.TruthGrid) -> NDArray[np.bool_]:
    return truth.observable(_read(path, changed_ns))


def _changed_ns(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 0  # the reader says what is wrong


def _json_able(value: Any) -> Any:
    """Return a configuration as JSON would give it back, so that the two can be compared."""
    if is_dataclass(value) and not isinstance(value, type):
        described = {field.name: _json_able(getattr(value, field.name)) for field in fields(value)}
        return {"kind": type(value).__name__, **described}
    if isinstance(value, Mapping):
        return {str(key): _json_able(each) for key, each in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, tuple | list | range):
        return [_json_able(each) for each in value]
    if value is None or isinstance(value, str | int | float | bool):
        return value
    raise InputError(f"a drive must be described by plain values, got {value!r}")
