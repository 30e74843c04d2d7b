"""Single things on the bench, and what theory hears of each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import shapely
from shapely.affinity import rotate

from sim import PhysicalSonar
from sonarbed.reporting.bench import board, post, scene
from sonarbed.studies.acoustics.theory import GLASS, LOSS_DB, Locus, pillar_db
from worlds import Solid, World

__all__ = ["Target", "targets"]

_FAR_M = 30.0  # faces so long that their ends are out of hearing


@dataclass(frozen=True)
class Target:
    """A thing alone on the bench.

    Parameters
    ----------
    name : str
        For people.
    world : World
        It, before a sonar in (-distance, 0).
    distance_m : float
        Where the sonar stands.
    loci : tuple of Locus
        What theory hears of it; the first is the thing's own.
    """

    name: str
    world: World
    distance_m: float
    loci: tuple[Locus, ...]


def targets(sonar: PhysicalSonar) -> tuple[Target, ...]:
    """Return a plane, a concave corner, a convex edge and three pillars, all of glass."""
    things = [
        Target(
            "plane, 2 m",
            scene(board("pane", 2 * _FAR_M, material=GLASS)),
            2.0,
            (Locus("plane", 2.0, 0.0, LOSS_DB),),
        )
    ]
    # The faces of the corner pass the sonar at 45 degrees, nearer than their vertex.
    beside = [Locus("face", 2.0 * math.sin(math.pi / 4), s * math.pi / 4, LOSS_DB) for s in (1, -1)]
    things.append(
        Target(
            "concave corner, 2 m",
            scene(_turned("a", 0.0, -0.1, 135), _turned("b", 0.0, 0.1, -135)),
            2.0,
            (Locus("corner", 2.0, 0.0, 2 * LOSS_DB), *beside),
        )
    )
    edge_m = 1.0
    block = rotate(shapely.box(0, 0, _FAR_M, _FAR_M), -45, origin=(0, 0))
    things.append(
        Target(
            "convex edge, 1 m",
            scene(Solid("block", GLASS, 1.0, block)),
            edge_m,
            (Locus("edge", edge_m, 0.0, sonar.edge_db - 20 * math.log10(edge_m) + LOSS_DB),),
        )
    )
    for radius_m in (0.02, 0.05, 0.10):
        things.append(
            Target(
                f"pillar of {100 * radius_m:.0f} cm radius, 1 m",
                scene(post("post", radius_m, material=GLASS)),
                1.0,
                (Locus("pillar", 1.0, 0.0, pillar_db(radius_m, 1.0) + LOSS_DB),),
            )
        )
    return tuple(things)


def _turned(name: str, from_y: float, to_y: float, angle_deg: float) -> Solid:
    """Return a long wall that begins in the origin and goes off at an angle."""
    wall = shapely.box(0.0, min(from_y, to_y), _FAR_M, max(from_y, to_y))
    return Solid(name, GLASS, 1.0, rotate(wall, angle_deg, origin=(0, 0)))
