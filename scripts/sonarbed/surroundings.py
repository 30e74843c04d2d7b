"""What a command needs around it and may not find: streams, a cache that can be written."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["open_streams", "quiet_matplotlib"]


def open_streams() -> None:
    """Open what is closed of standard input, output and error, towards nothing.

    A file that is opened later would take the number of a closed one, and what C code prints, as
    an engine does, would end in it.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_RDWR)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
    for name in ("stdin", "stdout", "stderr"):
        stream = getattr(sys, name)
        # None where Python itself found it closed.
        if stream is None or getattr(stream, "closed", False):
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(os.devnull, mode, encoding="utf-8"))  # noqa: SIM115, PTH123


@contextmanager
def quiet_matplotlib() -> Iterator[None]:
    """Keep Matplotlib from telling of its caches while the block runs.

    Without a home it makes a folder of its own for each process: slower, but it works, and nobody
    need be told. Fontconfig, which it asks for fonts, has the same to say and is not asked.
    """
    logger = logging.getLogger("matplotlib")
    before = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(before)
