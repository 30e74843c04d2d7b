"""Fits the few numbers beside the network: calibrations, thresholds, the share of unseen walls."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from mapper_training.examples import CELL_M, Example
from sonarmap.learned.mapping import cells_of, logits_on
from sonarmap.learned.weights import Calibration, Weights
from worlds import HIDDEN, OCCUPIED

__all__ = ["Drive", "MapFigures", "calibrated", "fit_two_numbers", "map_figures", "with_thresholds"]

RATIOS = (0.5, 1.0, 2.0)
"""Cells of 2.5, 5 and 10 cm."""
_THRESHOLDS = np.round(np.arange(0.10, 0.61, 0.02), 2)
# Of the wall cells that could be seen, so many may be called free. Assumed.
_WALLS_CALLED_FREE = 0.2


@dataclass(frozen=True, eq=False)
class Drive:
    """A log and the room that it is of."""

    log: sm.SonarLog
    world: worlds.World


@dataclass(frozen=True)
class MapFigures:
    """How good maps are: means over drives, and pooled."""

    drives: int
    bits: float
    skill_pooled: float
    skill_mean: float
    skill_worst: float
    f1_10_cm: float
    calibration_error: float


def calibrated(weights: Weights, drives: Sequence[Drive], examples: Iterable[Example]) -> Weights:
    """Return the weights with calibrations fitted on held-out drives, and the share of walls.

    Parameters
    ----------
    weights : Weights
        Without calibration.
    drives : sequence of Drive
        In rooms that the network was not fitted to.
    examples : iterable of Example
        Where cells that nothing looked at are counted.
    """
    fitted = {}
    for ratio in RATIOS:
        parts = [_scored(weights, drive, ratio * CELL_M) for drive in drives]
        logit, occupied = (np.concatenate(each) for each in zip(*parts, strict=True))
        fitted[ratio] = fit_two_numbers(logit, occupied)
    unseen = walls = 0
    for example in examples:
        dark = ~example.observable & (example.state != HIDDEN)
        unseen += int(dark.sum())
        walls += int((example.state[dark] == OCCUPIED).sum())
    share = walls / unseen if walls else weights.share
    return replace(weights, calibrations=fitted, share=share)


def fit_two_numbers(logit: NDArray[np.floating], occupied: NDArray[np.bool_]) -> Calibration:
    """Return the scale and offset of least log loss, by Newton's method."""
    x = np.column_stack([logit.astype(float), np.ones(logit.size)])
    beta = np.array([1.0, 0.0])
    for _ in range(50):
        p = 0.5 * (1 + np.tanh(x @ beta / 2))
        curvature = (x * (p * (1 - p))[:, None]).T @ x + 1e-9 * np.eye(2)
        step = np.linalg.solve(curvature, x.T @ (occupied - p))
        beta = beta + step
        if np.abs(step).max() < 1e-10:
            break
    return Calibration(float(beta[0]), float(beta[1]))


def with_thresholds(weights: Weights, drives: Sequence[Drive]) -> Weights:
    """Return the weights with the thresholds of pictures, chosen on drives in training rooms.

    A cell counts as occupied from where F1 within 10 cm, pooled, is best, and as free up to where
    a fifth of the walls would be called so, but not higher.
    """
    scores: dict[float, sm.MapScore] = {}
    walls = []
    for drive in drives:
        truth, observable, p = _map_of(weights, drive, CELL_M)
        walls.append(p[observable & (truth.state == OCCUPIED)])
        for threshold in _THRESHOLDS:
            m = sm.OccupancyMap.from_probability(
                truth.grid, p, occupied_from=float(threshold), free_up_to=0.0
            )
            score = sm.score_map(m, truth, observable=observable)
            scores[threshold] = scores[threshold] + score if threshold in scores else score
    best = max(scores, key=lambda threshold: scores[threshold].f1(1))
    free = min(float(np.quantile(np.concatenate(walls), _WALLS_CALLED_FREE)), 0.9 * float(best))
    return replace(weights, occupied_from=float(best), free_up_to=round(free, 3))


def map_figures(weights: Weights, drives: Sequence[Drive]) -> MapFigures:
    """Return how good the maps of drives are."""
    scores = []
    for drive in drives:
        truth, observable, p = _map_of(weights, drive, CELL_M)
        m = sm.OccupancyMap.from_probability(
            truth.grid, p, occupied_from=weights.occupied_from, free_up_to=weights.free_up_to
        )
        scores.append(sm.score_map(m, truth, observable=observable))
    pooled = scores[0]
    for score in scores[1:]:
        pooled = pooled + score
    skills = [score.skill for score in scores if not math.isnan(score.skill)]
    return MapFigures(
        len(scores),
        float(np.mean([score.map_score for score in scores])),
        pooled.skill,
        float(np.mean(skills)),
        float(np.min(skills)),
        pooled.f1(1),
        pooled.calibration_error,
    )


def _map_of(
    weights: Weights, drive: Drive, resolution_m: float
) -> tuple[worlds.TruthGrid, NDArray[np.bool_], NDArray[np.float64]]:
    truth = worlds.truth(drive.world, resolution_m=resolution_m)
    cells = cells_of(weights, logits_on(weights, drive.log, truth.grid), truth.grid)
    return truth, truth.observable(drive.log), cells.probability


def _scored(
    weights: Weights, drive: Drive, resolution_m: float
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    truth = worlds.truth(drive.world, resolution_m=resolution_m)
    scored = truth.observable(drive.log)
    logit = logits_on(weights, drive.log, truth.grid)[0]
    return logit[scored], truth.state[scored] == OCCUPIED
