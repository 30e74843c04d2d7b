"""Explore: map an unknown room with sonar alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from sim.envs.tasks.task import Briefing, Moment, Verdict, weighted

__all__ = ["Explore", "ExploreWeights", "explore_terms"]


@dataclass(frozen=True, slots=True)
class ExploreWeights:
    """Weights of the reward's terms, see `explore_terms`."""

    map_score: float = 1.0
    area: float = 0.1
    collision: float = -0.5
    effort: float = -0.01


class Explore:
    """Judges how the truth of the robots' maps grows.

    Parameters
    ----------
    robots : int
        How many.
    weights : ExploreWeights, optional
        Of the terms of the reward.
    """

    MAPPED_SHARE = 0.95
    """The episode ends when the map calls this share of the reachable cells free; assumed."""

    needs_maps = True
    observations: Mapping[str, Box] = {}

    def __init__(self, robots: int, weights: ExploreWeights | None = None) -> None:
        self._weights = asdict(weights or ExploreWeights())
        self._cell_m2, self._reachable = np.ones((2, robots))

    def begin(self, row: int, briefing: Briefing) -> None:
        """Begin the episode of one robot."""
        self._cell_m2[row] = briefing.facts.grid.cell_area_m2
        self._reachable[row] = briefing.facts.reachable_cells

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return nothing: the robot is told nothing."""
        return {}

    def judge(self, moment: Moment) -> Verdict:
        """Judge the control step that has just ended."""
        maps = moment.maps
        assert maps is not None, "Explore needs maps"
        terms = explore_terms(
            maps.bits_gained * self._cell_m2,
            maps.new_cells * self._cell_m2,
            moment.states["touched"],
            moment.effort,
        )
        mapped_share = maps.mapped_cells / self._reachable
        return Verdict(
            terms,
            weighted(terms, self._weights),
            moment.stuck | (mapped_share >= self.MAPPED_SHARE),
            {"mapped_share": mapped_share},
        )

    def goal_of(self, row: int) -> tuple[float, float] | None:
        """Return None: there is no goal."""
        return None


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
        See `Moment`.
    """
    return {
        "map_score": score_m2,
        "area": area_m2,
        "collision": touched.astype(float),
        "effort": effort,
    }
