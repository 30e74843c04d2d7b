"""`read_pixels`: the grey of an image and its alpha, whatever the image's kind."""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError

if TYPE_CHECKING:
    from PIL.Image import Image

__all__ = ["Pixels", "read_pixels"]

# 500 m on a side at 5 cm; what is larger is rather a damaged header than a map.
_MAX_PIXELS = 100_000_000

# Magic number, width, height, maximum, with comments between them, and one white space.
_PGM = re.compile(rb"P([25])" + 3 * rb"(?:\s|#[^\r\n]*[\r\n])+(\d{1,9})" + rb"(?!\d)\s?")
_COMMENT = re.compile(rb"#[^\r\n]*")


@dataclass(frozen=True, slots=True, eq=False)
class Pixels:
    """An image in grey.

    Parameters
    ----------
    grey : ndarray of float, shape (rows, cols)
        Mean of the colours of each pixel, 0 to `white`; row 0 is the top one.
    white : int
        The largest value that a pixel can have: 255 or 65535, in a PGM any between.
    alpha : ndarray of float, shape (rows, cols), or None
        How opaque each pixel is, 0 to `white`; None for an image that cannot be transparent.
    """

    grey: NDArray[np.float64]
    white: int
    alpha: NDArray[np.float64] | None = None


def read_pixels(path: Path) -> Pixels:
    """Read a PGM (binary or text, 8 or 16 bit), a PNG, or another kind that Pillow knows.

    Raises
    ------
    InputError
        If there is no such file, or it is not an image, truncated, or absurdly large; the message
        starts with the file.
    """
    if not path.is_file():
        # Not opened to find out: a device might never end.
        raise InputError(f"{path}: {'is not a file' if path.exists() else 'no such file'}")
    try:
        with path.open("rb") as file:
            is_pgm = file.read(2) in (b"P2", b"P5")
        # Not left to Pillow, which rounds greys of an uncommon maximum to 8 or 16 bits.
        return _pgm(path.read_bytes()) if is_pgm else _by_pillow(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _pgm(data: bytes) -> Pixels:
    header = _PGM.match(data)
    if header is None:
        raise InputError("is not a readable image: its PGM header is damaged")
    kind, cols, rows, white = (int(number) for number in header.groups())
    _check_size(rows, cols)
    if not 1 <= white <= 65535:
        raise InputError(f"is not a readable image: its maximum must be 1 to 65535, got {white}")
    body, count = data[header.end() :], rows * cols
    values = _words(body, count) if kind == 2 else _raster(body, count, white)
    if (values < 0).any() or (values > white).any():
        worst = values[(values < 0) | (values > white)][0]
        raise InputError(f"is damaged: its values must be 0 to {white}, got {worst}")
    return Pixels(values.reshape(rows, cols).astype(float), white)


def _words(data: bytes, count: int) -> NDArray[np.int64]:
    words = _COMMENT.sub(b" ", data).split(maxsplit=count)[:count]
    _check_count(len(words), count)
    try:
        return np.array(words).astype(np.int64)
    except (ValueError, OverflowError):
        raise InputError("is damaged: its values must be whole numbers") from None


def _raster(data: bytes, count: int, white: int) -> NDArray[np.uint16]:
    kind = np.dtype("u1" if white < 256 else ">u2")
    _check_count(len(data) // kind.itemsize, count)
    return np.frombuffer(data, kind, count).astype(np.uint16)


def _by_pillow(path: Path) -> Pixels:
    from PIL import Image  # heavy: loaded when an image is read

    try:
        with warnings.catch_warnings():
            # Pillow warns of what is below our own limit.
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path) as image:
                _check_size(image.height, image.width)
                return _of_pillow(image)
    except InputError:
        raise
    except Exception as error:  # Pillow raises what its decoders happen to raise
        raise InputError(f"is not a readable image ({type(error).__name__})") from None


def _of_pillow(image: Image) -> Pixels:
    if image.mode.startswith("I"):  # 16 bit, grey
        grey = np.asarray(image).astype(float)
        if grey.min() < 0 or grey.max() > 65535:
            raise InputError("is not a readable image: its pixels have more than 16 bits")
        return Pixels(grey, 65535)
    if image.mode == "F":
        raise InputError("is not a readable image: its pixels are fractions of no known range")
    alpha = image.has_transparency_data
    channels = np.asarray(image.convert("RGBA" if alpha else "RGB")).astype(float)
    grey = channels[..., :3].sum(axis=2) / 3
    return Pixels(grey, 255, channels[..., 3] if alpha else None)


def _check_size(rows: int, cols: int) -> None:
    if not 1 <= rows * cols <= _MAX_PIXELS:
        raise InputError(f"must have 1 to {_MAX_PIXELS} pixels, got {cols} x {rows}")


def _check_count(got: int, wanted: int) -> None:
    if got < wanted:
        raise InputError(f"is truncated: it must have {wanted} pixels, got {got}")
