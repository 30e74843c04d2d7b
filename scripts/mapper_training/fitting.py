"""Fits the network to examples: crops, turned and mirrored, drawn by step and seed alone."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn.functional import binary_cross_entropy_with_logits as cross_entropy

from mapper_training.examples import Example
from mapper_training.network import UNet
from sonarmap.files import atomic_path
from sonarmap.learned.channels import CHANNELS
from worlds import HIDDEN, OCCUPIED

__all__ = ["Fitting", "Progress", "fit", "logits_of", "mean_bits"]

_COS, _SIN = (list(CHANNELS).index(name) for name in ("cos_2", "sin_2"))
# Cells that no sonar could see count a little, so that P is right there too.
_UNSEEN_WEIGHT = 0.1
_OBSERVABLE_WEIGHT = 0.2


@dataclass(frozen=True)
class Fitting:
    """How the network is fitted.

    Parameters
    ----------
    widths : tuple of int
        Of the levels of the U-Net.
    steps : int
        Steps of AdamW.
    batch, crop : int
        Crops of a step, and their side in cells.
    rate : float
        Learning rate: it rises over the first `warm` steps, stays, and falls to 0 over the last
        `falling` share of the steps.
    seed : int
        Of the first weights and of the crops.
    threads : int
        Of the training library, where there is no GPU.
    """

    widths: tuple[int, ...] = (24, 36, 56, 80)
    steps: int = 3000
    batch: int = 32
    crop: int = 96
    rate: float = 3e-3
    warm: int = 100
    falling: float = 0.35
    decay: float = 1e-2
    averaging: float = 0.998
    seed: int = 0
    threads: int = 1

    def rate_at(self, step: int) -> float:
        """Return the learning rate of a step."""
        left = (self.steps - step) / max(self.falling * self.steps, 1)
        return self.rate * min((step + 1) / self.warm, 1.0, max(left, 0.0))


@dataclass(frozen=True)
class Progress:
    """How far the fitting is: step, seconds, mean loss since the last report, bits of held-out."""

    step: int
    seconds: float
    loss: float
    held_out_bits: float


def fit(
    train: Sequence[Example],
    held_out: Sequence[Example],
    fitting: Fitting,
    *,
    checkpoint: Path | None = None,
    report_every: int = 250,
    on_progress: Callable[[Progress], None] | None = None,
) -> UNet:
    """Return the fitted network, its weights averaged over the last steps.

    The same examples, `Fitting` and machine give the same weights. With a checkpoint, a fitting
    that was stopped goes on from it and ends with the same weights.
    """
    torch.manual_seed(fitting.seed)
    torch.set_num_threads(fitting.threads)
    device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
    net = UNet(len(CHANNELS), fitting.widths).to(device, memory_format=torch.channels_last)
    mean = deepcopy(net)
    optimiser = torch.optim.AdamW(net.parameters(), lr=fitting.rate, weight_decay=fitting.decay)
    begun = 0
    if checkpoint is not None and checkpoint.exists():
        state = torch.load(checkpoint, map_location=device)
        net.load_state_dict(state["net"])
        mean.load_state_dict(state["mean"])
        optimiser.load_state_dict(state["optimiser"])
        begun = int(state["step"])
    crops = _Crops(train, fitting)
    clock, losses = time.perf_counter(), []
    for step in range(begun, fitting.steps):
        for group in optimiser.param_groups:
            group["lr"] = fitting.rate_at(step)
        net.train()
        x, occupied, weight, observable = (each.to(device) for each in crops.of_step(step))
        # Half precision halves the time; batch norm and the loss stay in full.
        with torch.autocast(device.type, dtype=torch.bfloat16):
            logits = net(x.contiguous(memory_format=torch.channels_last))
        logits = logits.float()
        loss = (cross_entropy(logits[:, 0], occupied, reduction="none") * weight).sum()
        loss = loss / weight.sum() + _OBSERVABLE_WEIGHT * cross_entropy(logits[:, 1], observable)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        _average(mean, net, min(fitting.averaging, (step + 1) / (step + 10)))
        losses.append(loss.item())
        done = step + 1
        if done % report_every == 0 or done == fitting.steps:
            if checkpoint is not None:
                _keep(checkpoint, net, mean, optimiser, done)
            if on_progress is not None:
                bits = mean_bits(mean, held_out)
                on_progress(
                    Progress(done, time.perf_counter() - clock, float(np.mean(losses)), bits)
                )
            losses.clear()
    return mean.eval()


def logits_of(net: UNet, channels: NDArray[np.floating]) -> NDArray[np.float32]:
    """Return the logits of one grid of any size, shape (2, rows, cols)."""
    rows, cols = channels.shape[1:]
    step = 2 ** (len(net.widths) - 1)
    padded = np.zeros((channels.shape[0], -(-rows // step) * step, -(-cols // step) * step))
    padded[:, :rows, :cols] = channels
    device = next(net.parameters()).device
    with torch.no_grad():
        x = torch.from_numpy(padded.astype(np.float32))[None].to(device)
        out = net(x.contiguous(memory_format=torch.channels_last))
    logits: NDArray[np.float32] = out[0, :, :rows, :cols].cpu().numpy()
    return logits


def mean_bits(net: UNet, examples: Sequence[Example]) -> float:
    """Return the map score, bits a cell, as a mean over examples."""
    net.eval()
    bits = []
    for example in examples:
        scored = example.observable & (example.state != HIDDEN)
        logit = logits_of(net, example.channels)[0][scored]
        occupied = example.state[scored] == OCCUPIED
        p = (1 / (1 + np.exp(-logit.astype(float)))).clip(0.01, 0.99)
        bits.append(float((1 + np.log2(np.where(occupied, p, 1 - p))).mean()))
    return float(np.mean(bits))


class _Crops:
    """Crops of examples around cells that could be seen, the same for the same step."""

    def __init__(self, examples: Sequence[Example], fitting: Fitting) -> None:
        self._examples, self._fitting = examples, fitting
        self._seen = [np.flatnonzero(each.observable) for each in examples]
        # Between one vote a drive and one a cell.
        share = np.sqrt([each.size for each in self._seen])
        self._share = share / share.sum()

    def of_step(self, step: int) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        fitting = self._fitting
        rng = np.random.default_rng([fitting.seed, step])
        side = fitting.crop
        count = fitting.batch
        x = np.zeros((count, len(CHANNELS), side, side), np.float32)
        state = np.full((count, side, side), HIDDEN, np.uint8)
        observable = np.zeros((count, side, side), np.float32)
        for k, number in enumerate(rng.choice(len(self._examples), count, p=self._share)):
            example = self._examples[number]
            rows, cols = example.state.shape
            at = int(rng.choice(self._seen[number]))
            jitter = rng.integers(-side // 3, side // 3, 2)
            top, left = (
                _start(at // cols + jitter[0], rows, side),
                _start(at % cols + jitter[1], cols, side),
            )
            here = (slice(max(top, 0), top + side), slice(max(left, 0), left + side))
            part = example.state[here]
            there = (
                slice(max(-top, 0), max(-top, 0) + part.shape[0]),
                slice(max(-left, 0), max(-left, 0) + part.shape[1]),
            )
            x[k][:, *there] = example.channels[:, *here]
            state[k][there] = part
            observable[k][there] = example.observable[here]
            _turn(rng, x[k], state[k], observable[k])
        known = state != HIDDEN
        weight = np.where(observable > 0, 1.0, _UNSEEN_WEIGHT) * known
        return (
            torch.from_numpy(x),
            torch.from_numpy((state == OCCUPIED).astype(np.float32)),
            torch.from_numpy(weight.astype(np.float32)),
            torch.from_numpy(observable),
        )


def _start(centre: int, size: int, side: int) -> int:
    """Return where a crop around a cell begins: inside, or around all if that is smaller."""
    if size <= side:
        return -((side - size) // 2)
    return int(np.clip(centre - side // 2, 0, size - side))


def _turn(
    rng: np.random.Generator,
    x: NDArray[np.float32],
    state: NDArray[np.uint8],
    observable: NDArray[np.float32],
) -> None:
    """Turn by a quarter and mirror in place, or not; directions change their signs with it."""
    flip_row, flip_col, swap = rng.integers(2, size=3)
    for layers in (x, state, observable):
        turned = layers
        if flip_row:
            turned = turned[..., ::-1, :]
        if flip_col:
            turned = turned[..., ::-1]
        if swap:
            turned = np.swapaxes(turned, -1, -2)
        layers[:] = turned.copy()
    if flip_row != flip_col:
        x[_SIN] *= -1
    if swap:
        x[_COS] *= -1


def _average(mean: UNet, net: UNet, kept: float) -> None:
    with torch.no_grad():
        for ours, theirs in zip(mean.parameters(), net.parameters(), strict=True):
            ours.lerp_(theirs, 1 - kept)
        for ours, theirs in zip(mean.buffers(), net.buffers(), strict=True):
            if ours.is_floating_point():
                ours.lerp_(theirs, 1 - kept)
            else:
                ours.copy_(theirs)


def _keep(path: Path, net: UNet, mean: UNet, optimiser: torch.optim.Optimizer, step: int) -> None:
    state = {
        "net": net.state_dict(),
        "mean": mean.state_dict(),
        "optimiser": optimiser.state_dict(),
        "step": step,
    }
    with atomic_path(path) as beside:
        torch.save(state, beside)
