"""The echoes of a log that tell of its poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.log import SonarLog
from sonarmap.poses.path import CorrectedPath
from sonarmap.poses.walls import Echoes

__all__ = ["UsedEchoes", "used_echoes"]

# Farther echoes come by way of mirrors more often, and mislead more if they do (assumed).
_FARTHEST_M = 4.0
# A robot that stands hears the same again: this way of the wheels between two echoes of a sonar.
_APART_M = 0.05
_LEAST_WEIGHT = 0.02
# More echoes take time and memory, and say little more.
_MOST_ECHOES = 20_000


@dataclass(frozen=True, eq=False)
class UsedEchoes:
    """The echoes that are used: their rows in the log, and what does not depend on poses.

    Parameters
    ----------
    log : SonarLog
        The drive.
    rows : ndarray of int, shape (n,)
        Which of its readings.
    weight : ndarray, shape (n,)
        How much each counts, in [0, 1].
    """

    log: SonarLog
    rows: NDArray[np.intp]
    weight: NDArray[np.float64]

    def some(self, chosen: NDArray[np.intp]) -> UsedEchoes:
        """Return some of them."""
        return UsedEchoes(self.log, self.rows[chosen], self.weight[chosen])

    def seen(self, path: CorrectedPath, parameters: NDArray[np.float64]) -> Echoes:
        """Return the echoes as seen from the poses of some parameters."""
        log, rows = self.log, self.rows
        xy_m, heading_rad = (poses[rows] for poses in path.poses(parameters))
        sonar = log.sonar[rows]
        return Echoes(
            log.ring.sensor_xy_m(sonar, xy_m[:, 0], xy_m[:, 1], heading_rad),
            heading_rad + log.ring.heading_rad[sonar],
            log.range_m[rows],
            self.weight,
            log.ring.half_angle_rad,
        )


def used_echoes(log: SonarLog, path: CorrectedPath) -> UsedEchoes:
    """Choose echoes, and weigh those that repeat others less."""
    heard = log.usable & np.isfinite(log.range_m) & (log.range_m <= _FARTHEST_M)
    rows = np.flatnonzero(heard)
    order = rows[np.lexsort((rows, log.sonar[rows]))]
    apart_m = np.diff(path.way_m[order], prepend=-np.inf)
    apart_m[np.diff(log.sonar[order], prepend=-1) != 0] = np.inf
    weight = np.minimum(apart_m / _APART_M, 1.0)
    kept = np.flatnonzero(weight > _LEAST_WEIGHT)
    kept = kept[np.argsort(order[kept])]
    kept = kept[:: max(1, -(-len(kept) // _MOST_ECHOES))]
    return UsedEchoes(log, order[kept], weight[kept])
