"""The free part of a room's plane: how far points are from its surfaces, and its corners."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarmap.filters.hsr import NO_ECHO_M

__all__ = ["NEAR_M", "FreeSpace", "PointShares", "plotted_points", "score_points"]

# A point this near to a surface is taken for a point of it, as in the scores of readings.
NEAR_M = 0.1
# A pillar's outline turns by less from side to side: its vertices are no corners.
_LEAST_TURN_RAD = math.radians(20)
_TOUCHING_M = 1e-6


@dataclass(frozen=True, slots=True)
class FreeSpace:
    """Where the robot of a room could be.

    Parameters
    ----------
    polygon : shapely.Polygon
        The part of the plane without solids that holds the robot's start.
    surfaces : shapely.Geometry
        Its border, but for where only the room's bounds end it.
    """

    polygon: shapely.Polygon
    surfaces: shapely.Geometry

    @classmethod
    def of(cls, world: worlds.World) -> FreeSpace:
        """Return the free space of a room."""
        solids = shapely.union_all([solid.outline for solid in world.solids])
        bounds = shapely.box(*world.bounds_m)
        start = shapely.Point(world.start.x_m, world.start.y_m)
        parts = shapely.get_parts(shapely.difference(bounds, solids))
        polygon = next(part for part in parts if part.contains(start))
        return cls(polygon, shapely.difference(polygon.boundary, bounds.boundary))

    def distance_m(self, xy_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the distance of points to the nearest surface, metres; (n, 2) to (n,)."""
        shapely.prepare(self.surfaces)
        distance: NDArray[np.float64] = shapely.distance(self.surfaces, shapely.points(xy_m))
        return distance

    @property
    def corners_xy_m(self) -> NDArray[np.float64]:
        """Corners of the surfaces, convex and concave, metres, shape (n, 2)."""
        corners = [np.empty((0, 2))]
        for ring in (self.polygon.exterior, *self.polygon.interiors):
            # Points within a side, where walls abut, are left out.
            xy = np.array(ring.simplify(1e-6).coords)[:-1]
            ahead = np.roll(xy, -1, axis=0) - xy
            heading = np.arctan2(ahead[:, 1], ahead[:, 0])
            turn = np.angle(np.exp(1j * (heading - np.roll(heading, 1))))
            corners.append(xy[np.abs(turn) > _LEAST_TURN_RAD])
        found = np.vstack(corners)
        # The corners of the room's bounds are none.
        return found[self.distance_m(found) < _TOUCHING_M]


@dataclass(frozen=True, slots=True)
class PointShares:
    """How well plotted data points show the surfaces of a room.

    Parameters
    ----------
    near : float
        Share of the points within 0.1 m of a surface.
    beyond : float
        Share of the points that lie farther than that behind a surface, outside of the room.
    shown : float
        Share of the observable occupied cells with a point within 0.1 m of the centre.
    """

    near: float
    beyond: float
    shown: float

    @property
    def f1(self) -> float:
        """Harmonic mean of both; 0 when both are 0."""
        total = self.near + self.shown
        return 2 * self.near * self.shown / total if total else 0.0


def plotted_points(log: sm.SonarLog) -> NDArray[np.float64]:
    """Return the data points as the thesis plots them, metres, shape (n, 2).

    No echo is plotted at 5.000 m, which is what its robot reports; too close is left out.
    """
    reach_m = np.where(np.isposinf(log.range_m), NO_ECHO_M, log.range_m)
    axis = log.axis_rad
    points: NDArray[np.float64] = log.sensor_xy_m + reach_m[:, None] * np.column_stack(
        [np.cos(axis), np.sin(axis)]
    )
    return points[np.isfinite(reach_m)]


def score_points(
    points_m: NDArray[np.float64], space: FreeSpace, surface_cells_m: NDArray[np.float64]
) -> PointShares:
    """Return how well points show the surfaces.

    Parameters
    ----------
    points_m : ndarray, shape (n, 2)
        The data points.
    space : FreeSpace
        The room.
    surface_cells_m : ndarray, shape (m, 2)
        Centres of the cells that should be shown.
    """
    from scipy.spatial import KDTree  # loaded only when points are judged

    near = space.distance_m(points_m) <= NEAR_M
    shapely.prepare(space.polygon)
    beyond = ~near & ~shapely.contains_xy(space.polygon, points_m)
    away_m, _ = KDTree(points_m).query(surface_cells_m, distance_upper_bound=NEAR_M)
    shown = np.asarray(away_m) <= NEAR_M
    return PointShares(float(near.mean()), float(beyond.mean()), float(shown.mean()))
