"""The manifest: one row a log, made in parts by jobs and put together as it is read."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sim.datasets.logs import RECORD
from sim.runs.jobs import Store, digest_of
from sim.runs.jobs.job import DIGITS
from sonarmap import Cause, InputError

__all__ = [
    "MANIFEST",
    "PARTS_FOLDER",
    "SCHEMA",
    "DatasetSummary",
    "PartJob",
    "part_jobs",
    "put_together",
]

MANIFEST = "manifest.parquet"
PARTS_FOLDER = "parts"
# Logs whose records one job reads: half a second's work.
_LOGS_A_PART = 500

CAUSES = tuple(cause.name.lower() for cause in Cause)
SCHEMA = pa.schema(
    [
        ("log", pa.string()),
        ("file", pa.string()),
        ("split", pa.string()),
        ("room", pa.string()),
        ("number", pa.int32()),
        ("seed", pa.int64()),
        ("driver", pa.string()),
        ("sonar", pa.string()),
        ("ring", pa.string()),
        ("sonars", pa.int16()),
        ("engine", pa.string()),
        ("scans", pa.int32()),
        ("readings", pa.int32()),
        ("duration_s", pa.float64()),
        ("path_m", pa.float64()),
        ("collision_scans", pa.int32()),
        *((cause, pa.int32()) for cause in CAUSES),
        ("settings", pa.string()),
        ("room_sha256", pa.string()),
        ("digest", pa.string()),
        ("sonarbed", pa.string()),
    ]
)


@dataclass(frozen=True)
class PartJob:
    """Read the records of some logs into a part of the manifest."""

    number: int
    files: tuple[str, ...]

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"manifest, part {self.number}"

    @property
    def description(self) -> Mapping[str, Any]:
        """All that decides its rows."""
        return {"number": self.number, "files": list(self.files)}

    @property
    def outputs(self) -> tuple[str, ...]:
        """Its part."""
        digest = digest_of(self.description)[:DIGITS]
        return (f"{PARTS_FOLDER}/{self.number:06d}-{digest}.parquet",)

    def run(self, store: Store) -> int:
        """Write the part."""
        rows = [_record(store, file) for file in self.files]
        for row in rows:
            row["settings"] = json.dumps(row["settings"], sort_keys=True)
        table = pa.Table.from_pylist(rows, schema=SCHEMA)
        with store.writing(self.outputs[0]) as path:
            pq.write_table(table, path)
        return 0


@dataclass
class DatasetSummary:
    """What is in a data set.

    Parameters
    ----------
    logs, rooms, readings, scans : Counter
        By split.
    causes : dict of Counter
        Readings by cause, by split.
    groups : dict of Counter
        Readings by cause, by (sonar, driver).
    duration_s : float
        Time that the robots drove.
    first : dict
        File of the first log of each split.
    """

    logs: Counter[str] = field(default_factory=Counter)
    rooms: Counter[str] = field(default_factory=Counter)
    readings: Counter[str] = field(default_factory=Counter)
    scans: Counter[str] = field(default_factory=Counter)
    causes: dict[str, Counter[str]] = field(default_factory=dict)
    groups: dict[tuple[str, str], Counter[str]] = field(default_factory=dict)
    duration_s: float = 0.0
    first: dict[str, str] = field(default_factory=dict)

    def add(self, table: pa.Table) -> None:
        """Count the rows of a part; parts come in the order of the manifest."""
        needed = ["split", "room", "readings", "scans", "sonar", "driver", "duration_s", "file"]
        for row in table.select([*needed, *CAUSES]).to_pylist():
            split, group = row["split"], (row["sonar"], row["driver"])
            self.logs[split] += 1
            self.readings[split] += row["readings"]
            self.scans[split] += row["scans"]
            self.duration_s += row["duration_s"]
            self.first.setdefault(split, row["file"])
            if row["room"] != self._room:
                self._room = row["room"]
                self.rooms[split] += 1
            for counts in (
                self.causes.setdefault(split, Counter()),
                self.groups.setdefault(group, Counter()),
            ):
                counts.update({cause: row[cause] for cause in CAUSES})

    _room: str | None = None


def part_jobs(files: Iterable[str]) -> Iterator[PartJob]:
    """Yield the jobs that make the parts of a manifest of these logs."""
    batch: list[str] = []
    number = 0
    for file in files:
        batch.append(file)
        if len(batch) == _LOGS_A_PART:
            yield PartJob(number, tuple(batch))
            number, batch = number + 1, []
    if batch:
        yield PartJob(number, tuple(batch))


def put_together(store: Store, parts: Iterable[str]) -> DatasetSummary:
    """Write the manifest from its parts, one after the other, and return what it says."""
    summary = DatasetSummary()
    with store.writing(MANIFEST) as path, pq.ParquetWriter(path, SCHEMA) as writer:
        for part in parts:
            with store.reading(part) as file:
                table = pq.read_table(file, schema=SCHEMA, partitioning=None)
            writer.write_table(table)
            summary.add(table)
    return summary


def _record(store: Store, file: str) -> dict[str, Any]:
    """Return what a log says of itself; its readings are not read."""
    with store.reading(file) as opened:
        try:
            metadata = pq.read_metadata(opened).metadata or {}
            record: dict[str, Any] = json.loads(metadata[b"sonarbed"])["provenance"][RECORD]
        except (pa.ArrowException, ValueError, KeyError, TypeError) as error:
            raise InputError(
                f"{store.location}/{file}: is no log of a data set ({type(error).__name__}): "
                "remove it, and it is taken again"
            ) from None
    return record
