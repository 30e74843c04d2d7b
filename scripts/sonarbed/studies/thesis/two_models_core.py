"""How the truth compares two sensor models with the same parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import sonarmap as sm
import worlds
from sonarbed.reporting.drives import usual_drive
from sonarbed.reporting.setting import Setting
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarmap.methods.bayes.models import probability
from sonarmap.scores.maps import CLAMP

__all__ = [
    "NEAR_WALL_M",
    "PAIRS",
    "PARTS",
    "SCORES",
    "Judged",
    "Judgements",
    "Pair",
    "Score",
    "contradictions",
    "differences",
    "judge",
    "judge_drive",
    "mean",
]

# Free cells this near to a wall, P3 and the width of a cell, are what a thick arc reaches.
NEAR_WALL_M = 0.15
# The parts of the Map Score in `Judged`.
PARTS = {
    "bits_wall": "wall cells",
    "bits_near": f"free cells within {NEAR_WALL_M:g} m of a wall",
    "bits_open": "other free cells",
}


@dataclass(frozen=True)
class Pair:
    """The two models with the same parameters."""

    tolerance_m: float
    standard: sm.StandardModel
    parameterized: sm.ParameterizedModel

    @classmethod
    def of(cls, tolerance_m: float) -> Pair:
        """Return the setting of figure 5.8 with another tolerance (P3)."""
        return cls(
            tolerance_m,
            replace(sm.StandardModel.thesis(), tolerance_m=tolerance_m),
            replace(sm.ParameterizedModel.thesis(), p3_m=tolerance_m),
        )


# Figure 5.8's own tolerance, and the smallest of the thesis's search (2 P3 = 0.5 units).
PAIRS = (Pair.of(sm.StandardModel.thesis().tolerance_m), Pair.of(0.025))


@dataclass(frozen=True, slots=True)
class Score:
    """A score of maps: its name in `Judged`, what people call it, and whether more is better."""

    name: str
    title: str
    unit: str
    better: int


SCORES = (
    Score("map_score", "Map Score", "bit", 1),
    Score("brier", "Brier score", "", -1),
    Score("correlation", "correlation", "", 1),
    Score("f1", "F1 at 10 cm", "", 1),
)


@dataclass(frozen=True, slots=True)
class Judged:
    """What the truth says of a map, over observable cells.

    Parameters
    ----------
    map_score, brier, correlation, f1 : float
        As `sonarmap.MapScore` has them, F1 at 10 cm.
    phantom_m2, false_free_m2 : float
        Free area mapped as occupied, occupied area mapped as free.
    bits_wall, bits_near, bits_open : float
        Parts of the Map Score, bits per scored cell, that add up to it: of occupied cells, of
        free cells within 0.15 m of a wall, and of the other free cells.
    """

    map_score: float
    brier: float
    correlation: float
    f1: float
    phantom_m2: float
    false_free_m2: float
    bits_wall: float
    bits_near: float
    bits_open: float


# Seed by seed, pair by pair: the standard and the parameterised model's map.
Judgements = Sequence[Sequence[tuple[Judged, Judged]]]


def judge(m: sm.OccupancyMap, truth: worlds.TruthGrid, observable: NDArray[np.bool_]) -> Judged:
    """Return what the truth says of a map."""
    score = sm.score_map(m, truth, observable=observable)
    wall = truth.state == worlds.OCCUPIED
    away_m = distance_transform_edt(~wall) * truth.grid.resolution_m
    p = m.probability.clip(CLAMP, 1 - CLAMP)
    bits = np.where(observable, 1 + np.log2(np.where(wall, p, 1 - p)), 0)
    near = ~wall & (away_m <= NEAR_WALL_M + 1e-9)
    parts = (float(bits[cells].sum()) / score.cells for cells in (wall, near, ~wall & ~near))
    return Judged(
        score.map_score,
        score.brier,
        score.correlation,
        score.f1(1),
        score.phantom_m2,
        score.false_free_m2,
        *parts,
    )


def judge_drive(task: tuple[Setting, str, int]) -> list[tuple[Judged, Judged]]:
    """Return what the truth says of both models' maps of a room's drive, pair by pair."""
    log, truth, observable = usual_drive(*task)
    return [
        (
            judge(sm.build_map(log, pair.standard, truth.grid), truth, observable),
            judge(sm.build_map(log, pair.parameterized, truth.grid), truth, observable),
        )
        for pair in PAIRS
    ]


def differences(judged: Judgements, pair: int, name: str) -> Estimate:
    """Return parameterised less standard of a score, paired by seed."""
    return mean_of(
        [getattr(drive[pair][1], name) - getattr(drive[pair][0], name) for drive in judged]
    )


def mean(judged: Judgements, pair: int, model: int, name: str) -> Estimate:
    """Return the mean of a score over the seeds; model 0 is the standard one."""
    return mean_of([getattr(drive[pair][model], name) for drive in judged])


def contradictions(
    model: sm.SensorModel, reading_m: float, tolerance_m: float
) -> tuple[float, float]:
    """Return the share of a cone's area before its hill above 0.5, and of the hill below 0.5."""
    range_m, bearing = np.meshgrid(
        np.linspace(0.0005, reading_m + tolerance_m, 801),
        np.linspace(-model.half_angle_rad, model.half_angle_rad, 401),
    )
    p = probability(model, range_m, bearing, reading_m)
    hill = range_m >= reading_m - tolerance_m
    # A ring of the cone has an area that grows with its range.
    before = float((range_m * (p > 0.5 + 1e-9))[~hill].sum() / range_m[~hill].sum())
    return before, float((range_m * (p < 0.5 - 1e-9))[hill].sum() / range_m[hill].sum())
