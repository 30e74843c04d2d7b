"""Goodness of maps without ground truth: the three measures of Rashid 2006, section 5.3.

`Spread.vsdns`, the mean of standard deviations: how much the model disagrees with itself about
a cell. `map_derivative`: how much a map differs from cell to cell. `compare_runs`: how far the
maps of two runs of one path agree. For the search over parameter sets, `thesis_parameter_sets`
and `map_and_spread`, which maps one log by many models.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError
from sonarmap.methods.bayes.spread import Spread, map_and_spread, thesis_parameter_sets
from sonarmap.occupancy import OccupancyMap

__all__ = [
    "RunComparison",
    "Spread",
    "compare_runs",
    "map_and_spread",
    "map_derivative",
    "thesis_parameter_sets",
]


@dataclass(frozen=True, slots=True)
class RunComparison:
    """Counts of the cells of two maps of the same path.

    Two comparisons of the same cell size add up (``a + b``).

    Parameters
    ----------
    both_occupied, both_free : int
        Cells that both maps call occupied, or free.
    differing : int
        Cells that one map calls occupied and the other free.
    one_sided : int
        Cells that one map calls occupied or free and the other leaves unknown.
    """

    both_occupied: int
    both_free: int
    differing: int
    one_sided: int

    def __add__(self, other: RunComparison) -> RunComparison:
        return RunComparison(*(getattr(self, n) + getattr(other, n) for n in self.__slots__))

    @property
    def positive(self) -> int:
        """Total positive score of the thesis: cells of the same known state (intersection)."""
        return self.both_occupied + self.both_free

    @property
    def negative(self) -> int:
        """Total negative score of the thesis: cells of differing known state (exclusive or)."""
        return self.differing

    @property
    def agreement(self) -> float:
        """Share of the cells known in both maps that agree; higher is better. NaN if none is."""
        compared = self.positive + self.negative
        return self.positive / compared if compared else math.nan

    def to_dict(self) -> dict[str, Any]:
        """Return scores and counts as JSON-able values; None for a score that is not defined."""
        agreement = self.agreement
        return {
            "agreement": agreement if math.isfinite(agreement) else None,
            "positive": self.positive,
            "negative": self.negative,
            "counts": asdict(self),
        }


def map_derivative(m: OccupancyMap, *, updated: NDArray[np.bool_] | None = None) -> float:
    """Return the derivative ("noise") of a map per updated cell; lower is better (p. 37).

    Parameters
    ----------
    m : OccupancyMap
        The map.
    updated : ndarray of bool, shape (rows, cols), optional
        The cells that readings spoke of, as `Spread.updated`. By default those that the map calls
        observed or, where it does not say, those whose log-odds are not 0.

    Returns
    -------
    float
        With D the mean absolute difference of a cell's P(occupied) to its eight neighbours', the
        sum of D over the cells that have eight, by the number of updated cells in the map. NaN
        if no cell is updated.

    Raises
    ------
    InputError
        If `updated` does not have the map's shape.
    """
    if updated is None:
        updated = m.log_odds != 0 if m.observed is None else m.observed
    if updated.shape != m.grid.shape:
        raise InputError(f"updated must have the grid's shape {m.grid.shape}, got {updated.shape}")
    count = int(updated.sum())
    rows, cols = m.grid.shape
    if not count:
        return math.nan
    if min(rows, cols) < 3:
        return 0.0
    p = m.probability
    inner = p[1:-1, 1:-1]
    total = 0.0
    for down, right in itertools.product((0, 1, 2), repeat=2):
        neighbour = p[down : down + rows - 2, right : right + cols - 2]
        total += float(np.abs(neighbour - inner).sum())
    return total / 8 / count


def compare_runs(
    a: OccupancyMap, b: OccupancyMap, *, occupied_from: float | None = None
) -> RunComparison:
    """Compare the maps of two runs of the same path, cell by cell (p. 37 to 39).

    Parameters
    ----------
    a, b : OccupancyMap
        The maps, on the same grid.
    occupied_from : float, optional
        A cell is occupied from this P(occupied) on and free up to 1 less it, in (0.5, 1); by
        default each map's own limits hold. Between the two its state is unknown and not compared:
        counting the unknown as empty, as a binary map of obstacles does, would reward a map for
        saying nothing.

    Raises
    ------
    InputError
        If the grids differ or the threshold breaks its rule.
    """
    if a.grid != b.grid:
        raise InputError(f"both maps must have the same grid, got {a.grid} and {b.grid}")
    if occupied_from is None:
        (occupied_a, free_a), (occupied_b, free_b) = ((m.occupied, m.free) for m in (a, b))
    elif 0.5 < occupied_from < 1:
        (occupied_a, free_a), (occupied_b, free_b) = (
            (m.probability >= occupied_from, m.probability <= 1 - occupied_from) for m in (a, b)
        )
    else:
        raise InputError(f"occupied_from must be in (0.5, 1), got {occupied_from!r}")
    known_a, known_b = occupied_a | free_a, occupied_b | free_b
    return RunComparison(
        both_occupied=int((occupied_a & occupied_b).sum()),
        both_free=int((free_a & free_b).sum()),
        differing=int((occupied_a & free_b).sum() + (free_a & occupied_b).sum()),
        one_sided=int((known_a ^ known_b).sum()),
    )
