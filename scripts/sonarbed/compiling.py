"""A line for people when a command compiles for long, as it does the first time."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

__all__ = ["LINE", "told_of_compiling"]

LINE = (
    "compiling for the first use, which may take a minute; it is kept for the next time where that "
    "can be (`sonarbed warmup` does all of it)"
)
# Nobody wonders before.
_PATIENCE_S, _EVERY_S = 5.0, 0.5


@contextmanager
def told_of_compiling(patience_s: float = _PATIENCE_S) -> Iterator[None]:
    """Say on standard error, once, that numba compiles, if it still does after so many seconds.

    Nothing is imported for it: a look at what the thread is doing tells.
    """
    ended, thread = threading.Event(), threading.get_ident()
    watch = threading.Thread(target=_watch, args=(thread, ended, patience_s), daemon=True)
    watch.start()
    try:
        yield
    finally:
        ended.set()


def _watch(thread: int, ended: threading.Event, patience_s: float) -> None:
    compiled_s = 0.0
    while not ended.wait(_EVERY_S):
        if _is_compiling(sys._current_frames().get(thread)):
            compiled_s += _EVERY_S
        if compiled_s >= patience_s:
            with suppress(OSError, ValueError):  # nobody reads, or the stream is closed
                sys.stderr.write(f"sonarbed: {LINE}\n")
                sys.stderr.flush()
            return


def _is_compiling(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_globals.get("__name__", "").startswith("numba.core.compiler"):
            return True
        frame = frame.f_back
    return False
