"""Work in parallel processes that end cleanly: on Ctrl-C, on a failure, when one is killed."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, MutableMapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.synchronize import Event
from typing import TypeVar

from sonarmap.errors import InputError, whole

__all__ = [
    "checked_jobs",
    "deaf_children",
    "interrupts_held_back",
    "run_all",
    "stop_if_cancelled",
]

# More processes than this, or four a core, are a slip of the pen: each loads all libraries.
_MOST_JOBS = 256

Task = TypeVar("Task")
Result = TypeVar("Result")


def checked_jobs(jobs: int) -> int:
    """Return a number of processes, or raise `InputError`: at least one, no more than can work."""
    return whole("jobs", jobs, least=1, most=max(_MOST_JOBS, 4 * (os.cpu_count() or 1)))


def run_all(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    results: MutableMapping[int, Result],
    *,
    jobs: int,
    on_done: Callable[[int], None] | None = None,
) -> None:
    """Compute ``results[i] = function(tasks[i])`` for all tasks by `jobs` processes.

    Parameters
    ----------
    function : callable
        Must pickle, as must the tasks and what it returns.
    tasks : sequence
        One argument each.
    results : mutable mapping
        Filled under the number of each task; after an interruption or a failure it holds what
        was finished.
    jobs : int
        Processes that work at once, see `checked_jobs`; with 1 all is done in this one.
    on_done : callable, optional
        Called with the number of each finished task, for a progress bar.

    Raises
    ------
    InputError
        If a process was killed. What `function` raises comes through as it is.
    """
    if checked_jobs(jobs) == 1 or len(tasks) <= 1:
        for index, task in enumerate(tasks):
            results[index] = function(task)
            if on_done is not None:
                on_done(index)
        return
    # Fresh processes: a forked one would share the threads of engines and compilers.
    context = multiprocessing.get_context("spawn")
    # Made before any process: the first of its kind starts a helper that unblocks signals.
    stop = context.Event()
    futures: dict[Future[Result], int] = {}
    try:
        with ProcessPoolExecutor(min(jobs, len(tasks)), context, _begin, (stop,)) as pool:
            try:
                with interrupts_held_back():
                    for index, task in enumerate(tasks):
                        futures[pool.submit(function, task)] = index
                for future in as_completed(futures):
                    results[futures[future]] = future.result()
                    if on_done is not None:
                        on_done(futures[future])
            except BaseException:
                # What has begun is asked to stop, and the rest never begins. It waits, for leaving
                # the block would call what is cancelled back to work.
                stop.set()
                pool.shutdown(cancel_futures=True)
                raise
    except BrokenProcessPool:
        raise InputError("a process was killed (out of memory?): give it fewer jobs") from None
    finally:
        for future, index in futures.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                results[index] = future.result()


def stop_if_cancelled() -> None:
    """End this process's task if the parent does not want it any more; long tasks call it."""
    if _stop is not None and _stop.is_set():
        raise _Stopped


# Set in a worker process: the parent's signal to stop.
_stop: Event | None = None


def _begin(stop: Event) -> None:
    global _stop
    _stop = stop


class _Stopped(Exception):  # noqa: N818 - nobody sees it: its future is dropped
    """The parent does not want this task any more."""


@contextmanager
def interrupts_held_back() -> Iterator[None]:
    """Let processes that begin in the block ignore Ctrl-C, from their first line on.

    A terminal sends it to all processes; it is for the parent, which asks the others to stop.
    They inherit the parent's mask of signals. For the parent it waits for the end of the block:
    it must not meet a process half begun, nor be lost, as with `signal.SIG_IGN`.
    """
    can_mask = hasattr(signal, "pthread_sigmask")
    is_main = threading.current_thread() is threading.main_thread()
    held_back: list[int] = []
    if is_main:
        # The mask alone is not enough: threads of numerical libraries have their own.
        handler = signal.signal(signal.SIGINT, lambda number, frame: held_back.append(number))
    if can_mask:
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if can_mask:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        if is_main:
            signal.signal(signal.SIGINT, handler)
    if held_back:
        signal.raise_signal(signal.SIGINT)


deaf_children = interrupts_held_back
"""Former name of `interrupts_held_back`."""
