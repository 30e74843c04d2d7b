"""How many cores this process may use, and how many its linear algebra takes."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["one_blas_thread", "usable_cores"]

_CGROUP = Path("/sys/fs/cgroup")


def usable_cores() -> int:
    """Return how many cores this process may use, at least one.

    Those that its affinity allows, and in a container no more than its share of time (cgroups).
    """
    try:
        cores = len(os.sched_getaffinity(0))
    except AttributeError:  # not on Linux
        cores = os.cpu_count() or 1
    return max(1, min(cores, _share_of_time()))


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Let the linear algebra of numpy and scipy use one thread in the block.

    For many small products: those of several threads wait for each other by spinning, which helps
    little on free cores and takes thirty times as long where one of the cores is taken.
    """
    from threadpoolctl import ThreadpoolController  # looks at the libraries that are loaded by now

    with ThreadpoolController().limit(limits=1, user_api="blas"):
        yield


def _share_of_time() -> int:
    """Return how many cores the time that a container grants makes, rounded up."""
    for quota, period in (
        ("cpu.max", None),
        ("cpu/cpu.cfs_quota_us", "cpu/cpu.cfs_period_us"),
    ):
        try:
            words = (_CGROUP / quota).read_text().split()
            if period is not None:
                words += (_CGROUP / period).read_text().split()
            granted_us, of_us = float(words[0]), float(words[1])
        except (OSError, ValueError, IndexError):  # no such file, or "max": no limit
            continue
        if granted_us > 0 and of_us > 0:
            return math.ceil(granted_us / of_us)
    return os.cpu_count() or 1
