"""Ctrl-C: said at once, and over within three seconds, whatever a command is at."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from types import FrameType

from sonarmap.interrupts import may_raise_in

__all__ = ["INTERRUPTED", "STOPPED", "Interruption"]

INTERRUPTED = 130
"""Exit code as shells know it: 128 + 2."""
STOPPED = "interrupted; what was finished is kept"
# What takes longer to clear up is left, seconds.
_PATIENCE_S = 2.3
_AGAIN_S = 0.01


class Interruption:
    """What a person was told of the end of a command.

    Parameters
    ----------
    ends_process : bool
        Whether the process ends with the command. Then it does so in time also where Python is
        not asked, in compiled code; one that lives on, as a notebook, is left to itself.
    """

    def __init__(self, *, ends_process: bool) -> None:
        self.ends_process = ends_process
        self._times, self._told = count(), threading.Event()
        self.is_heard = False

    @contextmanager
    def heard(self) -> Iterator[None]:
        """Hear Ctrl-C while the block runs, and take SIGTERM as one: workers end with us.

        Only the main thread may, and need, care for signals.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        # Where Ctrl-C is ignored, as in a job of the background, it stays so.
        signals = [signal.SIGTERM]
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signals.append(signal.SIGINT)
        if self.ends_process:
            sys.unraisablehook = self._swallowed
            self._listen(signals)
        before = {number: signal.signal(number, self._interrupt) for number in signals}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def wait_told(self) -> bool:
        """Wait until the person is told, if Ctrl-C was heard; return whether it was."""
        return self.is_heard and self._told.wait(1.0)

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        self._tell()
        if may_raise_in(frame):
            raise KeyboardInterrupt
        self._again()

    def _listen(self, signals: list[signal.Signals]) -> None:
        """Hear signals also while compiled code runs, which no handler of Python's interrupts."""
        end, begin = os.pipe()
        os.set_blocking(begin, False)
        signal.set_wakeup_fd(begin, warn_on_full_buffer=False)

        def listen() -> None:
            while (heard := os.read(end, 1)) and heard[0] not in signals:
                pass
            self._tell()

        threading.Thread(target=listen, daemon=True).start()

    def _swallowed(self, what: sys.UnraisableHookArgs) -> None:
        # Python must go on in a callback of C, and would tell that it does.
        if isinstance(what.exc_value, KeyboardInterrupt):
            self._again()
        elif not self.is_heard:
            sys.__unraisablehook__(what)

    def _again(self) -> None:
        """Interrupt once more, a moment later."""
        again = threading.Timer(_AGAIN_S, signal.raise_signal, (signal.SIGTERM,))
        again.daemon = True
        again.start()

    def _tell(self) -> None:
        """Tell the person, once, and begin to count."""
        if next(self._times):
            return
        self.is_heard = True
        # Not by `print`, which may be interrupted.
        with suppress(OSError):
            os.write(2, f"sonarbed: {STOPPED}\n".encode())
        self._told.set()
        if self.ends_process:
            timer = threading.Timer(_PATIENCE_S, os._exit, (INTERRUPTED,))
            timer.daemon = True
            timer.start()
            # A compiler may keep Python's threads from running; this one is C's. It ends with 1.
            nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123 - while we live
            faulthandler.dump_traceback_later(_PATIENCE_S + 0.5, exit=True, file=nowhere)
