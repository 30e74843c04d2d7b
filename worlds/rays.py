"""`RayHits`: what a bundle of rays met. Whatever can cast rays answers with this."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["RayHits"]


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """The first surface that each of n rays met.

    Parameters
    ----------
    distance_m : ndarray, shape (n,)
        Length of the ray up to the surface, metres; ``+inf`` where none was met.
    normal_xy : ndarray, shape (n, 2)
        Unit normal of the surface, on the side of the origin; zeros where none was met.
    surface : ndarray of int32, shape (n,)
        Index of the surface; -1 where none was met.
    """

    distance_m: NDArray[np.float64]
    normal_xy: NDArray[np.float64]
    surface: NDArray[np.int32]
