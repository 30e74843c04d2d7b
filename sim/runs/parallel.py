"""Work in parallel processes that end cleanly: on Ctrl-C, on a failure, when one is killed."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, MutableMapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.context import BaseContext
from multiprocessing.process import BaseProcess
from multiprocessing.synchronize import Event
from pathlib import Path
from types import FrameType
from typing import TypeVar

from sonarmap.errors import InputError, whole
from sonarmap.interrupts import may_raise_in

__all__ = [
    "Stopped",
    "checked_jobs",
    "deaf_children",
    "end_when_told",
    "interrupts_held_back",
    "run_all",
    "stop_if_cancelled",
]

# More processes than this, or four a core, are a slip of the pen: each loads all libraries.
_MOST_JOBS = 256
# How a process of ours ends that comes by the call that has made it.
_UNGUARDED = 97
# A pool that is broken ends its processes; this is how long it may take, seconds.
_ENDING_S = 2.0
# Of those that are not wanted any more each may finish what it does for so long, and then has so
# long to leave nothing half-written: together less than a person waits after Ctrl-C.
_FINISHING_S, _UNWINDING_S = 1.5, 0.5
# Where a signal comes at a bad moment, it comes again so much later.
_AGAIN_S = 0.01

Task = TypeVar("Task")
Result = TypeVar("Result")


def checked_jobs(jobs: int, name: str = "jobs") -> int:
    """Return a number of processes, or raise `InputError`: at least one, no more than can work."""
    return whole(name, jobs, least=1, most=max(_MOST_JOBS, 4 * (os.cpu_count() or 1)))


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
        Processes that work at once, see `checked_jobs`; with 1 all is done in this one, and so it
        is where no process can be made: in a worker of somebody else's pool, or on a system
        without shared semaphores.
    on_done : callable, optional
        Called with the number of each finished task, for a progress bar.

    Raises
    ------
    InputError
        If a process was killed, or ended before it could work: the last as a rule because the
        script that calls this has no main guard. What `function` raises comes through as it is.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        # A process of ours that reads the script that made it, and comes by the same call again:
        # there is no main guard. The parent tells.
        raise SystemExit(_UNGUARDED)
    # Fresh processes: a forked one would share the threads of engines and compilers.
    context = multiprocessing.get_context("spawn")
    alone = checked_jobs(jobs) == 1 or len(tasks) <= 1 or multiprocessing.current_process().daemon
    stop = None if alone else _event(context)
    if stop is None:
        for index, task in enumerate(tasks):
            results[index] = function(task)
            if on_done is not None:
                on_done(index)
        return
    futures: dict[Future[Result], int] = {}
    others, begun = {*multiprocessing.active_children()}, set[BaseProcess]()
    try:
        with ProcessPoolExecutor(min(jobs, len(tasks)), context, _begin, (stop,)) as pool:
            try:
                with interrupts_held_back(), _readable_main():
                    for index, task in enumerate(tasks):
                        futures[pool.submit(function, task)] = index
                begun = {*multiprocessing.active_children()} - others
                for future in as_completed(futures):
                    results[futures[future]] = future.result()
                    if on_done is not None:
                        on_done(futures[future])
            except BaseException:
                # What has begun is asked to stop, then made to, and the rest never begins. It
                # waits, for leaving the block would call what is cancelled back to work.
                stop.set()
                pool.shutdown(wait=False, cancel_futures=True)
                _end({*multiprocessing.active_children()} - others)
                raise
    except BrokenProcessPool:
        raise InputError(_why_broken(begun)) from None
    finally:
        for future, index in futures.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                results[index] = future.result()


def _event(context: BaseContext) -> Event | None:
    """Return an event for processes to share; None on a system without shared semaphores."""
    try:
        with interrupts_held_back():
            return context.Event()
    except (ImportError, OSError):
        return None


@contextmanager
def _readable_main() -> Iterator[None]:
    """Let processes that begin in the block not look for a script that came by a pipe."""
    main = sys.modules["__main__"]
    file = getattr(main, "__file__", None)
    if file is None or Path(file).is_file():
        yield
        return
    del main.__file__
    try:
        yield
    finally:
        main.__file__ = file


def _why_broken(begun: Iterable[BaseProcess]) -> str:
    """Return why processes ended that should have worked, and what helps."""
    guard = 'a script that starts processes must do so below `if __name__ == "__main__":`'
    for process in begun:
        process.join(_ENDING_S)
    codes = {process.exitcode for process in begun if process.exitcode}
    if _UNGUARDED in codes:
        return f"the processes came by the call that starts them: {guard}"
    if any(code > 0 for code in codes):
        return f"a process ended before it could work, its reason is above; {guard}"
    return "a process was killed (out of memory?): give it fewer jobs"


def stop_if_cancelled() -> None:
    """End this process's task if the parent does not want it any more; long tasks call it."""
    if _stop is not None and _stop.is_set():
        raise Stopped


