"""From the network of the training library to the weights that ship."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from torch import Tensor, nn

from mapper_training.network import UNet
from sonarmap.learned.weights import Layer, Weights

__all__ = ["weights_of"]


def weights_of(net: UNet) -> Weights:
    """Return the weights of a network, batch normalisation folded in, rounded as in files."""
    return Weights(
        tuple(net.widths),
        tuple(_pair(pair) for pair in net.down),
        tuple(_pair(pair) for pair in net.up),
        _array(net.head.weight)[:, :, 0, 0],
        _array(net.head.bias)[:, None],
    )


def _pair(pair: nn.Module) -> tuple[Layer, Layer]:
    first, first_norm, _, second, second_norm, _ = pair.children()
    return _folded(first, first_norm), _folded(second, second_norm)


def _folded(convolution: nn.Module, norm: nn.Module) -> Layer:
    scale = _array(norm.weight) / np.sqrt(_array(norm.running_var) + norm.eps)  # type: ignore[arg-type]
    kernel = _array(convolution.weight) * scale[:, None, None, None]  # type: ignore[arg-type]
    bias = _array(norm.bias) - _array(norm.running_mean) * scale  # type: ignore[arg-type]
    # (after, before, row, column) -> (after, row, column, before)
    flat = kernel.transpose(0, 2, 3, 1).reshape(kernel.shape[0], -1)
    return Layer(flat.astype(np.float16).astype(np.float32), bias[:, None].astype(np.float32))


def _array(values: Tensor) -> NDArray[np.float32]:
    return np.ascontiguousarray(values.detach().float().cpu().numpy())
