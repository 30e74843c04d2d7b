"""What a frame is: the one check of pictures that come from outside."""

from __future__ import annotations

import numpy as np

from sonarmap import InputError

__all__ = ["check_frame"]


def check_frame(name: str, frame: np.ndarray) -> None:
    """Raise `InputError` unless `frame` is an array of uint8 of shape (height, width, 3)."""
    frame = np.asarray(frame)
    if frame.dtype != np.uint8 or frame.ndim != 3 or frame.shape[2] != 3 or frame.size == 0:
        raise InputError(
            f"{name} must be uint8 of shape (height, width, 3), "
            f"got {frame.dtype} of shape {frame.shape}"
        )
