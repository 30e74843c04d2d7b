"""`run_arena`: drives, runs, and the table of all rows, resumed wherever it was stopped."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from sim.runs.jobs import JobProgress, JobsReport, Store, Workers, open_store, run_jobs
from sonarbed.studies.arena.entries import Entry
from sonarbed.studies.arena.plan import ArenaPlan
from sonarmap.errors import InputError

__all__ = ["FAILURES", "ROWS", "ArenaResult", "run_arena"]

_IDENTITY = "arena.json"
ROWS = "rows.parquet"
"""One row a run, of all entries that have ever been run in the folder."""
FAILURES = "failures.jsonl"


@dataclass(frozen=True)
class ArenaResult:
    """What is in an arena's folder.

    Parameters
    ----------
    rows : list of dict
        One a run.
    drives, runs : JobsReport
        What became of the jobs of this call.
    """

    rows: list[dict[str, Any]]
    drives: JobsReport
    runs: JobsReport


def run_arena(
    plan: ArenaPlan,
    entries: Sequence[Entry],
    out: str | Path,
    *,
    workers: Workers | int = 1,
    timeout_s: float = 120.0,
    on_progress: Callable[[str, JobProgress], None] | None = None,
) -> ArenaResult:
    """Run entries on the drives of a plan; what is in the folder already is not run again.

    Parameters
    ----------
    plan : ArenaPlan
        What they are judged on.
    entries : sequence of Entry
        Who is judged; entries of earlier calls keep their rows.
    out : str or Path
        A folder or a fsspec URL: new, empty, or of this very plan.
    workers : Workers or int
        See `sim.runs.jobs.run_jobs`.
    timeout_s : float
        How long a run may take, seconds.
    on_progress : callable, optional
        Called with "drives" or "runs" and how far they are.

    Raises
    ------
    InputError
        If the folder is of another plan, or going on is hopeless. A run that fails is reported and
        stops nothing.
    """
    store = open_store(out)
    total = len(plan.rooms) * len(plan.sonars) * plan.seeds

    def tell(phase: str) -> Callable[[JobProgress], None] | None:
        return None if on_progress is None else lambda progress: on_progress(phase, progress)

    with store.held():
        _keep_identity(store, plan)
        store.tidy()
        drives = run_jobs(
            plan.drives(), store, workers=workers, total=total, on_progress=tell("drives")
        )
        if drives.failures:
            raise InputError(f"{drives.failures[0].label}: {drives.failures[0].error}")
        runs = run_jobs(
            plan.runs(entries, timeout_s),
            store,
            workers=workers,
            total=total * len(entries),
            on_progress=tell("runs"),
        )
        rows = _rows(store, plan)
        _write_rows(store, rows)
        _write_failures(store, runs)
    return ArenaResult(rows, drives, runs)


def _rows(store: Store, plan: ArenaPlan) -> list[dict[str, Any]]:
    """Return the rows that are there, in the order of the plan and of the entries' labels."""
    rows: list[dict[str, Any]] = []
    for drive in plan.drives():
        folder = f"runs/{drive.digest}"
        found = []
        for name in sorted(store.names(folder)):
            with store.reading(f"{folder}/{name}") as file:
                found.append(json.loads(file.read()))
        rows += sorted(found, key=lambda row: str(row["entry"]))
    return rows


def _write_rows(store: Store, rows: list[dict[str, Any]]) -> None:
    if rows:
        table = pa.Table.from_pylist(rows)
        with store.writing(ROWS) as path:
            pq.write_table(table, path)


def _write_failures(store: Store, runs: JobsReport) -> None:
    if not runs.failures:
        store.remove(FAILURES)
        return
    lines = [json.dumps(failure.to_dict(), sort_keys=True) for failure in runs.failures]
    with store.writing(FAILURES) as path:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _keep_identity(store: Store, plan: ArenaPlan) -> None:
    """Write what the folder is, or raise `InputError` if it is something else."""
    if not store.has(_IDENTITY):
        others = sorted(store.names("") - {".lock"})
        if others:
            raise InputError(
                f"{store.location}: must be new or empty, but has {others[0]!r} and no {_IDENTITY}"
            )
        with store.writing(_IDENTITY) as path:
            path.write_text(json.dumps(plan.identity, indent=2) + "\n", encoding="utf-8")
        return
    with store.reading(_IDENTITY) as file:
        try:
            found = json.loads(file.read())
        except ValueError:
            found = None
    wanted = json.loads(json.dumps(plan.identity))
    if not isinstance(found, dict):
        raise InputError(f"{store.location}/{_IDENTITY}: is not that of an arena")
    for name, value in wanted.items():
        if found.get(name) != value:
            raise InputError(
                f"{store.location}: is an arena with {name} {found.get(name)!r}, asked for "
                f"{value!r}: give another folder"
            )
