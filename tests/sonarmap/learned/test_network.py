"""The forward pass: against plain loops over cells, and over tiles."""

import numpy as np
import pytest
from learned_weights import small_weights

from sonarmap.learned import network


def convolved(layer, x):
    """A 3 x 3 convolution and a ramp, cell by cell; beyond the border is 0."""
    before, rows, cols = x.shape
    kernel = layer.kernel.reshape(-1, 3, 3, before).astype(float)
    out = np.zeros((kernel.shape[0], rows, cols))
    for row in range(rows):
        for col in range(cols):
            total = layer.bias[:, 0].astype(float)
            for i in range(3):
                for j in range(3):
                    at = row + i - 1, col + j - 1
                    if 0 <= at[0] < rows and 0 <= at[1] < cols:
                        total = total + kernel[:, i, j] @ x[:, *at]
            out[:, row, col] = np.maximum(total, 0)
    return out


def plain_logits(weights, x):
    """The U-Net in plain words; rows and columns divide by the coarsest cell."""
    levels = []
    for number, pair in enumerate(weights.down):
        if number:
            rows, cols = x.shape[1:]
            x = x.reshape(len(x), rows // 2, 2, cols // 2, 2).max(axis=(2, 4))
        for layer in pair:
            x = convolved(layer, x)
        levels.append(x)
    for pair, level in zip(weights.up, levels[-2::-1], strict=True):
        x = np.concatenate([x.repeat(2, axis=1).repeat(2, axis=2), level])
        for layer in pair:
            x = convolved(layer, x)
    return np.tensordot(weights.head, x, 1) + weights.head_bias[:, :, None]


def test_the_forward_pass_is_that_of_plain_loops(rng):
    weights = small_weights(rng, channels=3)
    x = rng.random((3, 12, 20)).astype(np.float32)
    np.testing.assert_allclose(network.logits(weights, x), plain_logits(weights, x), atol=1e-4)


@pytest.mark.parametrize("shape", [(1, 1), (3, 17), (13, 8)])
def test_a_grid_of_any_shape_is_as_if_zeros_lay_beyond(shape, rng):
    weights = small_weights(rng, channels=3)
    x = rng.random((3, *shape)).astype(np.float32)
    rows, cols = (-(-n // 4) * 4 for n in shape)
    padded = np.zeros((3, rows, cols), np.float32)
    padded[:, : shape[0], : shape[1]] = x
    wanted = plain_logits(weights, padded)[:, : shape[0], : shape[1]]
    np.testing.assert_allclose(network.logits(weights, x), wanted, atol=1e-4)


def test_tiles_make_no_seam(rng, monkeypatch):
    weights = small_weights(rng, channels=3)
    x = rng.random((3, 70, 90)).astype(np.float32)
    whole = network.logits(weights, x)
    monkeypatch.setattr(network, "_TILE", 32)
    np.testing.assert_allclose(network.logits(weights, x), whole, atol=1e-5)
    # A halo that is too narrow shows.
    monkeypatch.setattr(network, "_HALO", 8)
    assert np.abs(network.logits(weights, x) - whole).max() > 1e-3


def test_blocks_make_no_seam(rng, monkeypatch):
    weights = small_weights(rng, channels=3)
    x = rng.random((3, 16, 24)).astype(np.float32)
    whole = network.logits(weights, x)
    monkeypatch.setattr(network, "_BLOCK", 37)
    np.testing.assert_allclose(network.logits(weights, x), whole, atol=1e-5)
