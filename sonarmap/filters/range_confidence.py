"""Range confidence and surface orientation, in the style of Lim and Cho.

Lim and Cho, Specular Reflection Probability in the Certainty Grid Representation, Journal of
Dynamic Systems, Measurement and Control 116(3), 1994, pp. 512-520 (doi 10.1115/1.2899246), weight
the update of a map by two things: a *range confidence factor*, high for short and low for long
readings, and the probability that the surface in a cell is so oriented that it sends an echo back,
which is updated by Bayes' rule. Only the abstract could be had. Ours, then, are the formulas::

    RCF(R)      = 1 - (R / R_max)^power
    ln P(k | c) = const + sum over echoes whose arc holds c, and which orientation k of c faces,
                  of RCF(R) ln(p_seen / p_missed)
    odds(F)     = P(an orientation of c faces the sonar) / P(none), over the same of no evidence
    P(right)    = RCF odds(F) / (RCF odds(F) + 1 - RCF)

An orientation, one of `orientations` directions of a surface's normal, faces a sonar that sees the
cell at no more than the critical angle off it. odds(F) are those of the best placed cell of the
arc, by the other echoes alone: 1 where nobody else saw the surface. And it is a filter of readings
here, not a weight: doubt is 1 - P(right), and a reading is rejected from a doubt on. A no echo has
no range to be confident of, and no opinion is given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, positive, whole, within
from sonarmap.filters.protocol import Filtered
from sonarmap.log import Cause, SonarLog
from sonarmap.mapping import grid_over
from sonarmap.parameters import Real, Space

__all__ = ["RangeConfidenceStyle"]

# No reading is certain by its range alone, or no evidence could ever change it.
_RCF_MIN, _RCF_MAX = 0.02, 0.98


@dataclass(frozen=True)
class RangeConfidenceStyle:
    """Doubts long readings, and those that nobody else confirms; see the module for the formulas.

    Parameters
    ----------
    power : float
        Of the range confidence factor, > 0.
    critical_rad : float
        Largest angle off a surface's normal from which it is seen, radians, in (0, pi/2).
    p_seen, p_missed : float
        Probability of an echo from within, and from beyond, the critical angle;
        0 < p_missed < p_seen < 1.
    orientations : int
        Directions that a normal may have, >= 4.
    cell_m : float
        Side of a cell of the grid of orientations, metres, > 0; an arc is one cell thick.
    reject_from : float
        Doubt from which a reading is rejected, in [0, 1].
    """

    name: ClassVar[str] = "range-confidence-style"
    source: ClassVar[str] = (
        "After the abstract of Lim and Cho, Specular Reflection Probability in the Certainty Grid "
        "Representation, J. Dyn. Sys. Meas. Control 116(3), 1994; formulas and numbers ours."
    )

    power: float = 2.0
    critical_rad: float = math.radians(25)
    p_seen: float = 0.7
    p_missed: float = 0.3
    orientations: int = 16
    cell_m: float = 0.1
    reject_from: float = 0.9

    def __post_init__(self) -> None:
        positive("power", self.power)
        if not 0 < self.critical_rad < math.pi / 2:
            raise InputError(f"critical_rad must be in (0, pi/2), got {self.critical_rad!r}")
        if not 0 < self.p_missed < self.p_seen < 1:
            raise InputError(
                "p_missed and p_seen must be 0 < p_missed < p_seen < 1, got "
                f"{self.p_missed!r} and {self.p_seen!r}"
            )
        whole_number = whole("orientations", self.orientations, least=4)
        object.__setattr__(self, "orientations", whole_number)
        positive("cell_m", self.cell_m)
        within("reject_from", self.reject_from, 0, 1)

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log with doubts, and with what is doubted too much rejected."""
        judged = log.usable & (log.range_m >= 0) & (log.range_m <= log.ring.range_max_m)
        doubt, cause = log.doubt.copy(), np.full(len(log), -1)
        doubt[judged] = self._doubts(log.select(judged))
        rejected = judged & (doubt >= self.reject_from)
        # What a long range that nobody confirms is most often.
        cause[rejected] = Cause.BOUNCE
        after = log.replace(doubt=doubt, rejected=log.rejected | rejected)
        return Filtered(after, np.zeros(len(log), bool), None, cause)

    def _doubts(self, log: SonarLog) -> NDArray[np.float64]:
        """Return the doubts of readings that all have an echo."""
        if not len(log):
            return np.empty(0)
        from sonarmap.kernels.listed_cones import ListedCones  # numba
        from sonarmap.kernels.orientation import facing_odds, orientation_votes

        rcf = 1 - (log.range_m / log.ring.range_max_m) ** self.power
        rcf = rcf.clip(_RCF_MIN, _RCF_MAX)
        weight = rcf * math.log(self.p_seen / self.p_missed)
        # The margin holds the ends of the longest arc.
        margin_m = 2 * log.ring.range_max_m * math.sin(log.ring.half_angle_rad / 2) + self.cell_m
        grid = grid_over(log, resolution_m=self.cell_m, margin_m=margin_m)
        places = (log.sensor_xy_m, log.axis_rad, log.ring.half_angle_rad)
        cones = ListedCones.on(grid, *places, log.range_m + self.cell_m / 2)
        on_arc = cones.range_m >= np.repeat(log.range_m - self.cell_m / 2, np.diff(cones.first))
        first = np.concatenate([[0], np.cumsum(on_arc)])[cones.first]
        rows, cols = np.divmod(np.arange(grid.rows * grid.cols), grid.cols)
        seen = (first, cones.cell[on_arc], *grid.centre_of(rows, cols), places[0], weight)
        evidence = np.zeros((rows.size, self.orientations))
        orientation_votes(evidence, *seen, self.critical_rad)
        right = rcf * facing_odds(evidence, *seen, self.critical_rad)
        doubts: NDArray[np.float64] = (1 - rcf) / (right + 1 - rcf)
        return doubts

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched; ``p_missed`` is 1 - `p_seen` there."""
        return {
            "power": Real(0.5, 8.0, log=True),
            "critical_rad": Real(math.radians(12), math.radians(60)),
            "p_seen": Real(0.51, 0.95),
            "reject_from": Real(0.3, 1.0),
        }

    @classmethod
    def at(cls, point: Mapping[str, float]) -> RangeConfidenceStyle:
        """Return the filter that a point of `space` stands for."""
        others: dict[str, Any] = dict(point)
        if "p_seen" in others:
            others["p_missed"] = 1 - others["p_seen"]
        return cls(**others)
