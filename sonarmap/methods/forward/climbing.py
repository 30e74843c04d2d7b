"""Thrun's forward model, its most probable map found by hill climbing.

Thrun, Learning Occupancy Grid Maps with Forward Sensor Models, Autonomous Robots 15, 2003; Thrun,
Burgard, Fox, Probabilistic Robotics, table 9.3. The map of greatest posterior is sought::

    m* = argmax  sum over readings ln P(z | m) + l0 * number of occupied cells,
    l0 = ln(prior / (1 - prior))

from an empty map, by flipping single cells as long as one flip goes uphill. The probability of a
cell is its posterior with all the others as in m* (Thrun 2003, section 5)::

    ln(P / (1 - P)) = l0 + ln P(Z | m* with c occupied) - ln P(Z | m* with c free)

Thrun climbs the expected log-likelihood of the causes and works them out anew in rounds
(expectation maximisation); here the causes are summed over, which is what those rounds climb
towards. The sensor model is in `sonarmap.methods.forward.model`, with what is ours in it. Ours as
well: the order of the cells is drawn anew for each sweep; climbing starts again from the best map
with a share of its cells drawn anew, for it ends on a local height; and `temper` may take back some
of the confidence.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.errors import whole, within
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.forward.model import ForwardModel
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["ThrunForward"]

# Cells that are drawn anew for another start.
_SHAKEN = 0.1
_LOG_ODDS_MAX = 700.0


@dataclass(frozen=True, kw_only=True)
class ThrunForward(ForwardModel):
    """The most probable map of a forward model, by hill climbing with restarts.

    Parameters
    ----------
    starts : int
        How often climbing starts, >= 1: first from the empty map, then from the best one shaken.
    max_sweeps : int
        Sweeps over the cells of a start at most, >= 1.
    temper : float
        Share of the evidence that counts in the probabilities, in [0, 1]; the map that is climbed
        to does not depend on it. 1 is Thrun's.
    seed : int
        Of the order of the cells and of the shaking, >= 0.
    prior, p_hit, edge, p_random, p_no_echo, sigma_m, max_range_m, repeat_travel_m, repeat_turn_rad
        See `ForwardModel`.
    """

    name: ClassVar[str] = "thrun-forward"
    source: ClassVar[str] = (
        "Thrun, Learning Occupancy Grid Maps with Forward Sensor Models, Autonomous Robots 15, "
        "2003; Probabilistic Robotics, table 9.3; parameters and the cone's factor ours."
    )

    starts: int = 2
    max_sweeps: int = 10
    temper: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, least in (("starts", 1), ("max_sweeps", 1), ("seed", 0)):
            object.__setattr__(self, name, whole(name, getattr(self, name), least=least))
        within("temper", self.temper, 0, 1)

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid; observed is what any cone touched."""
        from sonarmap.kernels.forward import by_cell, climb, log_likelihood, log_odds, remember

        f = self.factors(log, grid)
        cells = grid.rows * grid.cols
        touched = by_cell(f.first, f.cell, cells)
        sensed = (f.zone, f.answers, f.floor, f.scale, f.density, f.beyond, f.vote)
        memory = (np.empty(f.floor.size), np.empty(f.density.shape), np.empty(f.floor.size))
        # Only a cell on an arc can ever make a reading likelier by being occupied.
        candidates = np.unique(f.cell[f.zone >= 0])
        rng = np.random.default_rng(self.seed)

        def recall(occupied: np.ndarray) -> None:
            remember(occupied, f.first, f.cell, f.zone, f.answers, f.density, f.beyond, *memory)

        best, highest = np.zeros(cells, bool), -np.inf
        for start in range(self.starts):
            occupied = best.copy()
            if start:
                shaken = candidates[rng.random(candidates.size) < _SHAKEN]
                occupied[shaken] = rng.random(shaken.size) < 0.5
            for _ in range(self.max_sweeps):
                recall(occupied)  # anew each sweep, so that rounding does not pile up
                order = rng.permutation(candidates)
                if not climb(occupied, order, self.prior_log_odds, *touched, *sensed, *memory):
                    break
            recall(occupied)
            height = log_likelihood(f.floor, f.scale, f.vote, memory[0], memory[2])
            height += self.prior_log_odds * occupied.sum()
            if height > highest:
                best, highest = occupied, height

        recall(best)
        evidence = log_odds(best, 0.0, *touched, *sensed, *memory)
        odds = self.prior_log_odds + self.temper * evidence
        p = 1 / (1 + np.exp(-odds.clip(-_LOG_ODDS_MAX, _LOG_ODDS_MAX)))
        observed = np.diff(touched[0]) > 0
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
            "temper": Real(0.01, 1.0, log=True),
        }
