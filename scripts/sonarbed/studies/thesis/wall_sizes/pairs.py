"""The sizes of estimated walls that are tried: pairs of the smallest and the largest wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sonarbed.studies.thesis.experiments import EXPERIMENTS, WallPair

__all__ = ["TABLE_6_1", "in_table_6_1", "pair_name", "wall_pairs"]

# Table 6.1: for each minWallSize, from which to which maxWallSize the map looks right.
TABLE_6_1 = {
    10: (160, 200),
    20: (110, 190),
    30: (50, 110),
    40: (50, 100),
    50: (60, 90),
    60: (70, 80),
    70: (80, 80),
}


def wall_pairs(*, quick: bool) -> tuple[WallPair, ...]:
    """Return the pairs of a sweep: the thesis's ranges in steps of 10 mm, or a coarse choice."""
    smallest = (10, 20, 30, 50, 70) if quick else tuple(range(10, 71, 10))
    largest = (20, 30, 50, 80, 120, 160, 200, 250) if quick else tuple(range(20, 251, 10))
    pairs = {(low, high) for low in smallest for high in largest if high >= low}
    # Whatever the sweep, the pairs that the thesis shows are in it.
    for experiment in EXPERIMENTS:
        pairs |= {experiment.thesis, *experiment.shown}
    return tuple(sorted(pairs))


def pair_name(pair: WallPair) -> str:
    """Return a pair as the thesis writes it: ``20-120 mm``."""
    return f"{pair[0]}-{pair[1]} mm"


def in_table_6_1(pairs: tuple[WallPair, ...]) -> NDArray[np.bool_]:
    """Return which pairs lie within the region of table 6.1."""
    return np.array([TABLE_6_1[low][0] <= high <= TABLE_6_1[low][1] for low, high in pairs])
