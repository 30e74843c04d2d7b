"""`FrameMaker`: frames of the robots of a batch, with where each has been in its episode."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import gymnasium
import numpy as np
from numpy.typing import NDArray

from sim.envs.pictures.drawing import draw

if TYPE_CHECKING:
    from sim.envs.episode_batch import EpisodeBatch

__all__ = ["FrameMaker"]


class FrameMaker:
    """Draws the robots of a batch; keeps their trails and scores, which no robot needs.

    Parameters
    ----------
    batch : EpisodeBatch
        The robots; they are looked at, never changed.
    robots : int
        How many.
    """

    def __init__(self, batch: EpisodeBatch, robots: int) -> None:
        self._batch = batch
        self._trails: list[list[tuple[float, float]]] = [[] for _ in range(robots)]
        self._scores = [0.0] * robots

    def begin(self, rows: Iterable[int]) -> None:
        """Note that some robots have begun episodes."""
        for row in rows:
            self._trails[row], self._scores[row] = [self._place(row)], 0.0

    def step(self, rows: Iterable[int], reward: NDArray[np.float64]) -> None:
        """Note that some robots have driven for a control step, and what each has earned."""
        for row in rows:
            self._trails[row].append(self._place(row))
            self._scores[row] += float(reward[row])

    def frame(self, row: int) -> NDArray[np.uint8]:
        """Return the frame of one robot, shape (height, width, 3).

        Raises
        ------
        gymnasium.error.ResetNeeded
            If it has not begun an episode.
        """
        if not self._trails[row]:
            raise gymnasium.error.ResetNeeded("reset must be called before the first frame")
        time_s = float(self._batch.states["time_s"][row])
        caption = f"{time_s:.1f} s · reward {self._scores[row]:.2f}"
        return draw(self._batch.scene(row, np.array(self._trails[row]), caption))

    def _place(self, row: int) -> tuple[float, float]:
        x_m, y_m, _ = self._batch.states["true_pose"][row].tolist()
        return x_m, y_m
