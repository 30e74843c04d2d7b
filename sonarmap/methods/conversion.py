"""From what a method believes to P(occupied): the one place where votes become probabilities.

Votes, masses, memberships and counts are no probabilities, and an unstated conversion decides how
a method ranks. Every method that makes such a thing brings it to *support* s in [-1, 1]: -1 surely
free, 0 nothing known, +1 surely occupied. By default the conversion is affine, "as published"::

    P(occupied) = (1 + s) / 2

With `scale` and `offset` it is a logistic of two numbers instead, which may be fitted on rooms
whose walls are known, and to which cells that nobody saw give the share of walls in such rooms::

    ln(P / (1 - P)) = offset + scale * s

Methods that make log-odds l use the same two numbers with l in place of s; by default they are 1
and 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import finite
from sonarmap.grid import GridSpec
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["LOGISTIC_SPACE", "Convertible", "sigmoid"]

LOGISTIC_SPACE: Space = MappingProxyType({"scale": Real(0.0, 12.0), "offset": Real(-6.0, 3.0)})
"""Where to fit the logistic; no method's own `space` has it, for it belongs to a tuning apart."""


@dataclass(frozen=True, kw_only=True)
class Convertible:
    """What methods have in common that turn their layers into P(occupied).

    Parameters
    ----------
    scale, offset : float, optional
        The logistic's two numbers, see the module. With one of them given the other is 1 or 0.
        By default the conversion is the method's own.
    """

    scale: float | None = None
    offset: float | None = None

    def __post_init__(self) -> None:
        for name in ("scale", "offset"):
            if getattr(self, name) is not None:
                finite(name, getattr(self, name))

    def from_support(
        self,
        grid: GridSpec,
        support: NDArray[np.float64],
        observed: NDArray[np.bool_],
        **limits: float,
    ) -> OccupancyMap:
        """Return the map of support in [-1, 1], which is 0 where nothing is known.

        `limits` are the method's own ``occupied_from`` and ``free_up_to``; with the logistic,
        which knows probabilities, they are the map's usual ones.
        """
        # Sums of many terms may leave the range by a rounding.
        support = support.clip(-1, 1)
        if self._logistic:
            p, limits = sigmoid(self._line(support)), {}
        else:
            p = (1 + support) / 2
        return OccupancyMap.from_probability(
            grid, p.reshape(grid.shape), observed.reshape(grid.shape), **limits
        )

    def from_log_odds(
        self, grid: GridSpec, log_odds: NDArray[np.float64], observed: NDArray[np.bool_]
    ) -> OccupancyMap:
        """Return the map of log-odds, which are 0 where nothing is known."""
        p = sigmoid(self._line(log_odds) if self._logistic else log_odds)
        return OccupancyMap.from_probability(
            grid, p.reshape(grid.shape), observed.reshape(grid.shape)
        )

    @property
    def _logistic(self) -> bool:
        return self.scale is not None or self.offset is not None

    def _line(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        scale = 1.0 if self.scale is None else self.scale
        return (0.0 if self.offset is None else self.offset) + scale * values


def sigmoid(log_odds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the probabilities of log-odds; tanh does not overflow where exp would."""
    p: NDArray[np.float64] = 0.5 * (1 + np.tanh(log_odds / 2))
    return p
