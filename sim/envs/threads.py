"""How many threads environments step with: the one place that decides.

Numba's threads, those of a learning library and the processes of a pool slow one another down
many times over when each takes every core. So an environment steps with one thread, be it single
or a vector of a few robots, and whatever it is in a worker process; a vector of many robots in the
main process takes all cores that the process may use. ``threads`` of an environment says otherwise
for that one, the variable ``SONARBED_THREADS`` for all that do not. What is computed is the same,
to the last bit.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Iterator
from contextlib import contextmanager

from sonarmap.cores import usable_cores
from sonarmap.errors import InputError, whole

__all__ = ["SETTING", "numba_threads", "threads_for", "usable_cores"]

SETTING = "SONARBED_THREADS"
"""The environment variable: a number, or "all"."""

# Fewer robots take less time than threads that have to wait for a busy core.
_MANY = 64

# Numba's threads do not outlive a fork, and its OpenMP layer ends a child that calls for them.
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


@contextmanager
def numba_threads(count: int) -> Iterator[bool]:
    """Let numba use so many threads for a moment.

    Yields
    ------
    bool
        Whether compiled loops may run in parallel at all: not with one thread, and not in a
        forked process, where numba's threads are gone.
    """
    if count == 1 or _forked:
        yield False
        return
    import numba  # heavy: loaded by whoever has compiled loops

    before = numba.get_num_threads()
    count = min(count, numba.config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]
    if count == before:
        yield count > 1
        return
    numba.set_num_threads(count)
    try:
        yield count > 1
    finally:
        numba.set_num_threads(before)


def _checked(name: str, wanted: int | str) -> int:
    if isinstance(wanted, str):
        if wanted != "all":
            raise InputError(f"{name} must be a whole number >= 1 or 'all', got {wanted!r}")
        return usable_cores()
    return whole(name, wanted, least=1)
