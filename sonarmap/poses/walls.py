"""Walls as lines that echoes agree on.

A smooth wall answers from the foot of the perpendicular, wherever that lies in the cone. With n the
direction of that perpendicular, s the place of the sonar and r its reading, n.s + r is the same
number for every echo of the wall: its distance from the origin (Leonard and Durrant-Whyte 1992,
regions of constant depth). A mirror image of a wall behaves like a wall, and a curved one like
several.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

__all__ = ["Echoes", "Walls", "attributed", "find_walls"]

_BINS = 120
"""Directions in which walls are looked for: every 3 degrees."""
_MOST_WALLS = 60
# Echoes of one wall crowd along it: this length of it, metres, needs so many of them (assumed).
_PIECE_M, _LEAST_ECHOES = 0.25, 4.0
# Echoes that a wall needs to be looked at at all (assumed).
_LEAST_SUPPORT = 10.0
# Nearer than this to a wall no second one is looked for: what drift makes of one wall is not two.
_APART_M = 0.1
_ROUNDS = 3
_NEIGHBOURS = np.array([0.5, 1.0, 0.5])

# Of each wall: direction of its perpendicular in radians, distance from the origin in metres.
Walls = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Echoes:
    """Echoes as seen from some poses.

    Parameters
    ----------
    place_m : ndarray, shape (n, 2)
        Place of the sonar, metres.
    axis_rad : ndarray, shape (n,)
        Its acoustic axis.
    range_m : ndarray, shape (n,)
        The reading.
    weight : ndarray, shape (n,)
        How much each counts, in [0, 1].
    half_angle_rad : float
        Half of the cone.
    """

    place_m: NDArray[np.float64]
    axis_rad: NDArray[np.float64]
    range_m: NDArray[np.float64]
    weight: NDArray[np.float64]
    half_angle_rad: float

    def in_cone(self, direction_rad: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return which directions (m,) lie in which cones, shape (n, m)."""
        off = (direction_rad - self.axis_rad[:, None] + math.pi) % math.tau - math.pi
        inside: NDArray[np.bool_] = np.abs(off) <= self.half_angle_rad
        return inside

    def distance_m(self, direction_rad: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far from the origin a wall across each direction would be, shape (n, m)."""
        along_m = self.place_m @ np.array([np.cos(direction_rad), np.sin(direction_rad)])
        distance: NDArray[np.float64] = along_m + self.range_m[:, None]
        return distance


def find_walls(echoes: Echoes, sigma_m: float) -> Walls:
    """Return lines that many echoes agree on, the best supported first, shape (walls, 2).

    A Hough transform: each echo votes for the walls that its cone may have met. The wall with the
    most votes takes its echoes' votes with it, and so on.
    """
    directions = np.linspace(0.0, math.tau, _BINS, endpoint=False)
    bin_m = sigma_m / 2
    possible, distance_m = echoes.in_cone(directions), echoes.distance_m(directions)
    echo, direction = np.nonzero(possible)
    if not echo.size:
        return np.empty((0, 2))
    reach = math.ceil(2 * sigma_m / bin_m)
    blur = np.exp(-0.5 * (np.arange(-reach, reach + 1) * bin_m / sigma_m) ** 2)
    lowest_m = distance_m[possible].min() - (reach + 1) * bin_m
    cell = ((distance_m[possible] - lowest_m) / bin_m).astype(np.intp)
    shape = (_BINS, int(cell.max()) + reach + 2)
    cell += direction * shape[1]

    def votes(of: NDArray[np.bool_]) -> NDArray[np.float64]:
        weight = echoes.weight[echo[of]]
        counted = np.bincount(cell[of], weights=weight, minlength=math.prod(shape))
        return _blurred(counted.reshape(shape), blur)

    support, free = votes(np.ones(echo.size, bool)), np.ones(len(possible), bool)
    walls: list[tuple[float, float]] = []
    while len(walls) < _MOST_WALLS:
        best, at = np.unravel_index(np.argmax(support), shape)
        if support[best, at] < _LEAST_SUPPORT:
            break
        wall_m = lowest_m + (at + 0.5) * bin_m
        near = np.abs(distance_m[:, best] - wall_m) < max(2 * sigma_m, _APART_M)
        own = free & possible[:, best] & near
        if not own.any():  # what is left there are blurred remains of others
            support[best, at] = 0.0
            continue
        walls.append((float(directions[best]), wall_m))
        free &= ~own
        support -= votes(own[echo])
    return np.array(walls).reshape(-1, 2)


def attributed(
    echoes: Echoes, walls: Walls, sigma_m: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return echoes that a wall explains, and the wall of each, as two arrays of indices.

    Walls compete for echoes, and a wall that has many echoes where the foot lies wins: an echo that
    agrees with the continuation of a wall elsewhere, where nothing else does, does so by chance.
    """
    residual_m = echoes.distance_m(walls[:, 0]) - walls[:, 1]
    explains = echoes.in_cone(walls[:, 0]) & (np.abs(residual_m) < 3 * sigma_m)
    echo, wall = np.nonzero(explains)
    if not echo.size:
        return echo, wall
    normal_rad = walls[wall, 0]
    along_m = echoes.place_m[echo, 1] * np.cos(normal_rad)
    along_m -= echoes.place_m[echo, 0] * np.sin(normal_rad)
    piece = np.floor(along_m / _PIECE_M).astype(np.intp)
    piece -= piece.min() - 1
    shape = (len(walls), int(piece.max()) + 2)
    fit = np.exp(-0.5 * (residual_m[echo, wall] / sigma_m) ** 2)
    crowd = np.ones(echo.size)
    for _ in range(_ROUNDS):
        all_walls = np.bincount(echo, weights=fit * crowd, minlength=len(explains))
        share = echoes.weight[echo] * fit * crowd / np.maximum(all_walls[echo], 1e-12)
        counted = np.bincount(wall * shape[1] + piece, weights=share, minlength=math.prod(shape))
        crowd = _blurred(counted.reshape(shape), _NEIGHBOURS)[wall, piece]
    score = np.zeros(explains.shape)
    score[echo, wall] = np.where(crowd >= _LEAST_ECHOES, fit * crowd, 0.0)
    best = np.argmax(score, axis=1)
    rows = np.flatnonzero(score[np.arange(len(best)), best] > 0)
    return rows, best[rows]


def _blurred(counted: NDArray[Any], by: NDArray[np.float64]) -> NDArray[np.float64]:
    blurred: NDArray[np.float64] = convolve1d(counted, by, axis=1, mode="constant")
    return blurred
