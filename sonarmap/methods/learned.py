"""The learned mapper: a small network over what a whole log says of each cell.

`sonarmap.learned` has its parts: `channels`, the evidence; `network`, the forward pass; `weights`,
the file; and beside it the model card, `mapper.md`: which data, which command, how good, and what
it cannot do. Nothing but numpy and numba is needed to use it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from sonarmap.errors import InputError, within
from sonarmap.grid import GridSpec
from sonarmap.learned.growing import GrowingLog
from sonarmap.log import SonarLog
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space
from sonarmap.rings import SonarRing

if TYPE_CHECKING:
    from sonarmap.learned.weights import Weights

__all__ = ["Learned", "LearnedMap"]


@dataclass(frozen=True)
class Learned:
    """P(occupied) by a network, calibrated on rooms that it was not fitted to.

    Parameters
    ----------
    weights : str, optional
        File of other weights, as `scripts/train_mapper.py` writes it. By default those that ship.
    occupied_from, free_up_to : float, optional
        From where on, and up to where, a cell of the map counts as occupied or free. By default
        what the weights say, chosen on training rooms: a calibrated P of a thin wall rarely is
        high, for odometry is not that exact.

    Notes
    -----
    A cell that no sonar could see, as far as the network can tell, is not observed: it is neither
    occupied nor free, and its P is the share of walls among such cells.
    """

    name: ClassVar[str] = "learned"
    source: ClassVar[str] = (
        "Ours: a U-Net over the evidence of the whole log, trained in simulation."
    )

    weights: str | None = None
    occupied_from: float | None = None
    free_up_to: float | None = None

    def __post_init__(self) -> None:
        for name in ("occupied_from", "free_up_to"):
            if getattr(self, name) is not None:
                within(name, getattr(self, name), 0, 1)
        if self.weights is not None and not isinstance(self.weights, str):
            raise InputError(f"weights must be the path of a file, got {self.weights!r}")

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map of a log on a grid.

        Raises
        ------
        InputError
            If the weights cannot be read, are not what was written, or are of another version.
        """
        from sonarmap.learned.mapping import learned_cells

        weights = self._loaded()
        cells = learned_cells(weights, log, grid)
        occupied_from, free_up_to = (
            getattr(weights, name) if getattr(self, name) is None else getattr(self, name)
            for name in ("occupied_from", "free_up_to")
        )
        return OccupancyMap.from_probability(
            grid,
            cells.probability,
            cells.observed,
            occupied_from=occupied_from,
            free_up_to=free_up_to,
        )

    def begin(self, ring: SonarRing, grid: GridSpec) -> LearnedMap:
        """Return an empty map, to which readings are added one at a time.

        Its `map` is of the past alone and is made anew after 10 cm of way (and a hundredth of all
        of it), 20 degrees of turning or 100 readings; in between it stays as it was.
        """
        self._loaded()
        return LearnedMap(self, ring, grid)

    def _loaded(self) -> Weights:
        from sonarmap.learned.weights import shipped

        return shipped(self.weights)

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched: the thresholds of pictures, for the rest is learned."""
        return {"occupied_from": Real(0.1, 0.6)}


class LearnedMap:
    """A learned map of what was read so far.

    Parameters
    ----------
    method : Learned
        The method.
    ring, grid
        The sonars and the cells.
    """

    def __init__(self, method: Learned, ring: SonarRing, grid: GridSpec) -> None:
        self._method, self._grid = method, grid
        self._log = GrowingLog(ring)
        self._map: OccupancyMap | None = None

    def add(self, readings: SonarLog) -> None:
        """Add readings of the ring that the map was begun for, in the order of firing."""
        self._log.add(readings)

    @property
    def map(self) -> OccupancyMap:
        """The map of the past; see `Learned.begin` for when it is made anew."""
        if self._log.is_due:
            self._map = self._method.map(self._log.whole(), self._grid)
        elif self._map is None:
            nothing = SonarLog(self._log.ring, *([] for _ in range(7)))  # type: ignore[arg-type]
            self._map = self._method.map(nothing, self._grid)
        return self._map
