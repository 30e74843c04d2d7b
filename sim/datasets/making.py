"""`make_dataset`: rooms, logs and what describes them, resumed wherever it was stopped."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from sim.datasets.croissant import CROISSANT, croissant_text
from sim.datasets.logs import LogJob
from sim.datasets.manifest import MANIFEST, PARTS_FOLDER, DatasetSummary, part_jobs, put_together
from sim.datasets.plan import Plan, plan_of
from sim.datasets.reading import read_spec
from sim.datasets.rooms import RoomJob
from sim.datasets.spec import DatasetSpec
from sim.runs.jobs import JobFailure, JobProgress, JobsReport, Store, Workers, open_store, run_jobs
from sim.runs.jobs.store import Listing
from sonarmap.errors import InputError

__all__ = ["FAILURES", "IDENTITY", "DatasetProgress", "DatasetReport", "make_dataset"]

IDENTITY = "dataset.json"
"""What decides the logs of a folder: the spec, digests of rooms and rings, the version."""
FAILURES = "failures.jsonl"
# So many rooms are written, and so many logs are listed, quicker here than processes begin.
_FEW_ROOMS, _FEW_LOGS = 64, 5000


@dataclass(frozen=True)
class DatasetProgress:
    """How far the making of a data set is.

    Parameters
    ----------
    phase : {"rooms", "logs", "manifest"}
        What is being done.
    jobs : JobProgress
        How far it is.
    """

    phase: str
    jobs: JobProgress


@dataclass(frozen=True)
class DatasetReport:
    """What a run has made.

    Parameters
    ----------
    summary : DatasetSummary
        What is in the data set.
    rooms, logs : JobsReport
        What became of the rooms and the logs.
    without_room : int
        Logs that were not taken because their room failed.
    """

    summary: DatasetSummary
    rooms: JobsReport
    logs: JobsReport
    without_room: int

    @property
    def failures(self) -> list[JobFailure]:
        """Rooms and logs that could not be made."""
        return self.rooms.failures + self.logs.failures

    @property
    def failed(self) -> int:
        """How many could not be made."""
        return self.rooms.failed + self.logs.failed


def make_dataset(
    spec: DatasetSpec | str | Path,
    out: str | Path,
    *,
    workers: Workers | int = 1,
    folder: str | Path = ".",
    on_progress: Callable[[DatasetProgress], None] | None = None,
    describe: Callable[[Store, Plan, DatasetReport], None] | None = None,
) -> DatasetReport:
    """Make the data set of a spec, or what is missing of it.

    Parameters
    ----------
    spec : DatasetSpec, str or Path
        The spec, or its TOML file.
    out : str or Path
        A folder, or a fsspec URL. It is new, empty, or has a part of this very data set.
    workers : Workers or int
        Who takes the logs, see `sim.runs.jobs.run_jobs`.
    folder : str or Path
        Where the paths in a `DatasetSpec` begin; those of a file begin where it lies.
    on_progress : callable, optional
        Called with a `DatasetProgress`.
    describe : callable, optional
        Called at the end, while the folder is held, to add a card and pictures.

    Returns
    -------
    DatasetReport
        Rooms and logs that could not be made are in it, and in ``failures.jsonl``.

    Raises
    ------
    InputError
        If the spec breaks a rule, the folder has something else in it, the disk is full, or
        another process writes there. What was finished is kept; the same call does the rest.
    """
    plan = checked_plan(spec, folder)
    store = open_store(out)

    def tell(phase: str) -> Callable[[JobProgress], None] | None:
        return on_progress and (lambda jobs: on_progress(DatasetProgress(phase, jobs)))

    with store.held():
        _keep_identity(store, plan)
        store.tidy()
        rooms = run_jobs(
            map(RoomJob, plan.rooms()),
            store,
            workers=1 if plan.room_count <= _FEW_ROOMS else workers,
            total=plan.room_count,
            on_progress=tell("rooms"),
        )
        logs_to_take = _Logs(plan, store)
        logs = run_jobs(
            logs_to_take.jobs(),
            store,
            workers=workers,
            total=plan.log_count,
            on_progress=tell("logs"),
        )
        summary = _manifest(store, plan, workers, tell("manifest"))
        report = DatasetReport(summary, rooms, logs, logs_to_take.without_room)
        _write_failures(store, report)
        with store.reading(MANIFEST) as file:
            digest = sha256(file.read()).hexdigest()
        write_text(store, CROISSANT, croissant_text(plan.spec, summary, digest))
        if describe is not None:
            describe(store, plan, report)
    return report


def checked_plan(spec: DatasetSpec | str | Path, folder: str | Path = ".") -> Plan:
    """Return the plan of a spec or of its file, see `make_dataset`."""
    if isinstance(spec, DatasetSpec):
        return plan_of(spec, Path(folder).absolute())
    read = read_spec(spec)
    try:
        return plan_of(read, Path(spec).absolute().parent)
    except InputError as error:
        raise InputError(f"{spec}: {error}") from None


def write_text(store: Store, name: str, text: str) -> None:
    """Write a text into a store."""
    with store.writing(name) as path:
        path.write_text(text, encoding="utf-8")


class _Logs:
    """The logs of the rooms that are there."""

    def __init__(self, plan: Plan, store: Store) -> None:
        self._plan, self._store = plan, store
        self.without_room = 0

    def jobs(self) -> Iterator[LogJob]:
        listing = Listing(self._store)
        for room in self._plan.rooms():
            if listing.has(room.file):
                yield from self._plan.logs_of(room)
            else:
                self.without_room += self._plan.logs_per_room


def _manifest(
    store: Store,
    plan: Plan,
    workers: Workers | int,
    tell: Callable[[JobProgress], None] | None,
) -> DatasetSummary:
    listing = Listing(store)
    parts: list[str] = []

    def files() -> Iterator[str]:
        for room in plan.rooms():
            for job in plan.logs_of(room):
                if listing.has(job.outputs[0]):
                    yield job.outputs[0]

    def jobs() -> Iterator[Any]:
        for part in part_jobs(files()):
            parts.append(part.outputs[0])
            yield part

    few = plan.log_count <= _FEW_LOGS
    report = run_jobs(jobs(), store, workers=1 if few else workers, on_progress=tell)
    if report.failures:
        raise InputError(report.failures[0].error)
    if not parts:
        raise InputError(f"{store.location}: no log could be taken: {_first_reason(store)}")
    summary = put_together(store, parts)
    for name in sorted(store.names(PARTS_FOLDER)):
        store.remove(f"{PARTS_FOLDER}/{name}")
    return summary


def _keep_identity(store: Store, plan: Plan) -> None:
    """Write what the folder is, or raise `InputError` if it is something else."""
    identity = json.loads(json.dumps(plan.identity))
    if not store.has(IDENTITY):
        others = sorted(store.names("") - {".lock"})
        if others or store.has(MANIFEST):
            raise InputError(
                f"{store.location}: must be new or empty, but has {others[0]!r} and no {IDENTITY}"
            )
        write_text(store, IDENTITY, json.dumps(identity, indent=2, sort_keys=True) + "\n")
        return
    with store.reading(IDENTITY) as file:
        try:
            found = json.loads(file.read())
        except ValueError:
            found = None
    if found != identity:
        raise InputError(
            f"{store.location}: has another data set: {_difference(found, identity)}; give "
            "another folder"
        )


def _difference(found: Any, wanted: Any, place: str = "") -> str:
    """Return in words where two nested mappings first differ."""
    if isinstance(found, dict) and isinstance(wanted, dict):
        for key in sorted(found.keys() | wanted.keys()):
            mine, other = wanted.get(key), found.get(key)
            if mine != other:
                return _difference(other, mine, f"{place}.{key}" if place else key)
    return f"{place or IDENTITY} is {_short(found)}, asked for {_short(wanted)}"


def _short(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _write_failures(store: Store, report: DatasetReport) -> None:
    if not report.failures:
        store.remove(FAILURES)
        return
    lines = [json.dumps(failure.to_dict(), sort_keys=True) for failure in report.failures]
    write_text(store, FAILURES, "\n".join(lines) + "\n")


def _first_reason(store: Store) -> str:
    return f"see {FAILURES}"
