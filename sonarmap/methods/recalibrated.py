"""A method whose probabilities go through a logistic of two numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sonarmap.errors import finite, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.conversion import sigmoid
from sonarmap.methods.protocol import MappingMethod
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["Recalibrated"]


@dataclass(frozen=True)
class Recalibrated:
    """A mapping method, recalibrated: log-odds l become ``slope * l + intercept`` (Platt 1999).

    It ranks cells as the method does and says how sure it is as walls are: what a method that
    counts votes lacks. A cell that nobody saw, of P = 0.5, gets the intercept.

    Parameters
    ----------
    method : MappingMethod
        Whose map.
    slope, intercept : float
        The two numbers, as a rule fitted on rooms whose walls are known; the slope is > 0.
    """

    source: ClassVar[str] = "Platt, Advances in Large Margin Classifiers, 1999."

    method: MappingMethod
    slope: float = 1.0
    intercept: float = 0.0

    def __post_init__(self) -> None:
        positive("slope", self.slope)
        finite("intercept", self.intercept)

    @property
    def name(self) -> str:
        """The method's name, and that it is recalibrated."""
        return f"{self.method.name}, logistic"

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid; its thresholds move with the probabilities."""
        m = self.method.map(log, grid)
        p = sigmoid(self.slope * m.log_odds + self.intercept)
        return OccupancyMap.from_probability(
            grid,
            p,
            m.observed,
            occupied_from=self._moved(m.occupied_from),
            free_up_to=self._moved(m.free_up_to),
        )

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched of the two numbers; the method's own space is apart."""
        return {"slope": Real(0.001, 3.0, log=True), "intercept": Real(-6.0, 3.0)}

    def _moved(self, p: float) -> float:
        import numpy as np

        odds = np.log(p) - np.log1p(-p)
        return float(sigmoid(np.array(self.slope * odds + self.intercept)))
