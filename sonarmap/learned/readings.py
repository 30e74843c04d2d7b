"""What a learned map says of each reading: features, and the small network that judges by them.

Rays fan out over the cone of each reading through the map. Survival along a ray is the probability
that nothing stands nearer on it; a reading far beyond where survival falls came by a detour, and
one where survival is still high has the map against it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.log import Cause, SonarLog
from sonarmap.occupancy import OccupancyMap

__all__ = [
    "CANDIDATES",
    "FEATURES",
    "Judgement",
    "candidates_of",
    "features_of",
    "judge",
    "judged_by",
]

# Bearings / half-angle of the rays: symmetrical, so that a mirrored log is judged alike.
_SHARES = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9)
_AXIS, _INNER = 3, slice(2, 5)
_STEP_M = 0.025
_OFFSETS_M = (-0.6, -0.3, -0.15, -0.07, 0.07, 0.15, 0.3)
_LEVELS = (0.85, 0.7, 0.5, 0.3, 0.15)
# What is so near to a reading is at it: the width of a wall and of the doubt about its place.
_ABOUT_M = 0.12
# Scales at which differences of ranges are squeezed, metres.
_FINE_M, _COARSE_M = 0.1, 0.6
_FAR_M, _WIDE_RAD = 5.0, 0.3
_CAUSES = len(Cause)

CANDIDATES = (
    *(f"cone_{level:g}" for level in _LEVELS),
    *(f"inner_{level:g}" for level in _LEVELS),
    *(f"axis_{level:g}" for level in _LEVELS),
    "no_echo",
)
"""What a reading may have had to be: where survival falls below a level, on the nearest of all
rays, of the inner ones, and on the axis; or no echo."""

FEATURES = (
    *(
        f"{rays}_survival_{offset:+g}"
        for rays in ("axis", "inner", "least", "mean")
        for offset in _OFFSETS_M
    ),
    *(f"{scale}_{name}" for scale in ("fine", "coarse") for name in CANDIDATES),
    *(
        f"{rays}_peak_{where}"
        for where in ("before", "at")
        for rays in ("axis", "inner", "least", "largest")
    ),
    "mean_way_axis",
    "mean_way_least",
    "range",
    "no_echo",
    "range_max",
    "half_angle",
    *(f"{scale}_{which}" for scale in ("fine", "coarse") for which in ("before", "after")),
    "beyond_before",
    "beyond_after",
    "nearest_candidate",
)
"""The features in their order."""


@dataclass(frozen=True, eq=False)
class Judgement:
    """What the network says of n readings.

    Parameters
    ----------
    causes : ndarray, shape (n, 6)
        Probability of each `Cause`.
    predicted_m : ndarray, shape (n,)
        What the sonar should have read; +inf for no echo.
    confidence : ndarray, shape (n,)
        Probability that the prediction is within 10 cm of the truth.
    """

    causes: NDArray[np.float64]
    predicted_m: NDArray[np.float64]
    confidence: NDArray[np.float64]

    @property
    def doubt(self) -> NDArray[np.float64]:
        """Probability that a reading is wrong."""
        wrong: NDArray[np.float64] = self.causes[:, Cause.BOUNCE :].sum(axis=1).clip(0, 1)
        return wrong


def features_of(log: SonarLog, m: OccupancyMap) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """Return the features of each reading, shape (n, len(FEATURES)), and the `candidates_of` it."""
    from sonarmap.kernels.along import walk

    ring, grid = log.ring, m.grid
    farthest = ring.range_max_m
    echo = log.range_m <= farthest
    reading_m = np.where(echo, log.range_m, farthest)
    survival, falls_m, mean_m, peak = walk(
        np.ascontiguousarray(m.probability),
        (*grid.origin_xy_m, grid.resolution_m),
        log.sensor_xy_m,
        log.axis_rad,
        np.array(_SHARES) * ring.half_angle_rad,
        reading_m,
        farthest,
        _STEP_M,
        np.array(_OFFSETS_M),
        np.array(_LEVELS),
        _ABOUT_M,
    )
    candidate_m = candidates_of(falls_m, farthest)
    off_m = candidate_m - reading_m[:, None]
    before_m, after_m = _neighbours(log, reading_m)
    beyond_m = reading_m - candidate_m[:, _LEVELS.index(0.5)]
    beyond_before, beyond_after = _neighbours(log, beyond_m)
    columns = [
        survival[:, _AXIS],
        survival[:, _INNER].min(axis=1),
        survival.min(axis=1),
        survival.mean(axis=1),
        np.tanh(off_m / _FINE_M),
        np.tanh(off_m / _COARSE_M),
        *_over_rays(peak[:, :, 0]),
        *_over_rays(peak[:, :, 1]),
        np.tanh((mean_m[:, _AXIS] - reading_m) / _COARSE_M),
        np.tanh((mean_m.min(axis=1) - reading_m) / _COARSE_M),
        reading_m / _FAR_M,
        ~echo,
        np.full(len(log), farthest / _FAR_M),
        np.full(len(log), ring.half_angle_rad / _WIDE_RAD),
        *(
            np.tanh((other_m - reading_m) / scale_m)
            for scale_m in (_FINE_M, _COARSE_M)
            for other_m in (before_m, after_m)
        ),
        np.tanh(beyond_before / _COARSE_M),
        np.tanh(beyond_after / _COARSE_M),
        np.tanh(np.abs(off_m[:, :-1]).min(axis=1) / _FINE_M),
    ]
    return np.column_stack(columns).astype(np.float32), candidate_m


def candidates_of(falls_m: NDArray[np.float64], farthest_m: float) -> NDArray[np.float64]:
    """Return the candidates of each reading, metres, shape (n, len(CANDIDATES))."""
    return np.column_stack(
        [
            falls_m.min(axis=1),
            falls_m[:, _INNER].min(axis=1),
            falls_m[:, _AXIS],
            np.full(len(falls_m), farthest_m),
        ]
    )


def judge(network: Mapping[str, NDArray[np.float32]], log: SonarLog, m: OccupancyMap) -> Judgement:
    """Return what the small network says of each reading, by a map of the log.

    Parameters
    ----------
    network : mapping
        ``mean``, ``scale`` of the features; ``kernel0``, ``bias0``, ... of its layers.
    log : SonarLog
        Readings that are neither stale, rejected nor too close.
    m : OccupancyMap
        The learned map.
    """
    features, candidate_m = features_of(log, m)
    causes, right = judged_by(network, features)
    best = right.argmax(axis=1)
    rows = np.arange(len(log))
    predicted_m = candidate_m[rows, best]
    predicted_m = np.where(predicted_m >= log.ring.range_max_m, math.inf, predicted_m)
    return Judgement(causes, predicted_m, right[rows, best])


def _over_rays(values: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the value on the axis, the least of the inner rays, of all, and the largest."""
    return [
        values[:, _AXIS],
        values[:, _INNER].min(axis=1),
        values.min(axis=1),
        values.max(axis=1),
    ]


def judged_by(
    network: Mapping[str, NDArray[np.float32]], features: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the probability of each `Cause`, and that each candidate is within 10 cm of truth."""
    x = (features - network["mean"]) * network["scale"]
    last = sum(name.startswith("kernel") for name in network) - 1
    for number in range(last + 1):
        x = x @ network[f"kernel{number}"] + network[f"bias{number}"]
        if number < last:
            x = np.maximum(x, 0)
    logit = x.astype(float)
    causes = np.exp(logit[:, :_CAUSES] - logit[:, :_CAUSES].max(axis=1, keepdims=True))
    causes /= causes.sum(axis=1, keepdims=True)
    return causes, 0.5 * (1 + np.tanh(logit[:, _CAUSES:] / 2))


def _neighbours(
    log: SonarLog, values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the value of the same sonar's reading before and after; one's own at the ends."""
    before, after = values.copy(), values.copy()
    order = np.argsort(log.sonar, kind="stable")
    same = np.flatnonzero(np.diff(log.sonar[order]) == 0)
    before[order[same + 1]] = values[order[same]]
    after[order[same]] = values[order[same + 1]]
    return before, after
