"""The rooms of a data set: where each comes from, and the job that puts its file there."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from glob import glob, has_magic
from hashlib import sha256
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import worlds
from sim.datasets.spec import GeneratedRooms, RoomsTable
from sim.robot.amigobot import BODY_RADIUS_M
from sim.runs.jobs import Store, digest_of
from sonarmap.errors import InputError, did_you_mean
from worlds import Pose, World

__all__ = ["RoomJob", "RoomSource", "StoredRoom", "pose_anywhere", "room_sources", "stored_room"]

# A robot at a random place keeps this far from everything, metres. Assumed: it can turn there.
_CLEARANCE_M = BODY_RADIUS_M + 0.05
_CELL_M = 0.05
_SAFE = set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-")


@dataclass(frozen=True)
class RoomSource:
    """Where a room comes from.

    Parameters
    ----------
    name : str
        What it is called in the data set.
    key : str
        What it is, whatever it is called: its content, or its style and seed.
    path : str or None
        Its file.
    style : str or None
        Style of a generated room.
    seed : int
        Seed of a generated room.
    parameters : tuple of (name, value)
        Of its style.
    """

    name: str
    key: str
    path: str | None = None
    style: str | None = None
    seed: int = 0
    parameters: tuple[tuple[str, Any], ...] = ()

    @property
    def file(self) -> str:
        """Name of its file in the data set."""
        return f"rooms/{self.name}.toml"

    def text(self) -> bytes:
        """Return the content of its file."""
        if self.path is not None:
            return Path(self.path).read_bytes()
        assert self.style is not None, "a room has a file or a style"
        return generated_toml(self.style, self.seed, dict(self.parameters)).encode()


@dataclass(frozen=True)
class RoomJob:
    """Put the file of a room into the data set, if a robot can drive there."""

    source: RoomSource

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"room {self.source.name}"

    @property
    def description(self) -> Mapping[str, Any]:
        """All that decides its file."""
        source = self.source
        return {
            "room": source.name,
            "key": source.key,
            "style": source.style,
            "seed": source.seed,
            "parameters": dict(source.parameters),
            "sonarbed": version("sonarbed"),
        }

    @property
    def outputs(self) -> tuple[str, ...]:
        """Its file; the folder is of one spec, so that the name needs no digest."""
        return (self.source.file,)

    def run(self, store: Store) -> int:
        """Write the file."""
        text = self.source.text()
        with tempfile.TemporaryDirectory(prefix="sonarbed-") as folder:
            path = Path(folder) / f"{self.source.name}.toml"
            path.write_bytes(text)
            try:
                check_drivable(worlds.load(path))
            except InputError as error:
                # Where a person finds it, not where it was tried.
                shown = self.source.path or self.source.name
                raise InputError(str(error).replace(str(path), shown)) from None
        with store.writing(self.source.file) as beside:
            beside.write_bytes(text)
        return 0


class StoredRoom(NamedTuple):
    """A room of a data set as it lies there."""

    world: World
    sha256: str


# Keyed by what it is, too: a folder may be made again.
@lru_cache(maxsize=8)
def stored_room(store: Store, file: str, key: str) -> StoredRoom:
    """Return a room of a data set; a process keeps the last few."""
    with store.reading(file) as opened:
        text = opened.read()
    # Of its own name, in a folder of this machine: world readers take paths.
    with tempfile.TemporaryDirectory(prefix="sonarbed-") as folder:
        path = Path(folder) / Path(file).name
        path.write_bytes(text)
        return StoredRoom(worlds.load(path), sha256(text).hexdigest())


def room_sources(table: RoomsTable, folder: Path) -> Iterator[RoomSource]:
    """Yield the rooms that a spec names: no name twice, no file twice.

    Raises
    ------
    InputError
        If a name or a file is unknown, or a glob finds nothing: ``rooms.files[0]: ...``.
    """
    taken: dict[str, str] = {}
    for source in [*_named(table), *_files(table, folder)]:
        if source.key in taken.values():
            continue
        if source.name in taken:
            source = RoomSource(f"{source.name}-{source.key[:6]}", source.key, source.path)
        taken[source.name] = source.key
        yield source
    for entry in table.generate:
        yield from _generated(entry, taken)


def room_count(table: RoomsTable, folder: Path) -> int:
    """Return how many rooms `room_sources` yields."""
    files = RoomsTable(names=table.names, files=table.files) if table.names or table.files else None
    count = 0 if files is None else sum(1 for _ in room_sources(files, folder))
    return count + sum(len(entry.seeds) for entry in table.generate)


def generated_toml(style: str, seed: int, parameters: Mapping[str, Any]) -> str:
    """Return the file of a generated room: the one place that knows the generator."""
    try:
        generator = import_module("worlds.generation.generator")
    except ImportError:
        raise InputError("rooms.generate: this version has no generator of rooms") from None
    text: str = generator.plan(style, seed, **parameters).to_toml()
    return text


def check_style(entry: GeneratedRooms) -> None:
    """Raise `InputError` if there is no such style, or it has no such parameters."""
    try:
        generator = import_module("worlds.generation.generator")
    except ImportError:
        raise InputError("this version has no generator of rooms") from None
    generator.style(entry.style, **entry.parameters)


def check_drivable(world: World) -> None:
    """Raise `InputError` if the robot does not fit where it starts."""
    start = world.start
    if not world.has_room_at(start.x_m, start.y_m, radius_m=BODY_RADIUS_M):
        raise InputError(
            f"room {world.name!r} has no place for a robot of {BODY_RADIUS_M:g} m radius at its "
            f"start [{start.x_m:g}, {start.y_m:g}]"
        )


def pose_anywhere(room: StoredRoom, rng: np.random.Generator) -> Pose:
    """Return a random pose at a place that the robot can drive to from the start.

    Raises
    ------
    InputError
        If there is no such place.
    """
    places = _places(room)
    if not len(places):
        raise InputError(
            f"room {room.world.name!r} has no drivable place that is {_CLEARANCE_M:g} m from "
            "everything"
        )
    x_m, y_m = places[rng.integers(len(places))] + rng.uniform(-_CELL_M / 2, _CELL_M / 2, 2)
    return Pose(float(x_m), float(y_m), float(rng.uniform(-np.pi, np.pi)))


# Of a few rooms: jobs come room by room.
_PLACES: dict[str, NDArray[np.float64]] = {}


def _places(room: StoredRoom) -> NDArray[np.float64]:
    """Return centres of the cells that the robot can drive to, metres, shape (n, 2)."""
    if room.sha256 not in _PLACES:
        if len(_PLACES) >= 8:
            _PLACES.clear()
        _PLACES[room.sha256] = _reachable(room.world)
    return _PLACES[room.sha256]


def _reachable(world: World) -> NDArray[np.float64]:
    from scipy import ndimage

    truth = worlds.truth(world, resolution_m=_CELL_M)
    grid = truth.grid
    is_free = np.asarray(truth.state) == worlds.FREE
    # Half a diagonal of a cell more: it is where the centre may lie in it.
    margin_m = _CLEARANCE_M + _CELL_M * 0.75
    # The edge of the grid counts as a wall: nothing is known beyond.
    padded = np.pad(is_free, 1)
    wide = ndimage.distance_transform_edt(padded)[1:-1, 1:-1] * _CELL_M >= margin_m
    areas, _ = ndimage.label(wide)
    rows, cols = np.nonzero(wide)
    if rows.size == 0:
        return np.empty((0, 2))
    x_m = grid.origin_xy_m[0] + (cols + 0.5) * _CELL_M
    y_m = grid.origin_xy_m[1] + (rows + 0.5) * _CELL_M
    # The start itself may be nearer to a wall than we like: the area next to it.
    nearest = np.hypot(x_m - world.start.x_m, y_m - world.start.y_m).argmin()
    kept = areas[rows, cols] == areas[rows[nearest], cols[nearest]]
    return np.column_stack([x_m[kept], y_m[kept]])


def _named(table: RoomsTable) -> Iterator[RoomSource]:
    from fnmatch import fnmatchcase

    known = worlds.names()
    for i, pattern in enumerate(table.names):
        found = [name for name in known if fnmatchcase(name, pattern)]
        if not found:
            raise InputError(
                f"rooms.names[{i}]: unknown room {pattern!r}" + did_you_mean(pattern, known)
            )
        for name in found:
            yield _of_file(Path(worlds.__file__).parent / "rooms" / f"{name}.toml")


def _files(table: RoomsTable, folder: Path) -> Iterator[RoomSource]:
    for i, pattern in enumerate(table.files):
        whole = str(folder / pattern)
        try:
            found = sorted(glob(whole, recursive=True)) if has_magic(pattern) else [whole]  # noqa: PTH207 - of any root
            files = [Path(path) for path in found if Path(path).is_file()]
        except (OSError, ValueError) as error:
            raise InputError(f"rooms.files[{i}]: {pattern!r} cannot be read: {error}") from None
        if not files:
            raise InputError(f"rooms.files[{i}]: {pattern!r} is no file")
        for path in files:
            if path.suffix.lower() != ".toml":
                raise InputError(f"rooms.files[{i}]: must be a .toml file, got {str(path)!r}")
            yield _of_file(path)


def _of_file(path: Path) -> RoomSource:
    try:
        key = sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    return RoomSource(_safe(path.stem), key, str(path.absolute()))


def _generated(entry: GeneratedRooms, taken: Mapping[str, str]) -> Iterator[RoomSource]:
    parameters = tuple(sorted(entry.parameters.items()))
    mark = f"-{digest_of(dict(parameters))[:6]}" if parameters else ""
    style = _safe(entry.style)
    for seed in entry.seeds:
        name = f"{style}-{seed:04d}{mark}"
        name = f"{name}-generated" if name in taken else name
        key = f"{entry.style}{mark}:{seed}"
        yield RoomSource(name, key, None, entry.style, seed, parameters)


def _safe(name: str) -> str:
    """Return a name that any file system and any query takes."""
    safe = "".join(c if c in _SAFE else "_" for c in name)[:80]
    return safe if safe.strip("._") else f"room-{sha256(name.encode()).hexdigest()[:6]}"
