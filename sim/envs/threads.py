"""How many threads environments step with: the one place that decides.

The threads of an environment, those of a learning library and the processes of a pool slow one
another down when each takes every core. So an environment steps with one thread, be it single
or a vector of a few robots, and whatever it is in a worker process; a vector of many robots in the
main process takes all cores that the process may use. ``threads`` of an environment says otherwise
for that one, the variable ``SONARBED_THREADS`` for all that do not. What is computed is the same,
to the last bit.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache

from sonarmap.cores import usable_cores
from sonarmap.errors import InputError, whole

__all__ = ["PARTS", "SETTING", "in_parts", "threads_for", "usable_cores"]

SETTING = "SONARBED_THREADS"
"""The environment variable: a number, or "all"."""

# Fewer robots take less time than threads that have to wait for a busy core.
_MANY = 64

PARTS = 64
"""The most parts that `in_parts` makes."""

# So that a thread whose core is busy keeps the others waiting for a small part only.
_PARTS_A_THREAD = 4

# Threads do not outlive a fork.
_forked = False


def _note_fork() -> None:
    global _forked
    _forked = True


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def threads_for(wanted: int | str | None, robots: int) -> int:
    """Return how many threads an environment steps with.

    Parameters
    ----------
    wanted : int, "all" or None
        What it asks for; None for what `SETTING` says, or else for the rule of this module.
    robots : int
        How many robots it has.

    Raises
    ------
    InputError
        If it is none of these.
    """
    if wanted is None and (setting := os.environ.get(SETTING)):
        return _checked(SETTING, int(setting) if setting.isdecimal() else setting)
    if wanted is not None:
        return _checked("threads", wanted)
    is_worker = multiprocessing.parent_process() is not None
    return 1 if robots < _MANY or is_worker else usable_cores()


def in_parts(work: Callable[[int, int, int], None], count: int, threads: int) -> None:
    """Call ``work(begin, end, part)`` for the parts of ``range(count)``, by so many threads.

    The threads are Python's and sleep when there is nothing to do. (Numba's own spin while they
    wait. On a core that another library's thread or another process needs they took ten times as
    long as one thread.) This thread takes parts, too; so where no other core is free, nearly all is
    done as if it were alone.

    Parameters
    ----------
    work : callable
        Compiled code that drops Python's lock, for rows ``begin`` to ``end``. Parts are numbered
        from 0, at most `PARTS` of them.
    count : int
        How many rows there are.
    threads : int
        How many threads; in a forked process, where those of the pool are gone, always one.
    """
    parts = min(count, _PARTS_A_THREAD * threads, PARTS)
    if threads == 1 or parts <= 1 or _forked:
        work(0, count, 0)
        return
    left = iter(range(parts))  # to take the next of it is one step of Python's: no two get the same

    def take() -> None:
        for part in left:
            work(count * part // parts, count * (part + 1) // parts, part)

    helpers = [_pool(threads - 1).submit(take) for _ in range(min(threads, parts) - 1)]
    try:
        take()
    finally:
        # One that has not begun has nothing left to do; the others must end before anybody reads.
        begun = [helper for helper in helpers if not helper.cancel()]
        wait(begun)
    for helper in begun:
        helper.result()


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="sonarbed-step")


def _checked(name: str, wanted: int | str) -> int:
    if isinstance(wanted, str):
        if wanted != "all":
            raise InputError(f"{name} must be a whole number >= 1 or 'all', got {wanted!r}")
        return usable_cores()
    return whole(name, wanted, least=1)
