"""Fits the small network that judges readings by the learned map of their log."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.stats import rankdata
from torch import Tensor, nn
from torch.nn.functional import binary_cross_entropy_with_logits, cross_entropy

import sonarmap as sm
from sonarmap.learned.readings import CANDIDATES, FEATURES, features_of, judged_by
from sonarmap.methods.learned import Learned

__all__ = ["LOST_SHARES", "Judged", "fit_judge", "judged", "reading_figures"]

NEAR_M = 0.1
_CAUSES = len(sm.Cause)
_LOST = (0.0003, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
LOST_SHARES = np.array(_LOST, np.float32)
"""Shares of right readings lost at which thresholds of doubt are kept."""


@dataclass(frozen=True, eq=False)
class Judged:
    """Readings of logs: their features, what was true, and the room each is of.

    Parameters
    ----------
    features : ndarray of float32, shape (n, features)
        See `sonarmap.learned.readings`.
    cause : ndarray of int, shape (n,)
        A `Cause` each.
    near : ndarray of bool, shape (n, candidates)
        Which candidates are within 10 cm of a truth.
    """

    features: NDArray[np.float32]
    cause: NDArray[np.int64]
    near: NDArray[np.bool_]

    @classmethod
    def joined(cls, parts: list[Judged]) -> Judged:
        """Return all readings as one."""
        return cls(
            *(
                np.concatenate([getattr(part, name) for part in parts])
                for name in ("features", "cause", "near")
            )
        )


def judged(method: Learned, log: sm.SonarLog) -> Judged:
    """Return the readings of a log that a filter would judge, with their truth."""
    log = log.select(log.usable & (log.range_m >= 0))
    truth = log.require_truth("training")
    grid = sm.grid_over(log)
    features, candidate_m = features_of(log, method.map(log, grid))
    low, high = log.ring.range_min_m, log.ring.range_max_m
    true_m = np.column_stack([truth.cone_range_m, truth.axis_range_m]).clip(low, high)
    near = np.abs(candidate_m.clip(low, high)[:, :, None] - true_m[:, None]).min(axis=2) <= NEAR_M
    return Judged(features, truth.cause.astype(np.int64), near)


def fit_judge(
    train: Judged, threshold_from: Judged, *, seed: int, epochs: int = 12, width: int = 48
) -> dict[str, NDArray[np.float32]]:
    """Return the arrays of `sonarmap.learned.readings.judge`, thresholds by share lost included."""
    torch.manual_seed(seed)
    mean = train.features.mean(axis=0)
    scale = 1 / (train.features.std(axis=0) + 0.05)
    net = nn.Sequential(
        nn.Linear(len(FEATURES), width),
        nn.ReLU(),
        nn.Linear(width, width),
        nn.ReLU(),
        nn.Linear(width, _CAUSES + len(CANDIDATES)),
    )
    x = torch.from_numpy((train.features - mean) * scale)
    cause, near = torch.from_numpy(train.cause), torch.from_numpy(train.near.astype(np.float32))
    batch = 1024
    steps = epochs * (len(x) // batch)
    optimiser = torch.optim.AdamW(net.parameters(), lr=3e-3, weight_decay=1e-3)
    falling = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, max(steps, 1))
    rng = np.random.default_rng([seed, 5])
    for _ in range(epochs):
        order = torch.from_numpy(rng.permutation(len(x)))
        for first in range(0, len(x) - batch + 1, batch):
            rows = order[first : first + batch]
            loss = _loss(net(x[rows]), cause[rows], near[rows])
            optimiser.zero_grad()
            loss.backward()
            optimiser.step()
            falling.step()
    arrays = {"mean": mean, "scale": scale.astype(np.float32)}
    for number, layer in enumerate(each for each in net if isinstance(each, nn.Linear)):
        arrays[f"kernel{number}"] = layer.weight.detach().numpy().T.copy()
        arrays[f"bias{number}"] = layer.bias.detach().numpy().copy()
    causes, _ = judged_by(arrays, threshold_from.features)
    doubt = causes[:, sm.Cause.BOUNCE :].sum(axis=1)
    right = doubt[threshold_from.cause <= sm.Cause.OUT_OF_RANGE]
    arrays["lost_share"] = LOST_SHARES
    arrays["threshold"] = np.quantile(right, 1 - LOST_SHARES).astype(np.float32)
    return arrays


def reading_figures(judge: dict[str, NDArray[np.float32]], held: Judged) -> dict[str, float]:
    """Return how well a judge does: ``roc_auc``, ``caught`` and ``mended``, see the card."""
    causes, right = judged_by(judge, held.features)
    doubt = causes[:, sm.Cause.BOUNCE :].sum(axis=1)
    wrong = held.cause > sm.Cause.OUT_OF_RANGE
    ranks = rankdata(doubt)
    below = wrong.sum() * (wrong.sum() + 1) / 2
    threshold = np.quantile(doubt[~wrong], 0.99)
    caught = wrong & (doubt > threshold)
    near = held.near[np.arange(len(held.cause)), right.argmax(axis=1)]
    return {
        "roc_auc": float((ranks[wrong].sum() - below) / (wrong.sum() * (~wrong).sum())),
        "caught": float(caught.sum() / wrong.sum()),
        "mended": float(near[caught].mean()),
    }


def _loss(out: Tensor, cause: Tensor, near: Tensor) -> Tensor:
    causes = cross_entropy(out[:, :_CAUSES], cause)
    return causes + binary_cross_entropy_with_logits(out[:, _CAUSES:], near)
