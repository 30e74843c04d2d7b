"""Frames as a film: a small GIF that any browser shows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import KDTree

from sim.envs.pictures.frames import check_frame
from sonarmap import InputError
from sonarmap.errors import within
from sonarmap.files import atomic_path

__all__ = ["write_gif"]

_Bytes = NDArray[np.uint8]

# Browsers show a frame that asks for less than 0.02 s for 0.1 s; a minute a frame is a slip.
_FPS = (1 / 60, 50.0)
# A palette is found from this many frames, spread over the film.
_SAMPLED_FRAMES = 12
# One of the 256 numbers of a GIF stands for "as in the frame before".
_COLOURS = 255
_ALL_COLOURS = 1 << 24


def write_gif(frames: Sequence[_Bytes], path: str | Path, *, fps: float) -> None:
    """Write a film that repeats for ever.

    Parameters
    ----------
    frames : sequence of ndarray of uint8, shape (height, width, 3)
        At least one, all of the same shape.
    path : str or Path
        The file; an older one is replaced only when all is written.
    fps : float
        Frames a second, within [1/60, 50]. GIF counts hundredths of a second: each frame begins
        at the one nearest to its time, so that a long film keeps its pace.

    Raises
    ------
    InputError
        If there are no frames, one has another shape or type, `fps` is out of its bounds, or
        the file cannot be written.

    Notes
    -----
    All frames share one palette and are not dithered: what did not change from one frame to the
    next takes hardly any space.
    """
    fps = within("fps", fps, *_FPS)
    _check(frames)
    palette = _palette(frames)
    numbers = _nearest(palette, frames)
    pictures = [_numbered(numbers[_packed(frame)], palette) for frame in frames]
    with atomic_path(path) as beside:
        pictures[0].save(
            beside,
            format="GIF",
            save_all=True,
            append_images=pictures[1:],
            duration=_durations_ms(len(frames), fps),
            loop=0,
            # Stated once, where Pillow would write it again with each frame.
            palette=palette.tobytes(),
            # Pixels that stay as they are get a number that no colour has.
            optimize=True,
        )


def _check(frames: Sequence[_Bytes]) -> None:
    if len(frames) == 0:
        raise InputError("frames must have at least one frame, got none")
    for number, frame in enumerate(frames):
        check_frame(f"frames[{number}]", frame)
        if frame.shape != frames[0].shape:
            raise InputError(
                f"frames[{number}] must have the shape of the first, {frames[0].shape}, "
                f"got {frame.shape}"
            )


def _palette(frames: Sequence[_Bytes]) -> _Bytes:
    """Return 256 colours, shape (256, 3), of which the last is never used.

    One colour after the other is taken: the one that many pixels have, or that is far from all
    taken before. A mean of colours would turn the few pixels of a rare cause grey.
    """
    chosen = np.unique(np.linspace(0, len(frames) - 1, _SAMPLED_FRAMES).round().astype(int))
    sampled = np.concatenate([_packed(frames[number]).ravel() for number in chosen])
    packed, counts = np.unique(sampled, return_counts=True)
    colours = _unpacked(packed)
    palette = np.zeros((_COLOURS + 1, 3), np.uint8)
    misfit = np.full(len(colours), 3.0 * 255**2)
    for number in range(min(_COLOURS, len(colours))):
        taken = colours[np.argmax(counts * misfit)]
        palette[number] = taken
        misfit = np.minimum(misfit, ((colours - taken.astype(float)) ** 2).sum(axis=1))
    return palette


def _nearest(palette: _Bytes, frames: Sequence[_Bytes]) -> _Bytes:
    """Return the number of the nearest colour of the palette for each colour in the frames."""
    is_there = np.zeros(_ALL_COLOURS, bool)
    for frame in frames:
        is_there[_packed(frame)] = True
    (packed,) = is_there.nonzero()
    numbers = np.zeros(_ALL_COLOURS, np.uint8)
    numbers[packed] = KDTree(palette[:_COLOURS]).query(_unpacked(packed))[1]
    return numbers


def _numbered(numbers: _Bytes, palette: _Bytes) -> Image.Image:
    picture = Image.fromarray(numbers)
    picture.putpalette(palette.tobytes())
    return picture


def _packed(frame: _Bytes) -> NDArray[np.int32]:
    """Return each colour as one number."""
    red, green, blue = np.moveaxis(frame.astype(np.int32), -1, 0)
    packed: NDArray[np.int32] = red << 16 | green << 8 | blue
    return packed


def _unpacked(packed: NDArray[np.integer]) -> _Bytes:
    return np.stack([packed >> 16, packed >> 8 & 255, packed & 255], axis=-1).astype(np.uint8)


def _durations_ms(count: int, fps: float) -> list[int]:
    begins = np.round(100 * np.arange(count + 1) / fps).astype(int)
    durations_ms: list[int] = (10 * np.diff(begins)).tolist()
    return durations_ms
