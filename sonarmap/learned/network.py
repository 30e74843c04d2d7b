"""The forward pass of the U-Net in numpy: convolutions as products of matrices, block by block.

Maps lie in memory with a border of zeros, flat. A neighbour is then a fixed number of places away,
and a 3 x 3 convolution is the product of its kernel with nine shifted copies. Made for a block of
cells at a time, these stay in the processor's cache. What comes out on the border is not wanted,
and is cleared.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from sonarmap.cores import one_blas_thread
from sonarmap.learned.weights import Layer, Weights

__all__ = ["logits"]

# Cells whose neighbours are copied at a time.
_BLOCK = 512
# Cells of a side: a larger map is made in tiles of this, with as much around each as the network
# looks at (51 cells with four levels), so that its memory is that of a tile. Multiples of 8.
_TILE, _HALO = 384, 56


def logits(weights: Weights, channels: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the logits of each cell, occupied and observable, shape (2, rows, cols).

    Parameters
    ----------
    weights : Weights
        The network.
    channels : ndarray of float32, shape (channels, rows, cols)
        See `sonarmap.learned.channels`; any number of rows and columns.
    """
    rows, cols = channels.shape[1:]
    out = np.empty((2, rows, cols), np.float32)
    with one_blas_thread():
        for top, left in product(range(0, rows, _TILE), range(0, cols, _TILE)):
            low, high = max(top - _HALO, 0), min(top + _TILE + _HALO, rows)
            west, east = max(left - _HALO, 0), min(left + _TILE + _HALO, cols)
            tile = _tile_logits(weights, channels[:, low:high, west:east])
            part = out[:, top : top + _TILE, left : left + _TILE]
            part[:] = tile[
                :, top - low : top - low + part.shape[1], left - west : left - west + part.shape[2]
            ]
    return out


def _tile_logits(weights: Weights, channels: NDArray[np.float32]) -> NDArray[np.float32]:
    count, rows, cols = channels.shape
    step = 2 ** (len(weights.widths) - 1)
    high, wide = -(-rows // step) * step, -(-cols // step) * step
    x = np.zeros((count, high + 2, wide + 2), np.float32)
    x[:, 1 : rows + 1, 1 : cols + 1] = channels
    levels: list[NDArray[np.float32]] = []
    for number, pair in enumerate(weights.down):
        x = _pair(pair, x if number == 0 else _halved(x))
        levels.append(x)
    for pair, level in zip(weights.up, levels[-2::-1], strict=True):
        both = np.empty((x.shape[0] + level.shape[0], *level.shape[1:]), np.float32)
        _double(x, both[: x.shape[0]])
        both[x.shape[0] :] = level
        x = _pair(pair, both)
    inside = x[:, 1 : rows + 1, 1 : cols + 1].reshape(x.shape[0], -1)
    made: NDArray[np.float32] = (weights.head @ inside + weights.head_bias).reshape(2, rows, cols)
    return made


def _pair(pair: tuple[Layer, Layer], x: NDArray[np.float32]) -> NDArray[np.float32]:
    return _convolved(pair[1], _convolved(pair[0], x))


def _convolved(layer: Layer, x: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return max(0, kernel * x + bias), shape (after, rows + 2, cols + 2), zero on the border."""
    before, high, wide = x.shape
    after = layer.bias.shape[0]
    flat = x.reshape(before, -1)
    out = np.zeros((after, high * wide), np.float32)
    begin, end = wide + 1, high * wide - wide - 1
    shifts = [(row - 1) * wide + col - 1 for row in range(3) for col in range(3)]
    around = np.empty((9 * before, _BLOCK), np.float32)
    for first in range(begin, end, _BLOCK):
        size = min(_BLOCK, end - first)
        for number, shift in enumerate(shifts):
            around[number * before : (number + 1) * before, :size] = flat[
                :, first + shift : first + shift + size
            ]
        block = layer.kernel @ around[:, :size]
        block += layer.bias
        np.maximum(block, 0, out=out[:, first : first + size])
    made = out.reshape(after, high, wide)
    made[:, :, 0] = 0
    made[:, :, -1] = 0
    return made


def _halved(x: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the largest of each four cells, with a border again."""
    inside = x[:, 1:-1, 1:-1]
    pooled = np.maximum(inside[:, ::2], inside[:, 1::2])
    pooled = np.maximum(pooled[:, :, ::2], pooled[:, :, 1::2])
    return np.pad(pooled, ((0, 0), (1, 1), (1, 1)))


def _double(x: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Write each cell as four; the border stays zero."""
    inside = x[:, 1:-1, 1:-1]
    out[:, (0, -1)] = 0
    out[:, :, (0, -1)] = 0
    target = out[:, 1:-1, 1:-1]
    for row in range(2):
        for col in range(2):
            target[:, row::2, col::2] = inside