# Set in a worker process: the parent's signal to stop.
_stop: Event | None = None


def _begin(stop: Event) -> None:
    global _stop
    _stop = stop
    end_when_told()


def end_when_told() -> None:
    """Let this process, which another has begun, end by `Stopped` on SIGTERM, and with the other.

    It unwinds, so that what is being written is put away, and says nothing: the other one tells.
    """
    signal.signal(signal.SIGTERM, _stopped)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _stopped(number: int, frame: FrameType | None) -> None:
    # A callback of C cannot be left by it, and would tell.
    sys.unraisablehook = lambda unraisable: None
    if may_raise_in(frame):
        raise Stopped
    again = threading.Timer(_AGAIN_S, signal.raise_signal, (number,))
    again.daemon = True
    again.start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        # One that is killed cannot say goodbye.
        parent.join()
        os._exit(1)


class Stopped(SystemExit):
    """The process that has begun this one does not want its task any more.

    Wherever it is raised, between two tasks too, Python ends the process without a word.
    """


def _end(processes: Iterable[BaseProcess]) -> None:
    """End processes: wait for them a moment, let them unwind, then kill them."""
    for seconds, make_them in (
        (_FINISHING_S, BaseProcess.terminate),
        (_UNWINDING_S, BaseProcess.kill),
    ):
        until_s = time.monotonic() + seconds
        for process in processes:
            process.join(max(until_s - time.monotonic(), 0))
            if process.is_alive():
                make_them(process)
    for process in processes:
        process.join()


@contextmanager
def interrupts_held_back() -> Iterator[None]:
    """Let processes that begin in the block ignore Ctrl-C, from their first line on.

    A terminal sends it to all processes; it is for the parent, which asks the others to stop.
    They inherit the parent's mask of signals. For the parent it waits for the end of the block,
    as does SIGTERM: it must not meet a process half begun, nor be lost, as with `signal.SIG_IGN`.
    """
    can_mask = hasattr(signal, "pthread_sigmask")
    held_back: list[int] = []
    before: dict[signal.Signals, signal._HANDLER] = {}
    if threading.current_thread() is threading.main_thread():
        # The mask alone is not enough: threads of numerical libraries have their own. A handler
        # that is not Python's could not be put back.
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not None:
                before[number] = signal.signal(number, lambda heard, _: held_back.append(heard))
    if can_mask:
        _start_tracker()
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if can_mask:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in before.items():
            signal.signal(number, handler)
    if held_back:
        signal.raise_signal(held_back[0])


def _start_tracker() -> None:
    """Start Python's tracker of semaphores, if it does not run: to start it unblocks signals.

    It frees what a process leaves that had to end at once, and need not tell the person of it.
    """
    try:
        from multiprocessing import resource_tracker
    except ImportError:  # a system without shared semaphores
        return
    quiet = "ignore::UserWarning:multiprocessing.resource_tracker"
    sys.warnoptions.append(quiet)  # what a process of Python hands on to those that it begins
    try:
        resource_tracker.ensure_running()
    finally:
        sys.warnoptions.remove(quiet)


deaf_children = interrupts_held_back
"""Former name of `interrupts_held_back`."""
