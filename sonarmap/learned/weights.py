"""`Weights`: what was learned, in one file that tells whether it is whole."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError
from sonarmap.files import atomic_path
from sonarmap.learned import channels

__all__ = ["CARD", "SHIPPED", "Calibration", "Layer", "Weights", "shipped"]

SHIPPED = Path(__file__).parent / "mapper.npz"
CARD = Path(__file__).parent / "mapper.md"
"""The model card of the shipped weights."""

_FORMAT = 1
_ABOUT, _DIGEST = "about", "digest"


@dataclass(frozen=True, eq=False)
class Layer:
    """A 3 x 3 convolution with its batch normalisation folded in.

    Parameters
    ----------
    kernel : ndarray of float32, shape (after, 9 * before)
        Weights; of a row the nine places are outermost, row by row.
    bias : ndarray of float32, shape (after, 1)
        Added before the ramp.
    """

    kernel: NDArray[np.float32]
    bias: NDArray[np.float32]


@dataclass(frozen=True)
class Calibration:
    """From a logit of the network to P: 1 / (1 + exp(-(scale * logit + offset))).

    Parameters
    ----------
    scale, offset : float
        Fitted on rooms that the network was not fitted to.
    """

    scale: float = 1.0
    offset: float = 0.0

    def probability(self, logit: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return P of logits."""
        p: NDArray[np.float64] = 0.5 * (
            1 + np.tanh((self.scale * logit.astype(float) + self.offset) / 2)
        )
        return p


@dataclass(frozen=True, eq=False)
class Weights:
    """Layers of a U-Net over the channels, and numbers that go with them.

    Parameters
    ----------
    widths : tuple of int
        Channels of each level.
    down, up : tuple of (Layer, Layer)
        The pairs of each level, from the finest to the coarsest and back.
    head : ndarray of float32, shape (2, widths[0])
        From the last layer to the logits, occupied and observable.
    head_bias : ndarray of float32, shape (2, 1)
        Added to them.
    calibrations : mapping
        By the cell size of a map over the network's own: 0.5, 1 and 2.
    occupied_from, free_up_to : float
        From where on, and up to where, a cell counts as occupied or free.
    share : float
        Share of walls among cells that nothing looked at.
    reading : mapping of ndarray
        The small network that judges readings, see `sonarmap.filters.consistency`; may be empty.
    digest : str
        SHA-256 of all of it.
    """

    widths: tuple[int, ...]
    down: tuple[tuple[Layer, Layer], ...]
    up: tuple[tuple[Layer, Layer], ...]
    head: NDArray[np.float32]
    head_bias: NDArray[np.float32]
    calibrations: Mapping[float, Calibration] = field(default_factory=lambda: {1.0: Calibration()})
    occupied_from: float = 0.2
    free_up_to: float = 0.1
    share: float = 0.06
    reading: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    digest: str = ""

    def save(self, path: str | Path) -> None:
        """Write the weights; kernels as float16, which is all that they need."""
        arrays: dict[str, NDArray[Any]] = {}
        for side, pairs in (("down", self.down), ("up", self.up)):
            for level, pair in enumerate(pairs):
                for number, layer in enumerate(pair):
                    name = f"{side}{level}{'ab'[number]}"
                    arrays[f"{name}_kernel"] = layer.kernel.astype(np.float16)
                    arrays[f"{name}_bias"] = layer.bias
        arrays["head_kernel"], arrays["head_bias"] = self.head, self.head_bias
        arrays |= {f"reading_{name}": values for name, values in self.reading.items()}
        about = {
            "format": _FORMAT,
            "channels": channels.VERSION,
            "widths": list(self.widths),
            "calibrations": {
                str(ratio): [each.scale, each.offset] for ratio, each in self.calibrations.items()
            },
            "occupied_from": self.occupied_from,
            "free_up_to": self.free_up_to,
            "share": self.share,
        }
        arrays[_ABOUT] = np.frombuffer(json.dumps(about, sort_keys=True).encode(), np.uint8)
        with atomic_path(Path(path)) as beside, beside.open("wb") as stream:
            np.savez_compressed(stream, **arrays, digest=np.array(_digest_of(arrays)))  # type: ignore[arg-type]

    @classmethod
    def load(cls, path: str | Path) -> Weights:
        """Read what `save` wrote.

        Raises
        ------
        InputError
            If there is no such file, it is cut short or no weights, its content is not what was
            written, or it is of another version.
        """
        arrays = _arrays(Path(path))
        digest = str(arrays.pop(_DIGEST, ""))
        if _ABOUT not in arrays:
            raise InputError(f"{path}: is no file of weights: it has no {_ABOUT!r}")
        if _digest_of(arrays) != digest:
            raise InputError(
                f"{path}: the weights are not what was written: their SHA-256 is not the digest "
                "in the file"
            )
        about = json.loads(arrays[_ABOUT].tobytes())
        for name, wanted in (("format", _FORMAT), ("channels", channels.VERSION)):
            if about.get(name) != wanted:
                raise InputError(
                    f"{path}: {name} must be {wanted}, got {about.get(name)!r}: the weights are "
                    "of another version"
                )
        levels = len(about["widths"])
        return cls(
            tuple(about["widths"]),
            _pairs(arrays, "down", levels),
            _pairs(arrays, "up", levels - 1),
            arrays["head_kernel"],
            arrays["head_bias"],
            {float(ratio): Calibration(*two) for ratio, two in about["calibrations"].items()},
            about["occupied_from"],
            about["free_up_to"],
            about["share"],
            {
                name.removeprefix("reading_"): values
                for name, values in arrays.items()
                if name.startswith("reading_")
            },
            digest,
        )

    def calibration(self, ratio: float) -> Calibration:
        """Return the calibration for cells `ratio` times the size of the network's own."""
        known = sorted(self.calibrations)
        place = np.log2(known)
        at = float(np.log2(ratio))
        scale, offset = (
            float(np.interp(at, place, [getattr(self.calibrations[each], name) for each in known]))
            for name in ("scale", "offset")
        )
        return Calibration(scale, offset)


@cache
def shipped(path: str | None = None) -> Weights:
    """Return the weights of a file, by default those that ship; a file is read once."""
    return Weights.load(SHIPPED if path is None else path)


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        # Opened here, because numpy leaves a damaged file open.
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            return {name: data[name] for name in data.files}
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except Exception as error:  # numpy raises what zip, npy or pickle happen to raise
        raise InputError(
            f"{path}: is no file of weights, or is cut short ({type(error).__name__})"
        ) from None


def _pairs(
    arrays: Mapping[str, NDArray[Any]], side: str, count: int
) -> tuple[tuple[Layer, Layer], ...]:
    def layer(name: str) -> Layer:
        return Layer(arrays[f"{name}_kernel"].astype(np.float32), arrays[f"{name}_bias"])

    return tuple((layer(f"{side}{level}a"), layer(f"{side}{level}b")) for level in range(count))


def _digest_of(arrays: Mapping[str, NDArray[Any]]) -> str:
    digest = sha256()
    for name in sorted(arrays):
        values = arrays[name]
        digest.update(f"{name} {values.dtype.str} {values.shape} ".encode())
        digest.update(np.ascontiguousarray(values).tobytes())
    return digest.hexdigest()
