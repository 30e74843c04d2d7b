"""How good a map is, judged by the truth: every score keeps its counts, so that scores add up."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from sonarmap.errors import InputError
from sonarmap.grid import GridSpec
from sonarmap.occupancy import OccupancyMap
from sonarmap.scores.probabilities import CLAMP, ProbabilityCounts
from sonarmap.scores.shapes import ShapeCounts

__all__ = ["GridTruth", "MapScore", "ToleranceCount", "score_map"]

# States of a true cell, as `worlds.CellState` numbers them.
_OCCUPIED, _HIDDEN = 1, 2
TOLERANCES_M = (0.10, 0.20)


class GridTruth(Protocol):
    """The truth of a grid: what `score_map` asks of `worlds.TruthGrid`."""

    @property
    def grid(self) -> GridSpec:
        """Where the cells are."""

    @property
    def state(self) -> NDArray[np.uint8]:
        """0 free, 1 occupied, 2 hidden; shape (rows, cols)."""


@dataclass(frozen=True, slots=True)
class ToleranceCount:
    """Occupied cells that have a counterpart within a tolerance.

    Parameters
    ----------
    tolerance_m : float
        Largest distance between cell centres, metres.
    map_hits : int
        Cells occupied in the map with an occupied cell of the truth that near.
    truth_hits : int
        Cells occupied in the truth with an occupied cell of the map that near.
    """

    tolerance_m: float
    map_hits: int
    truth_hits: int


@dataclass(frozen=True, slots=True)
class MapScore:
    """Counts and sums over the scored cells, and the scores that follow from them.

    Two scores of the same resolution add up (``a + b``): the sum is the score of both maps taken
    as one, never an average of averages.

    Parameters
    ----------
    resolution_m : float
        Side of a cell, metres.
    cells : int
        Scored cells, N.
    truth_occupied, map_occupied : int
        Of these, occupied in truth; in the map (`OccupancyMap.occupied`, by default P >= 0.65).
    known : int
        Cells that the map calls occupied or free (by default P <= 0.35).
    false_free, phantom : int
        Occupied cells mapped as free; free cells mapped as occupied.
    bits : float
        Sum of 1 + log2(P of the true state), P clamped to [0.01, 0.99] (Martin & Moravec 1996).
    squared_error : float
        Sum of (P - truth)^2.
    map_sum, map_square_sum, product_sum : float
        Sums of P, P^2 and P * truth.
    map_distance_m, truth_distance_m : float
        Sums of the distance of each occupied cell of the map to the nearest of the truth, and
        the other way; inf if there is none.
    tolerances : tuple of ToleranceCount
        At one cell, 10 cm and 20 cm.
    probabilities : ProbabilityCounts, optional
        The cells by their probabilities, and the loss of the blank sheet. None for a score that is
        made of the other counts alone: what follows from these is then NaN.
    shapes : ShapeCounts, optional
        The walls as pictures; None as for `probabilities`.
    """

    resolution_m: float
    cells: int
    truth_occupied: int
    map_occupied: int
    known: int
    false_free: int
    phantom: int
    bits: float
    squared_error: float
    map_sum: float
    map_square_sum: float
    product_sum: float
    map_distance_m: float
    truth_distance_m: float
    tolerances: tuple[ToleranceCount, ...]
    probabilities: ProbabilityCounts | None = field(default=None, compare=False)
    shapes: ShapeCounts | None = field(default=None, compare=False)

    def __add__(self, other: MapScore) -> MapScore:
        if self.resolution_m != other.resolution_m:
            raise InputError(
                "scores must be of the same resolution_m to be added, got "
                f"{self.resolution_m!r} and {other.resolution_m!r}"
            )
        sums = {
            name: getattr(self, name) + getattr(other, name)
            for name in self.__slots__
            if name not in ("resolution_m", "tolerances", "probabilities", "shapes")
        }
        tolerances = tuple(
            ToleranceCount(a.tolerance_m, a.map_hits + b.map_hits, a.truth_hits + b.truth_hits)
            for a, b in zip(self.tolerances, other.tolerances, strict=True)
        )
        ours, others = self.probabilities, other.probabilities
        shapes, of_other = self.shapes, other.shapes
        return MapScore(
            resolution_m=self.resolution_m,
            tolerances=tolerances,
            probabilities=None if ours is None or others is None else ours + others,
            shapes=None if shapes is None or of_other is None else shapes + of_other,
            **sums,
        )

    @property
    def map_score(self) -> float:
        """Map Score per cell, bits: +1 perfect, 0 all unknown, -5.64 all confidently wrong."""
        return self.bits / self.cells

    @property
    def loss_bits(self) -> float:
        """Log loss of the map in bits, summed over the scored cells."""
        return self.cells - self.bits

    @property
    def sheet_loss_bits(self) -> float:
        """Log loss of the blank sheet, the constant map with each room's own share of walls."""
        return math.nan if self.probabilities is None else self.probabilities.sheet_loss_bits

    @property
    def skill(self) -> float:
        """1 - H(map) / H(sheet), H the log loss: the information gained over the blank sheet.

        0 for a map that knows only the room's share of walls, below 0 for one that is worse. NaN
        where no occupied cell was scored, for then the sheet knows all.
        """
        return self._skill_of(self.loss_bits)

    @property
    def skill_ceiling(self) -> float:
        """Skill of the perfect map: the clamp keeps it below 1."""
        return self._skill_of(-self.cells * math.log2(1 - CLAMP))

    @property
    def recalibrated_skill(self) -> float:
        """Skill after the best monotone recalibration: what is lost to it was overconfidence."""
        if self.probabilities is None:
            return math.nan
        return self._skill_of(self.probabilities.recalibrated_loss_bits)

    def _skill_of(self, loss_bits: float) -> float:
        return 1 - loss_bits / self.sheet_loss_bits if self.truth_occupied else math.nan

    @property
    def average_precision(self) -> float:
        """Area under the precision-recall curve of the occupied cells, see `ProbabilityCounts`."""
        return math.nan if self.probabilities is None else self.probabilities.average_precision

    @property
    def tolerant_average_precision(self) -> float:
        """The same where a wall is hit by a cell within one cell of it, each wall cell once."""
        if self.probabilities is None or self.shapes is None:
            return math.nan
        return self.shapes.tolerant_average_precision(self.probabilities)

    @property
    def wall_gap_m(self) -> float:
        """Length of the walls without an occupied cell of the map within one cell, metres.

        A wall is as long as its surface has cells: what runs aslant counts by its longer side.
        """
        return (self.truth_occupied - self.tolerances[0].truth_hits) * self.resolution_m

    @property
    def thickness_m(self) -> float:
        """Area of the map's occupied cells within 20 cm of a wall over the length found, metres.

        One cell for a perfect map; NaN where no wall was found.
        """
        found = self.tolerances[-1].truth_hits
        return self.resolution_m * _ratio(self.tolerances[-1].map_hits, found)

    @property
    def baddeley_m(self) -> float:
        """Baddeley's distance of the walls, metres, see `ShapeCounts`; 0 for equal walls."""
        return math.nan if self.shapes is None else self.shapes.baddeley_m

    @property
    def image_dissimilarity(self) -> float:
        """Image similarity of Birk and Carpin (2006), 0 for equal pictures, in cells."""
        return math.nan if self.shapes is None else self.shapes.dissimilarity

    @property
    def calibration_error(self) -> float:
        """Expected calibration error, 15 bins of equal count, see `ProbabilityCounts`."""
        return math.nan if self.probabilities is None else self.probabilities.calibration_error

    @property
    def brier(self) -> float:
        """Mean squared error of P(occupied): 0 perfect, 0.25 all unknown."""
        return self.squared_error / self.cells

    @property
    def correlation(self) -> float:
        """Pearson correlation of P(occupied) with the truth; 0 for a constant map."""
        n, truth = self.cells, self.truth_occupied
        covariance = self.product_sum / n - self.map_sum / n * truth / n
        variance_map = self.map_square_sum / n - (self.map_sum / n) ** 2
        variance_truth = truth / n * (1 - truth / n)
        # A constant map's variance is rounding noise around 0.
        if variance_map < 1e-12 or variance_truth <= 0:
            return 0.0
        return covariance / math.sqrt(variance_map * variance_truth)

    def precision(self, tolerance: int) -> float:
        """Share of the map's occupied cells that are right, NaN if there is none.

        `tolerance` is an index: 0 within one cell, 1 within 10 cm, 2 within 20 cm.
        """
        return _ratio(self.tolerances[tolerance].map_hits, self.map_occupied)

    def recall(self, tolerance: int) -> float:
        """Share of the truth's occupied cells that were found, NaN if there is none."""
        return _ratio(self.tolerances[tolerance].truth_hits, self.truth_occupied)

    def f1(self, tolerance: int) -> float:
        """Harmonic mean of precision and recall; 0 when nothing was found."""
        precision, recall = self.precision(tolerance), self.recall(tolerance)
        if not precision + recall > 0:  # also when one of them is NaN
            return 0.0
        return 2 * precision * recall / (precision + recall)

    @property
    def coverage(self) -> float:
        """Share of the scored cells that the map calls free or occupied."""
        return self.known / self.cells

    @property
    def false_free_m2(self) -> float:
        """Area of occupied cells mapped as free, square metres."""
        return self.false_free * self.resolution_m**2

    @property
    def phantom_m2(self) -> float:
        """Area of free cells mapped as occupied, square metres."""
        return self.phantom * self.resolution_m**2

    @property
    def map_to_truth_m(self) -> float:
        """Mean distance from the map's occupied cells to the truth's (ADNN), metres."""
        return _ratio(self.map_distance_m, self.map_occupied)

    @property
    def truth_to_map_m(self) -> float:
        """Mean distance from the truth's occupied cells to the map's (NE), metres."""
        return _ratio(self.truth_distance_m, self.truth_occupied)

    def to_dict(self) -> dict[str, Any]:
        """Return scores and counts as JSON-able values; None for a score that is not defined."""
        names = ("1_cell", "10_cm", "20_cm")
        scores: dict[str, float] = {}
        for index, name in enumerate(names):
            scores[f"precision_{name}"] = self.precision(index)
            scores[f"recall_{name}"] = self.recall(index)
            scores[f"f1_{name}"] = self.f1(index)
        for name in (
            "map_score",
            "skill",
            "skill_ceiling",
            "recalibrated_skill",
            "average_precision",
            "tolerant_average_precision",
            "calibration_error",
            "brier",
            "correlation",
            "coverage",
            "false_free_m2",
            "phantom_m2",
            "wall_gap_m",
            "thickness_m",
            "baddeley_m",
            "image_dissimilarity",
            "map_to_truth_m",
            "truth_to_map_m",
        ):
            scores[name] = getattr(self, name)
        return {
            **{name: value if math.isfinite(value) else None for name, value in scores.items()},
            "counts": {
                name: value if not isinstance(value, float) or math.isfinite(value) else None
                for name, value in asdict(replace(self, probabilities=None, shapes=None)).items()
                if name not in ("probabilities", "shapes")
            },
        }


