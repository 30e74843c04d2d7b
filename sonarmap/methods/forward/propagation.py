"""A forward model whose cells are inferred by belief propagation.

Dhiman, Kundu, Dellaert, Corso, Modern MAP Inference Methods for Accurate and Fast Occupancy Grid
Mapping on Higher Order Factor Graphs, ICRA 2014, do so for the rays of a laser: cells are the
variables, each reading is a factor over the cells it touches, and the sum-product algorithm gives
the marginals. Here the factor is the cone of `sonarmap.methods.forward.model`. With l0 the prior,
and P(c) without factor i (its cavity) as the belief in all other messages::

    message i -> c   = v(i) ln( E f_i(m with c occupied) / E f_i(m with c free) )
    ln(P / (1 - P))  = l0 + sum of messages to c

where E is over the other cells of the cone at their cavities: since a factor is linear in each
cell, that is its value at their probabilities, and one round costs no more than a visit of each
cell of each cone. Rounds go on from silent messages, old ones and new ones mixed (damping), until
none changes much. The graph has loops, so the marginals are not exact; damping, the vote v(i) as a
factor of the message, and all numbers are ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.errors import InputError, non_negative, whole
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.forward.model import ForwardModel
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["ForwardBp"]

_LOG_ODDS_MAX = 700.0


@dataclass(frozen=True, kw_only=True)
class ForwardBp(ForwardModel):
    """Marginals of a forward model by loopy belief propagation.

    Parameters
    ----------
    rounds : int
        Rounds of messages at most, >= 1.
    damping : float
        Share of the old message in the new one, in [0, 1).
    tolerance : float
        Rounds end when no message changes by more, >= 0.
    prior, p_hit, edge, p_random, p_no_echo, sigma_m, max_range_m, repeat_travel_m, repeat_turn_rad
        See `ForwardModel`.
    """

    name: ClassVar[str] = "forward-bp"
    source: ClassVar[str] = (
        "Dhiman, Kundu, Dellaert and Corso, Modern MAP Inference Methods for Accurate and Fast "
        "Occupancy Grid Mapping on Higher Order Factor Graphs, ICRA 2014, for cones; numbers ours."
    )

    rounds: int = 20
    damping: float = 0.5
    tolerance: float = 0.01

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "rounds", whole("rounds", self.rounds, least=1))
        if not 0 <= self.damping < 1:
            raise InputError(f"damping must be in [0, 1), got {self.damping!r}")
        non_negative("tolerance", self.tolerance)

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid; observed is what any cone touched."""
        from sonarmap.kernels.forward import propagate  # numba

        f = self.factors(log, grid)
        belief = np.full(grid.rows * grid.cols, self.prior_log_odds)
        message = np.zeros(f.cell.size, np.float32)
        sensed = (f.first, f.cell, f.zone, f.answers, f.floor, f.scale, f.density, f.beyond, f.vote)
        for _ in range(self.rounds):
            added = np.full(belief.size, self.prior_log_odds)
            change = propagate(belief, message, *sensed, self.damping, added)
            belief = added
            if change <= self.tolerance:
                break
        p = 1 / (1 + np.exp(-belief.clip(-_LOG_ODDS_MAX, _LOG_ODDS_MAX)))
        observed = np.zeros(belief.size, bool)
        observed[f.cell] = True
        return OccupancyMap.from_probability(
            grid, p.reshape(grid.shape), observed.reshape(grid.shape)
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched."""
        return {
            "prior": Real(0.01, 0.5, log=True),
            "p_hit": Real(0.02, 0.98),
            "edge": Real(0.0, 1.0),
            "p_random": Real(0.01, 0.9),
            "p_no_echo": Real(0.01, 0.9),
            "sigma_m": Real(0.02, 0.2, log=True),
            "damping": Real(0.0, 0.9),
        }
