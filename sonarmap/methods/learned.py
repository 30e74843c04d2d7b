"""The learned mapper: a small network over what a whole log says of each cell.

`sonarmap.learned` has its parts: `channels`, the evidence; `network`, the forward pass; `weights`,
the file; and beside it the model card, `mapper.md`: which data, which command, how good, and what
it cannot do. Nothing but numpy and numba is needed to use it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sonarmap.errors import InputError, within
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Real, Space

__all__ = ["Learned"]


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
        from sonarmap.learned.weights import shipped

        weights = shipped(self.weights)
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

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched: the thresholds of pictures, for the rest is learned."""
        return {"occupied_from": Real(0.1, 0.6)}
