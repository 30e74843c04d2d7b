"""Where a handler of signals may not raise."""

from __future__ import annotations

from types import FrameType

__all__ = ["may_raise_in"]

# What compiled code calls of Python's when it returns: it restores types from a pickle, and makes
# named tuples. Numba takes an error there for a value, and crashes (0.68).
_CALLED_BY_COMPILED_CODE = ("numba.core.serialize", "namedtuple_")


def may_raise_in(frame: FrameType | None) -> bool:
    """Return whether a handler of signals may raise where a frame is; else it must wait."""
    if frame is None:
        return True
    return not str(frame.f_globals.get("__name__")).startswith(_CALLED_BY_COMPILED_CODE)
