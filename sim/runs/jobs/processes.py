"""Jobs by this process, or by others of this machine that may die without loss."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing import connection
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Protocol

from sim.runs.jobs.job import Job, Outcome, attempt
from sim.runs.jobs.store import Store
from sim.runs.parallel import Stopped, end_when_told, interrupts_held_back
from sonarmap.errors import InputError, whole

__all__ = ["Processes", "ThisProcess", "Workers", "one_thread_each"]

# Read by numerical libraries when they are loaded: the processes are the threads.
_THREADS = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "NUMBA_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
)
# How often a job is begun before it is held to be the one that kills its worker.
_TRIES = 2
# How long a worker that has nothing to do may take to end, and all that are told to end may take
# together to put their files away: less than a person waits after Ctrl-C, seconds.
_LEAVING_S, _UNWINDING_S = 5.0, 1.5


class Workers(Protocol):
    """Who does jobs."""

    def outcomes(self, jobs: Iterator[Job], store: Store) -> Iterator[tuple[Job, Outcome]]:
        """Yield each job with what became of it, in the order in which they end.

        Jobs are taken from the iterator as there are hands for them, never all at once. When the
        generator is closed, whatever is being done is given up.
        """


@dataclass(frozen=True)
class ThisProcess:
    """The process that calls, one job after the other."""

    def outcomes(self, jobs: Iterator[Job], store: Store) -> Iterator[tuple[Job, Outcome]]:
        """Yield each job with what became of it."""
        for job in jobs:
            yield job, attempt(job, store)


@dataclass(frozen=True)
class Processes:
    """Fresh processes of this machine, each with one thread a library.

    One that dies, killed for its memory or by a fault in compiled code, loses its own job only:
    another takes its place, and the job is tried once more.

    Parameters
    ----------
    count : int
        How many, >= 1.
    """

    count: int

    def __post_init__(self) -> None:
        whole("jobs", self.count, least=1)

    def outcomes(self, jobs: Iterator[Job], store: Store) -> Iterator[tuple[Job, Outcome]]:
        """Yield each job with what became of it, see `Workers`."""
        team = _Team(store)
        waiting: deque[tuple[Job, int]] = deque()
        try:
            while True:
                while len(team.busy) < self.count:
                    task = waiting.popleft() if waiting else _next_task(jobs)
                    if task is None:
                        break
                    team.begin(*task)
                if not team.busy:
                    break
                for worker in team.heard():
                    job, tries = worker.job, worker.tries
                    if not worker.is_ready:
                        team.greet(worker)
                        continue
                    outcome = team.collect(worker)
                    if outcome is None and tries < _TRIES:
                        waiting.append((job, tries + 1))
                        continue
                    yield job, outcome or Outcome(error=f"its worker died {_TRIES} times")
            team.dismiss()
        finally:
            team.end()


def _next_task(jobs: Iterator[Job]) -> tuple[Job, int] | None:
    job = next(jobs, None)
    return None if job is None else (job, 1)


@dataclass(eq=False)
class _Worker:
    """A process, the line to it, and the job that it has."""

    process: BaseProcess
    line: Connection
    job: Job
    tries: int = 1
    is_ready: bool = False


@dataclass(eq=False)
class _Team:
    """The processes of one run."""

    store: Store
    busy: list[_Worker] = field(default_factory=list)
    idle: list[_Worker] = field(default_factory=list)

    def begin(self, job: Job, tries: int) -> None:
        """Give a job to a worker that has none, or to a new one."""
        worker = self.idle.pop() if self.idle else self._started(job)
        worker.job, worker.tries = job, tries
        self.busy.append(worker)
        # Whoever is dead does not take it: found out when its outcome is collected.
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            worker.line.send(job)

    def heard(self) -> list[_Worker]:
        """Wait for workers to begin, to be done or to die, and return them."""
        lines = connection.wait([worker.line for worker in self.busy])
        return [worker for worker in self.busy if worker.line in lines]

    def greet(self, worker: _Worker) -> None:
        """Take note that a worker has begun."""
        try:
            worker.line.recv()
        except (EOFError, OSError):
            raise InputError(
                "a worker process could not begin (out of memory?): give it fewer jobs"
            ) from None
        worker.is_ready = True

    def collect(self, worker: _Worker) -> Outcome | None:
        """Return what became of a worker's job; None if the worker has died."""
        self.busy.remove(worker)
        try:
            outcome: Outcome = worker.line.recv()
        except (EOFError, OSError):
            worker.process.join()
            worker.line.close()
            return None
        self.idle.append(worker)
        return outcome

    def dismiss(self) -> None:
        """Let the workers go home."""
        for worker in self.idle:
            with contextlib.suppress(OSError):
                worker.line.send(None)
        for worker in self.idle:
            worker.process.join(_LEAVING_S)

    def end(self) -> None:
        """End whoever is still there: what they were writing is put away."""
        workers = [worker for worker in self.busy + self.idle if worker.process.is_alive()]
        for worker in workers:
            worker.process.terminate()
        until_s = time.monotonic() + _UNWINDING_S
        for worker in workers:
            worker.process.join(max(until_s - time.monotonic(), 0))
            if worker.process.is_alive():
                worker.process.kill()
                worker.process.join()
        for worker in self.busy + self.idle:
            worker.line.close()

    def _started(self, job: Job) -> _Worker:
        # Fresh processes: a forked one would share the threads of engines and compilers.
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=_work, args=(theirs, self.store), daemon=True)
        with interrupts_held_back(), one_thread_each():
            process.start()
        theirs.close()
        return _Worker(process, ours, job)


@contextlib.contextmanager
def one_thread_each() -> Iterator[None]:
    """Let processes that begin in the block use one thread a library."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _work(line: Connection, store: Store) -> None:
    """Do the jobs that come by the line, until None comes: the main function of a worker."""
    # Whoever gave the jobs may go away, in the midst of a word.
    with contextlib.suppress(Stopped, EOFError, OSError):
        end_when_told()
        line.send(None)
        while (job := line.recv()) is not None:
            line.send(attempt(job, store))
