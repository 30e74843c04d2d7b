"""`run_jobs`: those jobs whose outputs are missing, and what became of them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass, field

from sim.runs.jobs.job import Job, JobFailure, Outcome
from sim.runs.jobs.processes import Processes, ThisProcess, Workers
from sim.runs.jobs.store import Listing, Store
from sonarmap.errors import InputError

__all__ = ["JobProgress", "JobsReport", "run_jobs"]

# A run whose jobs all fail must not fill the memory with reasons.
_KEPT_FAILURES = 1000


@dataclass(frozen=True)
class JobProgress:
    """How far a run is.

    Parameters
    ----------
    done : int
        Jobs whose outputs are there, those of earlier runs included.
    skipped : int
        How many of them an earlier run did.
    failed : int
        Jobs that could not be done.
    total : int or None
        How many there are; None if nobody knows.
    readings : int
        Readings that this run has taken.
    """

    done: int
    skipped: int
    failed: int
    total: int | None
    readings: int


@dataclass
class JobsReport:
    """What became of the jobs of a run.

    Parameters
    ----------
    done, skipped, failed, readings : int
        See `JobProgress`.
    failures : list of JobFailure
        Which failed and why: the first thousand, in the order of their labels.
    """

    done: int = 0
    skipped: int = 0
    failed: int = 0
    readings: int = 0
    failures: list[JobFailure] = field(default_factory=list)


def run_jobs(
    jobs: Iterable[Job],
    store: Store,
    *,
    workers: Workers | int = 1,
    total: int | None = None,
    on_progress: Callable[[JobProgress], None] | None = None,
) -> JobsReport:
    """Run the jobs whose outputs are not in the store yet.

    After an interruption, a kill too, the same call does the rest; what it leaves is the same as
    if nothing had happened. Nobody else may write to the store meanwhile, see `Store.held`.

    Parameters
    ----------
    jobs : iterable of Job
        They are taken as there are workers for them: there may be millions.
    store : Store
        Where the outputs are.
    workers : Workers or int
        `Processes`, `DaskCluster`, or a number of processes of this machine; 1 is this process.
    total : int, optional
        How many jobs there are, for the progress.
    on_progress : callable, optional
        Called with a `JobProgress` at the beginning and when a job has ended.

    Returns
    -------
    JobsReport
        A job that fails is reported there and stops nothing.

    Raises
    ------
    InputError
        If going on is hopeless: the disk is full, workers cannot begin, the cluster is gone. What
        was finished is kept.
    """
    if isinstance(workers, int):
        workers = ThisProcess() if workers == 1 else Processes(workers)
    report, listing = JobsReport(), Listing(store)

    def tell() -> None:
        if on_progress is not None:
            on_progress(
                JobProgress(report.done, report.skipped, report.failed, total, report.readings)
            )

    def missing() -> Iterator[Job]:
        for job in jobs:
            if all(listing.has(name) for name in job.outputs):
                report.done += 1
                report.skipped += 1
                tell()
            else:
                yield job

    tell()
    first = True
    # Closed at once, whatever comes: workers end before this function does.
    with closing(_generator(workers, missing(), store)) as outcomes:
        for job, outcome in outcomes:
            if outcome.is_hopeless:
                raise InputError(
                    f"{outcome.error}; what was finished is kept, the same call does the rest"
                )
            if outcome.error is None and first:
                _check_shared(job, store)
                first = False
            if outcome.error is None:
                report.done += 1
                report.readings += outcome.readings
            else:
                report.failed += 1
                if len(report.failures) < _KEPT_FAILURES:
                    failure = JobFailure(job.label, job.description, outcome.error, outcome.details)
                    report.failures.append(failure)
            tell()
    # Not in the order in which they ended, which is another every time.
    report.failures.sort(key=lambda failure: failure.label)
    return report


def _generator(
    workers: Workers, jobs: Iterator[Job], store: Store
) -> Generator[tuple[Job, Outcome], None, None]:
    yield from workers.outcomes(jobs, store)


def _check_shared(job: Job, store: Store) -> None:
    """Raise `InputError` if what a worker wrote is not to be seen from here."""
    for name in job.outputs:
        if not store.has(name):
            raise InputError(
                f"{store.location}: a worker has written {name!r}, but not where this process "
                "looks: the machines must share the folder, or a URL"
            )
