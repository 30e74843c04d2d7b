"""How the truth compares two sensor models with the same parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

import sonarmap as sm
import worlds
from sonarbed.reporting.drives import DriveSpec, DriveStore
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarmap.scores.probabilities import CLAMP

__all__ = [
    "NEAR_WALL_M",
    "PAIRS",
    "PARTS",
    "SCORES",
    "ModelPair",
    "Score",
    "ScoredMap",
    "ScoredPairs",
    "differences",
    "mean",
    "score_drive",
]

# Free cells this near to a wall, P3 and the width of a cell, are what a thick arc reaches.
NEAR_WALL_M = 0.15
# The parts of the Map Score in `ScoredMap`.
PARTS = {
    "bits_wall": "wall cells",
    "bits_near": f"free cells within {NEAR_WALL_M:g} m of a wall",
    "bits_open": "other free cells",
}


@dataclass(frozen=True)
class ModelPair:
    """The two models with the same parameters."""

    tolerance_m: float
    standard: sm.StandardModel
    parameterized: sm.ParameterizedModel

    @classmethod
    def of(cls, tolerance_m: float) -> ModelPair:
        """Return the parameters of figure 5.8 with another tolerance (P3)."""
        return cls(
            tolerance_m,
            replace(sm.StandardModel.thesis(), tolerance_m=tolerance_m),
            replace(sm.ParameterizedModel.thesis(), p3_m=tolerance_m),
        )


# Figure 5.8's own tolerance, and the smallest of the thesis's search (2 P3 = 0.5 units).
PAIRS = (ModelPair.of(sm.StandardModel.thesis().tolerance_m), ModelPair.of(0.025))


@dataclass(frozen=True, slots=True)
class Score:
    """A score of maps: its name in `ScoredMap`, what people call it, and whether more is better."""

    name: str
    title: str
    unit: str
    better: int


SCORES = (
    Score("skill", "skill", "", 1),
    Score("map_score", "Map Score", "bit", 1),
    Score("brier", "Brier score", "", -1),
    Score("correlation", "correlation", "", 1),
    Score("f1", "F1 at 10 cm", "", 1),
)


@dataclass(frozen=True, slots=True)
class ScoredMap:
    """What the truth says of a map, over observable cells.

    Parameters
    ----------
    skill, map_score, brier, correlation, f1 : float
        As `sonarmap.MapScore` has them, F1 at 10 cm.
    sheet : float
        Map Score of the blank sheet, which knows only the room's share of walls.
    phantom_m2, false_free_m2 : float
        Free area mapped as occupied, occupied area mapped as free.
    bits_wall, bits_near, bits_open : float
        Parts of the Map Score, bits per scored cell, that add up to it: of occupied cells, of
        free cells within 0.15 m of a wall, and of the other free cells.
    """

    skill: float
    map_score: float
    brier: float
    correlation: float
    f1: float
    sheet: float
    phantom_m2: float
    false_free_m2: float
    bits_wall: float
    bits_near: float
    bits_open: float

    @classmethod
    def of(
        cls, built: sm.OccupancyMap, truth: worlds.TruthGrid, observable: NDArray[np.bool_]
    ) -> ScoredMap:
        """Return what the truth says of a map."""
        score = sm.score_map(built, truth, observable=observable)
        wall = truth.state == worlds.OCCUPIED
        away_m = distance_transform_edt(~wall) * truth.grid.resolution_m
        p = built.probability.clip(CLAMP, 1 - CLAMP)
        bits = np.where(observable, 1 + np.log2(np.where(wall, p, 1 - p)), 0)
        near = ~wall & (away_m <= NEAR_WALL_M + 1e-9)
        parts = (float(bits[cells].sum()) / score.cells for cells in (wall, near, ~wall & ~near))
        return cls(
            score.skill,
            score.map_score,
            score.brier,
            score.correlation,
            score.f1(1),
            1 - score.sheet_loss_bits,
            score.phantom_m2,
            score.false_free_m2,
            *parts,
        )


# Seed by seed, pair by pair: the standard and the parameterized model's map.
ScoredPairs = Sequence[Sequence[tuple[ScoredMap, ScoredMap]]]


def score_drive(task: tuple[DriveStore, DriveSpec]) -> list[tuple[ScoredMap, ScoredMap]]:
    """Return what the truth says of both models' maps of a drive, pair by pair."""
    store, spec = task
    drive = store.scorable(spec)

    def scored(model: sm.SensorModel) -> ScoredMap:
        built = sm.build_map(drive.log, model, drive.truth.grid)
        return ScoredMap.of(built, drive.truth, drive.observable)

    return [(scored(pair.standard), scored(pair.parameterized)) for pair in PAIRS]


def differences(scored: ScoredPairs, pair: int, name: str) -> Estimate:
    """Return parameterized less standard of a score, paired by seed."""
    return mean_of(
        [getattr(drive[pair][1], name) - getattr(drive[pair][0], name) for drive in scored]
    )


def mean(scored: ScoredPairs, pair: int, model: int, name: str) -> Estimate:
    """Return the mean of a score over the seeds; model 0 is the standard one."""
    return mean_of([getattr(drive[pair][model], name) for drive in scored])
