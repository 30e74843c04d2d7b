"""Routes between stops: the shortest ways about corners, by visibility."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree
from shapely.geometry.base import BaseGeometry
from shapely.geometry.polygon import orient

__all__ = ["pieces", "tour"]

Point = tuple[float, float]

# Where the way is to be had with this much more room, it is driven with that: a driver cuts
# corners a little. Assumed.
_MORE_ROOM_M = (0.12, 0.06, 0.02)
# Of many nodes, each is joined only with so many near ones: quick, and hardly ever a longer way.
_FEW_NODES, _NEIGHBOURS = 50, 16


def pieces(area: BaseGeometry) -> list[shapely.Polygon]:
    """Return the polygons that an area consists of, the largest first."""
    parts = [part for part in shapely.get_parts(area) if isinstance(part, shapely.Polygon)]
    return sorted(parts, key=lambda part: (-part.area, part.bounds))


def tour(clear: shapely.Polygon, stops: Sequence[Point]) -> list[Point] | None:
    """Return the points of a drive by all stops, straight from each to the next within `clear`.

    Parameters
    ----------
    clear : Polygon
        Where the middle of the robot may be.
    stops : sequence of (x, y)
        Where to drive: from the first to whichever is then the nearest, and so on.

    Returns
    -------
    list of (x, y) or None
        The points of the drive, the first stop included; None if there is no such drive.
    """
    all_stops = shapely.multipoints(np.array(stops))
    for more_m in _MORE_ROOM_M:
        for area in pieces(clear.buffer(-more_m, quad_segs=4)):
            if not area.covers(all_stops):
                continue
            found = _tour(clear, area.simplify(min(more_m, 0.05)), stops)
            if found is not None:
                return found
    return None


def _tour(
    clear: shapely.Polygon, area: shapely.Polygon, stops: Sequence[Point]
) -> list[Point] | None:
    nodes = np.concatenate([np.array(stops), _corners(area)])
    first, second = _pairs(nodes)
    lines = shapely.linestrings(np.stack([nodes[first], nodes[second]], axis=1))
    shapely.prepare(clear)
    seen = shapely.covers(clear, lines)
    ways = np.zeros((len(nodes), len(nodes)))
    ways[first[seen], second[seen]] = np.hypot(*(nodes[second[seen]] - nodes[first[seen]]).T)
    distance, before = dijkstra(
        ways, directed=False, indices=range(len(stops)), return_predecessors=True
    )
    left, order = set(range(1, len(stops))), [0]
    while left:
        here = order[-1]
        nearest = min(left, key=lambda stop: (round(distance[here, stop], 6), stop))
        if not np.isfinite(distance[here, nearest]):
            return None
        left.remove(nearest)
        order.append(nearest)
    way = [0]
    for here, there in pairwise(order):
        way += _path(before[here], here, there)
    return [(float(x), float(y)) for x, y in nodes[way]]


def _pairs(nodes: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return which nodes may be joined: each with all others; of many, with those near."""
    first, second = np.triu_indices(len(nodes), k=1)
    if len(nodes) <= _FEW_NODES:
        return first, second
    near = cKDTree(nodes).query(nodes, k=_NEIGHBOURS)[1]
    joined = np.zeros((len(nodes), len(nodes)), dtype=bool)
    joined[np.arange(len(nodes))[:, None], near] = True
    chosen = (joined | joined.T)[first, second]
    return first[chosen], second[chosen]


def _path(before: NDArray[np.int32], here: int, there: int) -> list[int]:
    """Return the nodes after `here` on the way to `there`."""
    path = []
    while there != here:
        path.append(there)
        there = int(before[there])
    return path[::-1]


def _corners(area: shapely.Polygon) -> NDArray[np.float64]:
    """Return the corners about which a shortest way may bend, shape (n, 2)."""
    found = [np.empty((0, 2))]
    oriented = orient(area)
    for ring in (oriented.exterior, *oriented.interiors):
        points = shapely.get_coordinates(ring)[:-1]
        back, ahead = points - np.roll(points, 1, 0), np.roll(points, -1, 0) - points
        # The area lies on the left of its rings: it is bent about where they turn right.
        found.append(points[back[:, 0] * ahead[:, 1] - back[:, 1] * ahead[:, 0] < 0])
    return np.concatenate(found)
