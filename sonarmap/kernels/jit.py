"""Numba's `njit` as this project uses it: what is compiled is kept on disk where that can be."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

__all__ = ["njit"]


def njit(*, makes_arrays: bool = True, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles a function when it is first called.

    The compiled code is kept beside the source or, where that may not be written, in the user's
    cache. Where there is neither, as for a service without a home, every process compiles anew:
    slower, but it works. (Numba itself refuses such a place, already when a module is imported.)

    It runs without Python's lock, so that other threads go on: one of them hears Ctrl-C.

    Parameters
    ----------
    makes_arrays : bool
        False for a function that makes no arrays, cuts none out of others and returns none, nor
        lets others do so: then nobody counts references to those that it is given, which can cost
        more than what it computes. Of any other function memory is lost or freed too early.
    **options
        As for `numba.njit`, but for ``cache`` and ``nogil``.
    """
    if not makes_arrays:
        options["_nrt"] = False  # numba's own switch of its runtime; it has no public name

    def compiled(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(cache=True, nogil=True, **options)(function)
        except RuntimeError as error:
            if "no locator available" not in str(error):
                raise
            return numba.njit(nogil=True, **options)(function)

    return compiled
