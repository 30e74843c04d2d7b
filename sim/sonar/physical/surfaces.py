"""What surfaces are like, as the compiled steps of the physical sonar take it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.sonar.physical import columns as t
from worlds import World

__all__ = ["surface_table"]


def surface_table(world: World) -> NDArray[np.float64]:
    """Return what the surfaces are like; surface -1, none, takes the last row."""
    table = np.zeros((len(world.roughness_m) + 1, t.SURFACE_COLUMNS))
    table[:-1, t.SURFACE_RADIUS] = world.radius_m
    table[:-1, t.SURFACE_MIRROR] = 20 * np.log10(np.maximum(world.reflectivity, 1e-10))
    table[:-1, t.SURFACE_FLOOR] = world.diffuse_floor_db
    table[:-1, t.SURFACE_ROUGHNESS] = world.roughness_m
    return table
