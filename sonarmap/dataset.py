"""`SonarDataset`: windows of the readings of many logs, as loaders for learning take them."""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, did_you_mean, whole
from sonarmap.log import LogTruth, SonarLog
from sonarmap.rings import SonarRing

__all__ = ["SonarDataset"]

_MANIFEST = "manifest.parquet"
_STORED = {
    **SonarLog.DTYPES,
    **{LogTruth.PREFIX + name: dtype for name, dtype in LogTruth.DTYPES.items()},
}
# By odometry, from the pose and the ring of the log.
_DERIVED = {
    "sensor_x_m": ("sonar", "x_m", "y_m", "heading_rad"),
    "sensor_y_m": ("sonar", "x_m", "y_m", "heading_rad"),
    "axis_rad": ("sonar", "heading_rad"),
}
# Names of surfaces are texts, which no loader makes a batch of.
_USUAL = tuple(name for name in _STORED if _STORED[name] is not np.str_)


class SonarDataset(Sequence[dict[str, NDArray[Any]]]):
    """The readings of a data set that `sonarbed dataset` made, in windows.

    A plain random-access sequence: PyTorch's ``DataLoader`` takes it as it is, with worker
    processes too. Files are opened when they are needed, and the last few logs are kept.

    Parameters
    ----------
    location : str or Path
        Folder of the data set, or its fsspec URL.
    split : {"train", "validation", "test"}, optional
        Which rooms; by default all.
    window : int, optional
        Readings of a window, >= 1; by default a whole log, whatever its length.
    stride : int, optional
        Readings from one window to the next of a log, >= 1; by default they do not overlap. What
        is left at the end of a log and fills no window is left out.
    columns : sequence of str, optional
        Which columns: those of `SonarLog`, of its truth with the prefix ``truth_``, and
        ``sensor_x_m``, ``sensor_y_m``, ``axis_rad`` (place and axis of the sonar by odometry). By
        default those of the log and its truth but ``truth_surface``, which is text.
    kept_logs : int
        How many logs a process keeps in memory, >= 1; one of 1,600 readings takes 0.2 MB.

    Raises
    ------
    InputError
        If there is no data set, no such split or column, or no log has a whole window.

    Examples
    --------
    ::

        train = sm.SonarDataset("data", split="train", window=256)
        loader = torch.utils.data.DataLoader(train, batch_size=32, shuffle=True, num_workers=2)
        for batch in loader:
            batch["range_m"], batch["truth_cause"]  # tensors of shape (32, 256)
    """

    def __init__(
        self,
        location: str | Path,
        split: str | None = None,
        *,
        window: int | None = None,
        stride: int | None = None,
        columns: Sequence[str] | None = None,
        kept_logs: int = 16,
    ) -> None:
        self.location, self.split = str(location).rstrip("/"), split
        self.window = None if window is None else whole("window", window, least=1)
        if stride is not None and window is None:
            raise InputError("stride needs a window")
        self.stride = self.window if stride is None else whole("stride", stride, least=1)
        self.columns = _checked_columns(columns)
        self._kept_logs = whole("kept_logs", kept_logs, least=1)
        self._kept: OrderedDict[int, dict[str, NDArray[Any]]] = OrderedDict()
        self._files, readings = self._listed()
        windows = self._windows_of(readings)
        # Window i is of the first log whose end is beyond i.
        self._end = np.cumsum(windows)
        if not len(self):
            raise InputError(
                f"{self.location}: no log of split {split!r} has {window} readings: give a "
                "smaller window"
            )

    def __len__(self) -> int:
        return int(self._end[-1]) if self._end.size else 0

    # No slices: a window is what is asked for.
    def __getitem__(self, index: Any) -> dict[str, NDArray[Any]]:  # type: ignore[override]
        """Return a window as arrays by column, of shape (window,) each."""
        log, first = self._place(index)
        columns = self._log(log)
        last = None if self.window is None else first + self.window
        # Copies: what is kept stays as it is whatever a caller does to a window.
        return {name: values[first:last].copy() for name, values in columns.items()}

    def __getstate__(self) -> dict[str, Any]:
        # Worker processes begin with nothing kept.
        return {**self.__dict__, "_kept": OrderedDict()}

    def __repr__(self) -> str:
        return (
            f"SonarDataset({self.location!r}, split={self.split!r}, window={self.window}, "
            f"{len(self)} windows of {len(self._files)} logs)"
        )

    def origin(self, index: int) -> tuple[str, int]:
        """Return the file that a window is of, as in the manifest, and its first row there."""
        log, first = self._place(index)
        return str(self._files[log]), first

    def _place(self, index: Any) -> tuple[int, int]:
        """Return the number of the log of a window and its first row there."""
        try:
            number = whole("index", index)
        except InputError:
            raise TypeError(f"index must be a whole number, got {index!r}") from None
        number += len(self) if number < 0 else 0
        if not 0 <= number < len(self):
            raise IndexError(f"index must be within {-len(self)} and {len(self) - 1}, got {index}")
        log = int(np.searchsorted(self._end, number, side="right"))
        before = int(self._end[log - 1]) if log else 0
        return log, (number - before) * (self.stride or 0)

    def _windows_of(self, readings: NDArray[np.int64]) -> NDArray[np.int64]:
        if self.window is None or self.stride is None:
            return np.ones_like(readings)
        return np.maximum((readings - self.window) // self.stride + 1, 0)

    def _listed(self) -> tuple[NDArray[Any], NDArray[np.int64]]:
        """Return the files of the split and how many readings each has."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        try:
            with _opened(f"{self.location}/{_MANIFEST}") as opened, pq.ParquetFile(opened) as file:
                # Not by threads: Arrow's end with the process, which ends badly if they just began.
                table = file.read(columns=["file", "split", "readings"], use_threads=False)
        except FileNotFoundError:
            raise InputError(f"{self.location}: is no data set: it has no {_MANIFEST}") from None
        except (pa.ArrowException, OSError) as error:
            line = " ".join(str(error).split())
            raise InputError(f"{self.location}/{_MANIFEST}: cannot be read: {line}") from None
        if self.split is not None:
            splits = table.column("split").unique().to_pylist()
            if self.split not in splits:
                raise InputError(
                    f"split {self.split!r} is unknown{did_you_mean(self.split, splits)}"
                )
            table = table.filter(pa.compute.equal(table.column("split"), self.split))
        # As an array of bytes: a million names in one piece, quickly sent to worker processes.
        files = np.array(table.column("file").to_pylist(), dtype=np.str_)
        return files, table.column("readings").to_numpy().astype(np.int64)

    def _log(self, number: int) -> dict[str, NDArray[Any]]:
        if number in self._kept:
            self._kept.move_to_end(number)
        else:
            self._kept[number] = self._read(str(self._files[number]))
            if len(self._kept) > self._kept_logs:
                self._kept.popitem(last=False)
        return self._kept[number]

    def _read(self, name: str) -> dict[str, NDArray[Any]]:
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = f"{self.location}/{name}"
        needed = {c: None for column in self.columns for c in _DERIVED.get(column, (column,))}
        try:
            with _opened(path) as opened, pq.ParquetFile(opened) as file:
                # Not by threads: a loader has processes, and forked ones have none.
                table = file.read(columns=list(needed), use_threads=False)
            metadata = table.schema.metadata or {}
        except FileNotFoundError:
            raise InputError(f"{path}: no such file") from None
        except (pa.ArrowException, OSError) as error:
            line = " ".join(str(error).split())
            raise InputError(f"{path}: is not a readable log: {line}") from None
        missing = [column for column in needed if column not in table.column_names]
        if missing:
            raise InputError(f"{path}: column {missing[0]!r} is missing")
        stored = {name: _array(table.column(name)) for name in needed}
        if any(column in _DERIVED for column in self.columns):
            stored |= _derived(stored, _ring(path, metadata))
        return {column: stored[column] for column in self.columns}


def _checked_columns(columns: Sequence[str] | None) -> tuple[str, ...]:
    if columns is None:
        return _USUAL
    known = (*_STORED, *_DERIVED)
    if isinstance(columns, str) or not columns:
        raise InputError(f"columns must be a list of at least one name, got {columns!r}")
    for name in columns:
        if name not in known:
            raise InputError(f"column {name!r} is unknown{did_you_mean(str(name), known)}")
    return tuple(columns)


def _array(column: Any) -> NDArray[Any]:
    import pyarrow as pa

    if pa.types.is_dictionary(column.type):
        return np.array(column.to_pylist(), dtype=np.str_)
    values: NDArray[Any] = column.to_numpy()
    return values


def _ring(path: str, metadata: Mapping[bytes, bytes]) -> SonarRing:
    try:
        return SonarRing.from_dict(json.loads(metadata[b"sonarbed"])["ring"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: its ring cannot be read: {error}") from None


def _derived(columns: Mapping[str, NDArray[Any]], ring: SonarRing) -> dict[str, NDArray[Any]]:
    made = {"axis_rad": columns["heading_rad"] + ring.heading_rad[columns["sonar"]]}
    if "x_m" in columns and "y_m" in columns:
        places = ring.sensor_xy_m(
            columns["sonar"], columns["x_m"], columns["y_m"], columns["heading_rad"]
        )
        made["sensor_x_m"], made["sensor_y_m"] = places[:, 0], places[:, 1]
    return made


@contextmanager
def _opened(path: str) -> Iterator[Any]:
    """Give a file of this machine, or of any file system that fsspec knows."""
    if "://" not in path:
        with Path(path).open("rb") as file:
            yield file
        return
    try:
        import fsspec
    except ImportError:
        raise InputError(
            f"{path}: a URL needs the package fsspec: pip install 'sonarbed[dask]'"
        ) from None
    with fsspec.open(path, "rb") as remote:
        yield remote
