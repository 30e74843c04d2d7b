"""A sonar on the bench: one transducer at chosen places before things, without a robot."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from sim.sonar.protocol import Echoes, Sonar
from worlds import MATERIALS, Material, Pose, Solid, World

__all__ = ["board", "echoes", "post", "readings", "scene"]

# Of what stands on the bench only the height matters: above the sonar's.
_HEIGHT_M = 1.0


def board(
    name: str, width_m: float, *, material: str | Material, thickness_m: float = 0.02
) -> Solid:
    """Return a flat board whose face, on x = 0 and about the origin, looks to smaller x."""
    outline = shapely.box(0.0, -width_m / 2, thickness_m, width_m / 2)
    return Solid(name, _material(material), _HEIGHT_M, outline)


def post(name: str, radius_m: float, *, material: str | Material) -> Solid:
    """Return a round post that touches x = 0 in the origin from the side of larger x."""
    outline = shapely.Point(radius_m, 0.0).buffer(radius_m, quad_segs=32)
    return Solid(name, _material(material), _HEIGHT_M, outline, (radius_m, 0.0, radius_m))


def _material(material: str | Material) -> Material:
    return MATERIALS[material] if isinstance(material, str) else material


def scene(*solids: Solid) -> World:
    """Return a world of nothing but these solids."""
    return World(
        name="bench",
        title="Things on a bench",
        source="made by a study",
        bounds_m=(-5.0, -5.0, 5.0, 5.0),
        start=Pose(-4.0, 0.0, 0.0),
        route_m=(),
        solids=solids,
        notes={},
        parameters={},
    )


def readings(
    sonar: Sonar,
    world: World,
    xy_m: NDArray[np.float64],
    axis_rad: ArrayLike,
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Return what a sonar reads at each of n places, metres; +inf no echo, -inf too close.

    The parameters are those of `echoes`.
    """
    return echoes(sonar, world, xy_m, axis_rad, rng).range_m


def echoes(
    sonar: Sonar,
    world: World,
    xy_m: NDArray[np.float64],
    axis_rad: ArrayLike,
    rng: np.random.Generator,
) -> Echoes:
    """Return what a sonar hears at each of n places, with the truth about it.

    The exact faces of the world take the place of the physics engine: nothing moves here.

    Parameters
    ----------
    sonar : Sonar
        Whose acoustics.
    world : World
        What stands there.
    xy_m : ndarray, shape (n, 2)
        Places of the transducer, metres.
    axis_rad : float or array_like, shape (n,)
        Directions of its axis, radians.
    rng : numpy.random.Generator
        The only source of noise.
    """
    # All places at once are as many transducers that do not hear each other.
    axes = np.broadcast_to(np.asarray(axis_rad, float), len(xy_m))
    return sonar.listen(world.faces, world, xy_m, axes, rng)
