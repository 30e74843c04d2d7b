"""From logs to what a network is trained on: channels, and the truth of each cell."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sim.runs.jobs import one_thread_each
from sonarmap.files import atomic_path, make_folder
from sonarmap.learned.channels import channels

__all__ = [
    "CELL_M",
    "PADDING_M",
    "Example",
    "load_split",
    "logs_of",
    "make_examples",
    "readings_of",
]

CELL_M = 0.05
# Beyond the room on every side, so that the border of a grid does not give its walls away.
PADDING_M = 1.2
# Shares of the logs that are thinned, that have true poses, and that have refined ones: maps are
# made by poses of each kind. Assumed.
_THINNED, _TRUE_POSES, _REFINED_POSES = 0.2, 0.2, 0.3


@dataclass(frozen=True)
class Example:
    """A log as a network sees it, and the truth.

    Parameters
    ----------
    channels : ndarray of float16, shape (channels, rows, cols)
        See `sonarmap.learned.channels`.
    state : ndarray of uint8, shape (rows, cols)
        A `worlds.CellState` each.
    observable : ndarray of bool, shape (rows, cols)
        Which cells the log's sonars could have seen.
    room, group, split : str
        Where it is from.
    """

    channels: NDArray[np.float16]
    state: NDArray[np.uint8]
    observable: NDArray[np.bool_]
    room: str
    group: str
    split: str

    @classmethod
    def load(cls, path: Path) -> Example:
        """Read what `make_examples` wrote."""
        with np.load(path) as data:
            return cls(
                data["channels"],
                data["state"],
                data["observable"],
                *(str(data[name]) for name in ("room", "group", "split")),
            )


def make_examples(data_sets: list[Path], folder: Path, *, seed: int, workers: int) -> list[Path]:
    """Write an example for each log of data sets; return their files, what is there is kept."""
    make_folder(folder)
    files = [file for data_set in data_sets for file in logs_of(data_set)]
    one = partial(_make, folder, seed)
    # Fresh processes, for a library's threads are decided on when it is imported.
    with (
        one_thread_each(),
        ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool,
    ):
        return list(pool.map(one, files, range(len(files)), chunksize=4))


def load_split(files: Iterable[Path]) -> tuple[list[Example], list[Example]]:
    """Return the examples of rooms to train on, and those of rooms that are held out."""
    examples = [Example.load(file) for file in files]
    train = [each for each in examples if each.split == "train"]
    return train, [each for each in examples if each.split != "train"]


def readings_of(file: Path, number: int, seed: int) -> tuple[sm.SonarLog, worlds.World, str]:
    """Return the log of a file as it is trained on, its room and its split."""
    log = sm.read_log(file)
    split, room = (part.split("=")[1] for part in file.parts[-3:-1])
    world = worlds.load(file.parents[3] / "rooms" / f"{room}.toml")
    rng = np.random.default_rng([seed, number])
    if rng.random() < _THINNED:
        log = log.select(rng.random(len(log)) < rng.uniform(0.25, 0.6))
    poses = rng.random()
    if poses < _TRUE_POSES:
        log = log.at_true_poses()
    elif poses < _TRUE_POSES + _REFINED_POSES:
        log = sm.refine_poses(log)
    return log, world, split


def logs_of(data_set: Path) -> Iterator[Path]:
    """Return the logs of a data set, in the order in which they are numbered."""
    yield from sorted((data_set / "logs").rglob("*.parquet"))


def _make(folder: Path, seed: int, file: Path, number: int) -> Path:
    target = folder / f"{number:05d}.npz"
    if target.exists():
        return target
    log, world, split = readings_of(file, number, seed)
    x_min, y_min, x_max, y_max = world.bounds_m
    pad = PADDING_M
    grid = sm.GridSpec.covering(x_min - pad, y_min - pad, x_max + pad, y_max + pad, CELL_M)
    truth = worlds.truth(world, grid)
    with atomic_path(target) as beside, beside.open("wb") as stream:
        # Not compressed: read again and again.
        np.savez(
            stream,
            channels=channels(log, grid).astype(np.float16),
            state=truth.state,
            observable=truth.observable(log),
            room=world.name,
            group=file.parents[3].name,
            split=split,
        )
    return target
