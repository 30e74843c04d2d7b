"""Where a reading was taken: at a corner, an oblique wall, an opening, or a plain wall."""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.studies.thesis.free_space import FreeSpace

__all__ = ["Place", "places_of"]

CORNER_M = 0.3
OBLIQUE_RAD = math.radians(30)
# Between neighbouring rays, a degree apart, a wall met within 3 m and up to 80 degrees off its
# normal recedes by less: a larger step is an edge with a space behind it.
_EDGE_M = 0.3
_STEP_RAD = math.radians(1)


class Place(IntEnum):
    """What stands before a sonar; a reading counts at the first that holds."""

    OPENING = 0
    """Nothing in range on the axis, or the axis passes an edge to what is 0.3 m farther."""
    CORNER = 1
    """What the axis meets, or the nearest of the cone, is within 0.3 m of a corner."""
    OBLIQUE = 2
    """The axis meets its surface at more than 30 degrees from the normal."""
    PLAIN = 3
    """Anything else: a wall met squarely."""

    @property
    def label(self) -> str:
        """How tables call it."""
        return ("opening", "corner", "oblique wall", "plain wall")[self]


def places_of(log: sm.SonarLog, world: worlds.World) -> NDArray[np.int8]:
    """Return the `Place` of every reading, shape (n,).

    Parameters
    ----------
    log : SonarLog
        A log with truth; only the true poses and the ring are used.
    world : World
        The room it was recorded in.
    """
    seen_from = log.at_true_poses()
    sensor_m, axis = seen_from.sensor_xy_m, seen_from.axis_rad
    ring = log.ring
    aside = round(ring.half_angle_rad / _STEP_RAD)
    bearings = np.linspace(-ring.half_angle_rad, ring.half_angle_rad, 2 * aside + 1)
    angle = axis[:, None] + bearings
    directions = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    origins = np.broadcast_to(sensor_m[:, None, :], directions.shape)
    hits = world.faces.cast(origins.reshape(-1, 2), directions.reshape(-1, 2), ring.range_max_m)
    distance_m = hits.distance_m.reshape(angle.shape)
    normal = hits.normal_xy.reshape(directions.shape)[:, aside]

    on_axis_m = distance_m[:, aside]
    rows, nearest = np.arange(len(log)), distance_m.argmin(axis=1)
    nearest_m = distance_m[rows, nearest]
    # An edge at the end of the range, where nothing is heard any more, counts as a wall.
    within_m = np.minimum(distance_m, ring.range_max_m)
    edge = np.abs(np.diff(within_m, axis=1)).max(axis=1) > _EDGE_M
    opening = np.isinf(on_axis_m) | (edge & (np.minimum(on_axis_m, 99) - nearest_m > _EDGE_M))

    corners_m = FreeSpace.of(world).corners_xy_m
    at_corner = np.zeros(len(log), bool)
    for ray in (np.full(len(log), aside), nearest):
        met_m = sensor_m + within_m[rows, ray, None] * directions[rows, ray]
        gaps_m = np.linalg.norm(met_m[:, None] - corners_m, axis=2)
        at_corner |= gaps_m.min(axis=1, initial=math.inf) <= CORNER_M

    cosine = -(normal * directions[:, aside]).sum(axis=1)
    oblique = np.arccos(np.clip(cosine, -1, 1)) > OBLIQUE_RAD
    return np.select(
        [opening, at_corner, oblique], [Place.OPENING, Place.CORNER, Place.OBLIQUE], Place.PLAIN
    ).astype(np.int8)
