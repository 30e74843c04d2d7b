"""Rays at the faces of a room: a hall with 40 walls against one with 1,000."""

from time import perf_counter

import numpy as np
import shapely

from worlds import MATERIALS, Pose, Solid, World

RAYS = 50_000
HALL_M = 20.0


def main() -> None:
    few, many = ray_ns(hall(40)), ray_ns(hall(1000))
    print(
        f"rays: {few:.0f} ns a ray with 40 walls, {many:.0f} ns with 1,000: {many / few:.2f} times"
    )


def hall(walls: int) -> World:
    """Return a hall with short walls strewn over it."""
    rng = np.random.default_rng(0)
    solids = []
    for k, (x, y) in enumerate(rng.uniform(0, HALL_M, (walls, 2))):
        outline = shapely.affinity.rotate(shapely.box(x, y, x + 0.5, y + 0.05), rng.uniform(0, 180))
        solids.append(Solid(f"wall {k}", MATERIALS["brick"], 2.0, outline))
    bounds_m = (0.0, 0.0, HALL_M, HALL_M)
    return World("hall", "", "", bounds_m, Pose(0, 0, 0), (), tuple(solids), {}, {})


def ray_ns(world: World) -> float:
    """Return the best time for a ray of a fan of at most 5 m, ns."""
    rng = np.random.default_rng(1)
    origins = np.repeat(rng.uniform(2, HALL_M - 2, (RAYS // 31, 2)), 31, axis=0)
    bearing = np.tile(np.linspace(-0.26, 0.26, 31), RAYS // 31)
    angle = np.repeat(rng.uniform(0, 2 * np.pi, RAYS // 31), 31) + bearing
    directions = np.column_stack([np.cos(angle), np.sin(angle)])
    times = []
    for _ in range(10):
        begin = perf_counter()
        world.faces.cast(origins, directions, 5.0)
        times.append(perf_counter() - begin)
    return min(times) / len(origins) * 1e9


if __name__ == "__main__":
    main()
