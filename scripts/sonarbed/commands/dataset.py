"""`sonarbed dataset`: many labelled logs in many rooms, as one table."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.options import Json

if TYPE_CHECKING:
    from rich.progress import Progress

    from sim.datasets.making import DatasetProgress, DatasetReport

__all__ = ["dataset"]

# So many failures are printed; the others are in the file.
_SHOWN = 5


def dataset(
    spec: Annotated[Path, typer.Argument(help="What to make, a TOML file: see docs/datasets.md.")],
    out: Annotated[
        str, typer.Option(help="The folder, or a URL that fsspec knows, such as s3://bucket/name.")
    ],
    jobs: Annotated[int, typer.Option(help="Processes of this machine.")] = 1,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Scheduler of a Dask cluster in place of --jobs."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Simulate logs in many rooms into one table, with a manifest, a card and splits by room.

    Stopped or killed at any moment, the same command goes on and ends with the same files.

    Example:

      sonarbed dataset spec.toml --out data --jobs 2
    """
    from sim.datasets import make_dataset
    from sim.runs.jobs import DaskCluster, Processes, ThisProcess, Workers
    from sonarbed.console import print_json, progress
    from sonarbed.reporting.dataset_card import write_card
    from sonarmap import InputError

    workers: Workers
    if dask is not None:
        if jobs != 1:
            raise InputError("give --jobs or --dask, not both: the cluster has its own processes")
        workers = DaskCluster(dask)
    elif jobs == 1:
        workers = ThisProcess()
    else:
        workers = Processes(jobs)
    with progress() as bars:
        show = _Bars(bars)
        report = make_dataset(
            spec, out, workers=workers, on_progress=show.update, describe=write_card
        )
    told = _told(report, out)
    if as_json:
        print_json(told)
    else:
        _print(report, told)


class _Bars:
    """A progress bar a phase, with readings a second."""

    def __init__(self, bars: Progress) -> None:
        self._bars = bars
        self._tasks: dict[str, Any] = {}

    def update(self, progress: DatasetProgress) -> None:
        phase, jobs = progress.phase, progress.jobs
        if phase not in self._tasks:
            self._tasks[phase] = self._bars.add_task(phase, total=jobs.total)
        task = self._bars.tasks[self._tasks[phase]]
        label = phase
        if jobs.readings and task.elapsed:
            label += f", {jobs.readings / task.elapsed:,.0f} readings/s"
        if jobs.failed:
            label += f", {jobs.failed} failed"
        self._bars.update(self._tasks[phase], completed=jobs.done + jobs.failed, description=label)


def _told(report: DatasetReport, out: str) -> dict[str, Any]:
    summary = report.summary
    return {
        "out": out,
        "splits": {
            split: {
                "rooms": summary.rooms[split],
                "logs": summary.logs[split],
                "scans": summary.scans[split],
                "readings": summary.readings[split],
                "causes": dict(summary.causes[split]),
            }
            for split in sorted(summary.logs)
        },
        "taken": report.logs.done - report.logs.skipped,
        "kept": report.logs.skipped,
        "failed": report.failed,
        "without_room": report.without_room,
        "failures": [failure.to_dict() for failure in report.failures[:_SHOWN]],
    }


def _print(report: DatasetReport, told: dict[str, Any]) -> None:
    from sim.datasets.making import FAILURES
    from sonarbed.console import print_table, say

    summary = report.summary
    splits = sorted(summary.logs)
    rows = [
        [
            split,
            f"{summary.rooms[split]:,}",
            f"{summary.logs[split]:,}",
            f"{summary.readings[split]:,}",
            f"{_wrong_share(summary.causes[split]):.1%}",
        ]
        for split in splits
    ]
    print_table(told["out"], ["split", "rooms", "logs", "readings", "wrong"], rows)
    say(f"{told['taken']} logs taken now, {told['kept']} were there.")
    for failure in report.failures[:_SHOWN]:
        say(f"Failed: {failure.label}: {failure.error}")
    if report.failed:
        without = f", {report.without_room} logs not taken for it" if report.without_room else ""
        say(f"{report.failed} failed{without}: see {told['out']}/{FAILURES}.")


def _wrong_share(causes: dict[str, int]) -> float:
    from sonarmap import Cause

    wrong = sum(causes[cause.name.lower()] for cause in Cause if not cause.is_right)
    return wrong / max(sum(causes.values()), 1)
