"""A window on the screen that shows frames, for ``render_mode="human"``."""

from __future__ import annotations

import os
from types import ModuleType
from typing import Any

import numpy as np
from gymnasium.error import DependencyNotInstalled
from numpy.typing import NDArray

from sim.envs.pictures.frames import check_frame
from sonarmap.errors import positive

__all__ = ["Window"]


class Window:
    """A window that shows one frame after the other, no faster than its frame rate.

    It opens with the first frame and takes the size of each. When the user closes it, it stays
    closed: later frames are ignored, so that a training run goes on.

    Parameters
    ----------
    fps : float
        Frames a second, > 0. `show` waits for as long as this needs.
    title : str
        What the window's bar says.

    Raises
    ------
    InputError
        If `fps` is not a number > 0.
    DependencyNotInstalled
        If pygame is not installed.
    """

    def __init__(self, *, fps: float, title: str = "sonarbed") -> None:
        self._fps = positive("fps", fps)
        self._title = title
        self._pygame = _pygame()
        self._clock = self._pygame.time.Clock()
        self._window: Any = None
        self._is_closed = False

    @property
    def is_closed(self) -> bool:
        """Whether `close` was called or the user closed the window."""
        return self._is_closed

    def show(self, frame: NDArray[np.uint8]) -> None:
        """Show a frame, and wait until the next one is due; nothing when the window is closed.

        Parameters
        ----------
        frame : ndarray of uint8, shape (height, width, 3)
            What `sim.envs.pictures.drawing.draw` returns.

        Raises
        ------
        InputError
            If the frame has another shape or type.
        """
        check_frame("frame", frame)
        self._close_if_asked()
        if self._is_closed:
            return
        size = (frame.shape[1], frame.shape[0])
        if self._window is None:
            self._pygame.display.init()
            self._window = self._pygame.Window(self._title, size)
        elif self._window.size != size:
            self._window.size = size
        picture = self._pygame.image.frombuffer(np.ascontiguousarray(frame), size, "RGB")
        self._window.get_surface().blit(picture, (0, 0))
        self._window.flip()
        self._clock.tick(self._fps)

    def close(self) -> None:
        """Close the window; closing it twice is fine."""
        self._is_closed = True
        if self._window is not None:
            # The window alone: other environments of this process may have theirs.
            self._window.destroy()
            self._window = None

    def _close_if_asked(self) -> None:
        if self._window is None:
            return
        pygame = self._pygame
        asked = pygame.event.get((pygame.WINDOWCLOSE, pygame.QUIT), pump=True)
        # Keys and mouse moves that nobody reads must not pile up.
        pygame.event.clear(pump=False)
        for event in asked:
            # The system asks a window, or the whole process, which is then each of its windows.
            if event.type == pygame.QUIT or event.window is self._window:
                self.close()
            else:
                pygame.event.post(event)


def _pygame() -> ModuleType:
    # Its greeting would land in the output of a program that only reads numbers from there.
    os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    try:
        import pygame
    except ImportError:
        raise DependencyNotInstalled(
            "render_mode 'human' needs pygame-ce: pip install 'sonarbed[gui]'"
        ) from None
    return pygame
