"""Jobs by a Dask cluster that is running already."""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from itertools import islice
from time import perf_counter
from typing import Any
from uuid import uuid4

from sim.runs.jobs.job import Job, Outcome, attempt
from sim.runs.jobs.store import Store
from sonarmap.errors import InputError

__all__ = ["DaskCluster"]

# Tasks that wait at the scheduler for each thread that works: enough that none is without.
_AHEAD = 3
# A task is as many jobs as take so long, seconds, but no more than so many.
_BUNDLE_S, _MOST_JOBS = 4.0, 64
# When nothing has ended for so long the cluster is asked whether it is still there, seconds.
_PATIENCE_S = 20.0
# After so many tasks the workers are counted again: they may come and go.
_RECOUNT = 200


@dataclass(frozen=True)
class DaskCluster:
    """A running Dask cluster; its workers have this version of sonarbed and reach the store.

    A worker that dies loses nothing: Dask gives its jobs to others, and gives a job up when it has
    killed as many workers as ``distributed.scheduler.allowed-failures`` says.

    Parameters
    ----------
    address : str
        Of the scheduler, such as ``tcp://10.0.0.1:8786``.
    timeout_s : float
        How long to wait for it, and for its first worker, seconds.
    """

    address: str
    timeout_s: float = 15.0

    def outcomes(self, jobs: Iterator[Job], store: Store) -> Iterator[tuple[Job, Outcome]]:
        """Yield each job with what became of it, see `sim.runs.jobs.Workers`."""
        client = self._connected()
        ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        under_way: dict[Any, tuple[Any, list[Job]]] = {}
        again: deque[Job] = deque()
        run_id, submitted, done, size = uuid4().hex[:8], 0, 0, 1
        try:
            room = self._room(client)
            while True:
                while len(under_way) < room:
                    bundle = [again.popleft()] if again else list(islice(jobs, size))
                    if not bundle:
                        break
                    key = f"sonarbed-{run_id}-{submitted}"
                    future = client.submit(attempt_all, bundle, store, key=key, pure=False)
                    under_way[key] = future, bundle
                    future.add_done_callback(ended.put)
                    submitted += 1
                if not under_way:
                    return
                finished = self._next(client, ended)
                _, bundle = under_way.pop(finished.key)
                results = self._results(finished, bundle)
                if results is None:
                    # One of them kills its worker: each by itself, so that it is known which.
                    again.extend(bundle)
                    continue
                for job, (outcome, _) in zip(bundle, results, strict=True):
                    yield job, outcome
                # A scheduler takes milliseconds for a task, however little there is to do.
                mean_s = sum(seconds for _, seconds in results) / len(results)
                size = min(max(int(_BUNDLE_S / max(mean_s, 1e-6)), 1), 2 * size, _MOST_JOBS)
                done += 1
                if done % _RECOUNT == 0:
                    room = self._room(client)
        finally:
            # What nobody waits for any more never begins; what has begun ends whole.
            client.cancel([future for future, _ in under_way.values()], force=True)
            client.close(timeout=5)

    def _connected(self) -> Any:
        try:
            from distributed import Client
        except ImportError:
            raise InputError(
                "--dask needs the package dask: pip install 'sonarbed[dask]'"
            ) from None
        try:
            client = Client(self.address, timeout=self.timeout_s, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            line = " ".join(str(error).split()) or "no answer"
            raise InputError(f"dask {self.address!r}: cannot be reached: {line}") from None
        try:
            client.wait_for_workers(1, timeout=self.timeout_s)
            theirs = set(client.run(_version).values())
        except TimeoutError:
            client.close(timeout=5)
            raise InputError(f"dask {self.address!r}: the cluster has no worker") from None
        except Exception as error:  # whatever the workers raised: sonarbed is not there
            client.close(timeout=5)
            line = " ".join(str(error).split()) or type(error).__name__
            raise InputError(f"dask {self.address!r}: its workers need sonarbed: {line}") from None
        if theirs != {_version()}:
            client.close(timeout=5)
            raise InputError(
                f"dask {self.address!r}: its workers must have sonarbed {_version()}, "
                f"got {', '.join(sorted(theirs))}"
            )
        return client

    def _room(self, client: Any) -> int:
        """Return how many tasks may be at the cluster at once."""
        try:
            threads: int = sum(client.nthreads().values())
        except Exception as error:  # the scheduler has gone away, by any of many errors
            raise InputError(f"dask {self.address!r}: lost the scheduler: {error}") from None
        if threads == 0:
            raise InputError(f"dask {self.address!r}: the cluster has no worker any more")
        return _AHEAD * threads

    def _next(self, client: Any, ended: queue.SimpleQueue[Any]) -> Any:
        while True:
            try:
                return ended.get(timeout=_PATIENCE_S)
            except queue.Empty:
                self._room(client)

    def _results(self, future: Any, bundle: list[Job]) -> list[tuple[Outcome, float]] | None:
        """Return what became of the jobs of a task; None if it is not known of which of them."""
        if future.status in ("cancelled", "lost"):
            raise InputError(f"dask {self.address!r}: lost the scheduler; what was made is kept")
        if future.status != "error":
            results: list[tuple[Outcome, float]] = future.result()
            return results
        if len(bundle) > 1:
            return None
        error = future.exception()
        line = f"{type(error).__name__}: {' '.join(str(error).split())}"
        return [(Outcome(error=line), 1.0)]


# The threads of a worker share engines and compilers, which are not made for that.
_ONE_AT_A_TIME = threading.Lock()


def attempt_all(jobs: list[Job], store: Store) -> list[tuple[Outcome, float]]:
    """Run jobs on a worker, one at a time there; return what became of each, and its seconds."""
    results = []
    for job in jobs:
        with _ONE_AT_A_TIME:
            begin = perf_counter()
            # There already, if a worker before this one died in the midst of them.
            is_there = len(jobs) > 1 and all(store.has(name) for name in job.outputs)
            outcome = Outcome() if is_there else attempt(job, store)
            results.append((outcome, perf_counter() - begin))
    return results


def _version() -> str:
    return version("sonarbed")
