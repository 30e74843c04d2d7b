"""Explore: map an unknown room with sonar alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.envs.tasks.task import Evaluation, StepOutcome, Task, TaskSetup

__all__ = ["Explore", "ExploreWeights", "explore_terms"]


@dataclass(frozen=True, slots=True)
class ExploreWeights:
    """Weights of the reward's terms, see `explore_terms`."""

    map_score: float = 1.0
    area: float = 0.1
    collision: float = -0.5
    effort: float = -0.01


class Explore(Task):
    """Map an unknown room with sonar alone.

    Terms of the reward (weights: `ExploreWeights`)
    -----------------------------------------------
    ``map_score``: gain of the true map score in this step, bit m^2, summed over the cells that
    are not hidden. ``area``: m^2 of which a reading spoke for the first time. ``collision``: 1 if
    the robot touched something. ``effort``: mean square of the wanted wheel speeds over 0.75 m/s.

    Ends
    ----
    When the map calls 95 % of the cells that the robot can reach free; ``info["mapped_share"]``.
    After 1200 steps.
    """

    weights_class = ExploreWeights
    # Control steps of a tenth of a second; assumed.
    max_episode_steps = 1200
    needs_maps = True

    MAPPED_SHARE = 0.95
    """The episode ends when the map calls this share of the reachable cells free; assumed."""

    def __init__(self, robots: int, weights: ExploreWeights | None = None) -> None:
        super().__init__(robots, weights)
        self._cell_m2, self._reachable = np.ones((2, robots))

    def begin(self, row: int, setup: TaskSetup) -> None:
        """Begin the episode of one robot."""
        self._cell_m2[row] = setup.facts.grid.cell_area_m2
        self._reachable[row] = setup.facts.reachable_cells

    def evaluate(self, outcome: StepOutcome) -> Evaluation:
        """Evaluate the control step that has just ended."""
        maps = outcome.maps
        assert maps is not None, "Explore needs maps"
        terms = explore_terms(
            maps.bits_gained * self._cell_m2,
            maps.new_cells * self._cell_m2,
            outcome.states["touched"],
            outcome.effort,
        )
        mapped_share = maps.mapped_cells / self._reachable
        done = outcome.stuck | (mapped_share >= self.MAPPED_SHARE)
        return self.evaluation(terms, done, mapped_share=mapped_share)


def explore_terms(
    score_m2: NDArray[np.float64],
    area_m2: NDArray[np.float64],
    touched: NDArray[np.bool_],
    effort: NDArray[np.float64],
) -> dict[str, NDArray[np.float64]]:
    """Return the terms of the reward of one control step.

    Parameters
    ----------
    score_m2 : ndarray
        Gain of the map score (`sonarmap.MapScore.bits`) times the area of a cell, bit m^2;
        negative where the map got worse.
    area_m2 : ndarray
        Area of which a reading spoke for the first time, m^2, >= 0.
    touched : ndarray of bool
        Whether the robot touched something.
    effort : ndarray
        See `sim.envs.tasks.task.StepOutcome`.
    """
    return {
        "map_score": score_m2,
        "area": area_m2,
        "collision": touched.astype(float),
        "effort": effort,
    }