def score_map(
    m: OccupancyMap, truth: GridTruth, *, observable: NDArray[np.bool_] | None = None
) -> MapScore:
    """Score a map against the truth.

    Parameters
    ----------
    m : OccupancyMap
        The map, or anything with ``.grid`` and ``.probability``, see `OccupancyMap.of`.
    truth : GridTruth
        The truth on the same grid, as `worlds.truth` makes it. Hidden cells are never scored.
    observable : ndarray of bool, shape (rows, cols), optional
        Which cells to score, as ``truth.observable(log)`` tells: those that the log's sonars
        could have seen. By default all that are not hidden.

    Returns
    -------
    MapScore

    Raises
    ------
    InputError
        If it is no map, the grids differ, or no cell is left to score.

    Notes
    -----
    What counts as occupied and as free in the map is the map's own to say. Distances are between
    cell centres, within the scored cells.
    """
    m = OccupancyMap.of(m)
    if m.grid != truth.grid:
        raise InputError(f"map and truth must have the same grid, got {m.grid} and {truth.grid}")
    scored = truth.state != _HIDDEN
    if observable is not None:
        if observable.shape != m.grid.shape:
            raise InputError(
                f"observable must have the grid's shape {m.grid.shape}, got {observable.shape}"
            )
        scored &= observable
    if not scored.any():
        raise InputError("no cell is left to score: none is observable")

    p = m.probability
    occupied_map, free_map = scored & m.occupied, scored & m.free
    occupied_truth = scored & (truth.state == _OCCUPIED)
    to_truth_m = _distance_m(occupied_truth, m.grid)[occupied_map]
    to_map_m = _distance_m(occupied_map, m.grid)[occupied_truth]
    tolerances = tuple(
        ToleranceCount(
            tolerance_m,
            # The slack forgives the rounding of a distance that equals the tolerance.
            int((to_truth_m <= tolerance_m + 1e-9).sum()),
            int((to_map_m <= tolerance_m + 1e-9).sum()),
        )
        for tolerance_m in (m.grid.resolution_m, *TOLERANCES_M)
    )
    shapes = ShapeCounts.of(p, occupied_map, free_map, occupied_truth, scored, m.grid.resolution_m)
    p, g = p[scored], occupied_truth[scored]
    occupied, free = occupied_map[scored], free_map[scored]
    clamped = p.clip(CLAMP, 1 - CLAMP)
    return MapScore(
        resolution_m=m.grid.resolution_m,
        cells=int(scored.sum()),
        truth_occupied=int(g.sum()),
        map_occupied=int(occupied_map.sum()),
        known=int((occupied | free).sum()),
        false_free=int((g & free).sum()),
        phantom=int((~g & occupied).sum()),
        bits=float((1 + np.log2(np.where(g, clamped, 1 - clamped))).sum()),
        squared_error=float(((p - g) ** 2).sum()),
        map_sum=float(p.sum()),
        map_square_sum=float((p**2).sum()),
        product_sum=float(p[g].sum()),
        map_distance_m=float(to_truth_m.sum()),
        truth_distance_m=float(to_map_m.sum()),
        tolerances=tolerances,
        probabilities=ProbabilityCounts.of(p, g),
        shapes=shapes,
    )


def _distance_m(occupied: NDArray[np.bool_], grid: GridSpec) -> NDArray[np.float64]:
    """Return the distance of every cell to the nearest marked one, inf if none is marked."""
    if not occupied.any():
        return np.full(grid.shape, np.inf)
    distance: NDArray[np.float64] = distance_transform_edt(~occupied) * grid.resolution_m
    return distance


def _ratio(part: float, whole: float) -> float:
    return part / whole if whole else math.nan
