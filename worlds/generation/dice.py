"""`Dice`: everything random of a room, from the one stream of doubles that numpy keeps stable."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from itertools import accumulate
from typing import TypeVar

import numpy as np

__all__ = ["Dice"]

Item = TypeVar("Item")


class Dice:
    """Draws of many kinds from a generator's uniform doubles.

    Numpy promises the bits of a bit generator for all time, but not what its distributions make of
    them: a room must be the same on any machine and version, so they are made here.

    Parameters
    ----------
    rng : numpy.random.Generator
        Where the doubles come from.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng

    def uniform(self, low: float, high: float) -> float:
        """Return a number in [low, high)."""
        return low + (high - low) * float(self._rng.random())

    def whole(self, low: int, high: int) -> int:
        """Return a whole number in [low, high]."""
        return min(low + int((high - low + 1) * float(self._rng.random())), high)

    def chance(self, share: float) -> bool:
        """Return True with a probability."""
        return float(self._rng.random()) < share

    def sign(self) -> int:
        """Return 1 or -1."""
        return 1 if self.chance(0.5) else -1

    def one_of(self, items: Sequence[Item]) -> Item:
        """Return one of the items, each as likely as the others."""
        return items[self.whole(0, len(items) - 1)]

    def weighted(self, shares: Mapping[Item, float]) -> Item:
        """Return one of the items by their shares, which need not sum to 1."""
        sums = list(accumulate(shares.values()))
        at = bisect_right(sums, float(self._rng.random()) * sums[-1])
        # Rounding may leave it at the very end.
        return list(shares)[min(at, len(sums) - 1)]

    def shuffled(self, items: Sequence[Item]) -> list[Item]:
        """Return the items in a random order."""
        rest, order = list(items), []
        while rest:
            order.append(rest.pop(self.whole(0, len(rest) - 1)))
        return order
