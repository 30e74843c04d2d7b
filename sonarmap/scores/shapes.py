"""How alike the walls of a map and of the truth are as pictures; counts of several maps add up."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_cdt, distance_transform_edt

from sonarmap.scores.probabilities import ProbabilityCounts, class_of

__all__ = ["BADDELEY_CUT_M", "ShapeCounts", "Taxicab"]

BADDELEY_CUT_M = 0.5
"""Distances beyond this are alike in Baddeley's distance. Assumed: what a robot drives around."""

_Cells = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Taxicab:
    """Cells of one kind, and how far the nearest of that kind in the other picture is.

    Parameters
    ----------
    cells : int
        Cells of the kind.
    steps : float
        Sum of the taxicab distances to the nearest, in cells; inf if the other picture has none.
    """

    cells: int
    steps: float

    def __add__(self, other: Taxicab) -> Taxicab:
        return Taxicab(self.cells + other.cells, self.steps + other.steps)

    @property
    def mean(self) -> float:
        """Mean distance; 0 where there is no such cell."""
        return self.steps / self.cells if self.cells else 0.0


@dataclass(frozen=True, eq=False)
class ShapeCounts:
    """What the scores of shapes need of one map or several.

    Parameters
    ----------
    claimed : ndarray of int, shape (1400,)
        Cells of each class of P (see `ProbabilityCounts`) that claim an occupied cell of the truth
        within one cell; each of these can be claimed once.
    cells : int
        Scored cells.
    baddeley_m2 : float
        Sum of the squared differences of the distances to the walls, cut, square metres.
    similarity : tuple of Taxicab
        Of the map's occupied cells, the truth's, the map's free cells, the truth's.
    """

    claimed: NDArray[np.int64]
    cells: int
    baddeley_m2: float
    similarity: tuple[Taxicab, Taxicab, Taxicab, Taxicab]

    @classmethod
    def of(
        cls,
        p: NDArray[np.float64],
        occupied_map: _Cells,
        free_map: _Cells,
        occupied_truth: _Cells,
        scored: _Cells,
        resolution_m: float,
    ) -> ShapeCounts:
        """Return the counts of a map, all arrays of shape (rows, cols)."""
        cut = (_cut_m(each, resolution_m)[scored] for each in (occupied_map, occupied_truth))
        ours_m, true_m = cut
        free_truth = scored & ~occupied_truth
        kinds = (
            (occupied_map, occupied_truth),
            (occupied_truth, occupied_map),
            (free_map, free_truth),
            (free_truth, free_map),
        )
        claims = _claims(np.where(scored, p, -1.0), occupied_truth)
        return cls(
            claimed=np.bincount(class_of(p[claims]), minlength=ProbabilityCounts.CLASSES),
            cells=int(scored.sum()),
            baddeley_m2=float(((ours_m - true_m) ** 2).sum()),
            similarity=tuple(_taxicab(one, other) for one, other in kinds),  # type: ignore[arg-type]  # four
        )

    def __add__(self, other: ShapeCounts) -> ShapeCounts:
        return ShapeCounts(
            self.claimed + other.claimed,
            self.cells + other.cells,
            self.baddeley_m2 + other.baddeley_m2,
            tuple(a + b for a, b in zip(self.similarity, other.similarity, strict=True)),  # type: ignore[arg-type]
        )

    def tolerant_average_precision(self, probabilities: ProbabilityCounts) -> float:
        """Return the average precision where a wall is hit by a cell within one cell of it."""
        walls = int(probabilities.occupied.sum())
        if not walls:
            return math.nan
        hits = self.claimed[::-1].cumsum()
        marked = (probabilities.free + probabilities.occupied)[::-1].cumsum()
        some = marked > 0
        precision, recall = hits[some] / marked[some], hits[some] / walls
        return float((precision * np.diff(recall, prepend=0.0)).sum())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ShapeCounts):
            return NotImplemented
        return (
            np.array_equal(self.claimed, other.claimed)
            and (self.cells, self.similarity) == (other.cells, other.similarity)
            and math.isclose(self.baddeley_m2, other.baddeley_m2)
        )

    def __hash__(self) -> int:
        return hash((self.cells, self.similarity))

    @property
    def baddeley_m(self) -> float:
        """Baddeley's distance, root mean square, distances cut at `BADDELEY_CUT_M`; metres."""
        return math.sqrt(self.baddeley_m2 / self.cells) if self.cells else math.nan

    @property
    def dissimilarity(self) -> float:
        """Image similarity of Birk and Carpin: 0 for equal pictures, more for others; in cells."""
        return sum(each.mean for each in self.similarity)


def _cut_m(walls: _Cells, resolution_m: float) -> NDArray[np.float64]:
    """Return the distance to the nearest wall, cut."""
    if not walls.any():
        return np.full(walls.shape, BADDELEY_CUT_M)
    far: NDArray[np.float64] = np.minimum(
        distance_transform_edt(~walls) * resolution_m, BADDELEY_CUT_M
    )
    return far


def _taxicab(cells: _Cells, others: _Cells) -> Taxicab:
    count = int(cells.sum())
    if not count or not others.any():
        return Taxicab(count, math.inf if count else 0.0)
    return Taxicab(count, float(distance_transform_cdt(~others, metric="taxicab")[cells].sum()))


def _claims(p: NDArray[np.float64], walls: _Cells) -> _Cells:
    """Return which cells claim a wall: the most probable first, as many as walls allow.

    A cell may take a wall cell from another that finds a different one (an augmenting path), so
    that of the cells above any threshold as many as possible claim, in whatever order equal ones
    come.
    """
    width = walls.shape[1] + 2
    is_wall = np.pad(walls, 1).ravel()
    rank = np.pad(p, 1, constant_values=-1.0).ravel()
    reach = np.array([0, 1, -1, width, -width])
    near = is_wall.copy()
    for step in reach[1:]:
        near |= np.roll(is_wall, step)
    cells = np.flatnonzero(near & (rank >= 0))
    cells = cells[np.argsort(-rank[cells], kind="stable")]
    walls_of = {
        cell: [cell + step for step in reach.tolist() if is_wall[cell + step]]
        for cell in cells.tolist()
    }
    claimed_by: dict[int, int] = {}
    claims = [cell for cell in cells.tolist() if _claim(cell, walls_of, claimed_by)]
    found = np.zeros(is_wall.size, bool)
    found[claims] = True
    inner: _Cells = found.reshape(-1, width)[1:-1, 1:-1]
    return inner


def _claim(cell: int, walls_of: dict[int, list[int]], claimed_by: dict[int, int]) -> bool:
    """Let a cell claim a wall cell, if others can make room for it; return whether it did."""
    come_from: dict[int, int] = {}  # a wall cell, and who asks for it
    asking = [cell]
    while asking:
        asker = asking.pop()
        for wall in walls_of[asker]:
            if wall in come_from:
                continue
            come_from[wall] = asker
            holder = claimed_by.get(wall)
            if holder is not None:
                asking.append(holder)
                continue
            # Free: everybody on the way moves on by one.
            while True:
                asker = come_from[wall]
                former = next((w for w in walls_of[asker] if claimed_by.get(w) == asker), None)
                claimed_by[wall] = asker
                if asker == cell:
                    return True
                assert former is not None, "whoever was asked to move on held a wall cell"
                wall = former
    return False
