"""The network in the training library: a small U-Net over the channels of a log."""

from __future__ import annotations

import torch
from torch import Tensor, nn

__all__ = ["UNet"]


class UNet(nn.Module):
    """Two logits a cell, occupied and observable, from the channels; see `sonarmap.learned`.

    Parameters
    ----------
    channels : int
        Channels that come in.
    widths : tuple of int
        Channels of each level; from one to the next the cells are twice as large.
    """

    def __init__(self, channels: int, widths: tuple[int, ...]) -> None:
        super().__init__()
        self.widths = widths
        before = (channels, *widths[:-1])
        self.down = nn.ModuleList(_Pair(n, m) for n, m in zip(before, widths, strict=True))
        self.up = nn.ModuleList(
            _Pair(deep + level, level)
            for level, deep in zip(widths[-2::-1], widths[:0:-1], strict=True)
        )
        self.head = nn.Conv2d(widths[0], 2, 1)

    def forward(self, x: Tensor) -> Tensor:
        """Return logits, shape (batch, 2, rows, cols); rows and cols divide by 2**(levels - 1)."""
        levels = []
        for number, pair in enumerate(self.down):
            x = pair(x if number == 0 else nn.functional.max_pool2d(x, 2))
            levels.append(x)
        for pair, level in zip(self.up, levels[-2::-1], strict=True):
            x = pair(torch.cat([nn.functional.interpolate(x, scale_factor=2), level], 1))
        logits: Tensor = self.head(x)
        return logits


class _Pair(nn.Sequential):
    """Two convolutions with batch normalisation and a ramp after each."""

    def __init__(self, before: int, after: int) -> None:
        super().__init__(
            nn.Conv2d(before, after, 3, padding=1, bias=False),
            nn.BatchNorm2d(after),
            nn.ReLU(),
            nn.Conv2d(after, after, 3, padding=1, bias=False),
            nn.BatchNorm2d(after),
            nn.ReLU(),
        )
