"""A drive of 1000 scans in thesis-exp1: times real time, and against a bare loop of PyBullet.

The bare loop makes the same calls in the same order, recorded from the drive: `stepSimulation`
and `rayTestBatch` with the same rays, and nothing else.
"""

from time import perf_counter

import numpy as np

import sim
import worlds
from sim.engines import bullet
from sim.engines.bullet import Bullet
from sim.engines.opening import open_engine
from sim.robot import amigobot
from sim.sonar import presets as sonars
from sim.sonar.cone.sonar import FAN_RAYS

SCANS = 1000


def main() -> None:
    world = worlds.load("thesis-exp1")
    batches = recorded_batches(world)
    steps = round(sonars.preset("thesis").scan_period_s / amigobot.PHYSICS_DT_S)

    def drive() -> None:
        sim.simulate(world, scans=SCANS, seed=0, driver="thesis", sonar="thesis")

    # In turn, so that both meet the machine in the same mood.
    whole, bare = [], []
    for _ in range(9):
        whole.append(timed(drive))
        bare.append(bare_loop(world, batches, steps))
    drive_s = SCANS * sonars.preset("thesis").scan_period_s
    ratios = np.array(whole) / np.array(bare)
    print(f"simulation: {drive_s / np.median(whole):.1f} x real time (target 30)")
    # The best of each is what the code costs; the pairs tell how noisy the machine is.
    print(
        f"simulation / bare loop of the same PyBullet calls: {min(whole) / min(bare):.2f} best to "
        f"best (target at most 1.40); pair by pair median {np.median(ratios):.2f}, "
        f"{ratios.min():.2f} to {ratios.max():.2f} in {len(ratios)} runs"
    )


def recorded_batches(world: worlds.World) -> list[list[tuple[np.ndarray, np.ndarray]]]:
    """Return the ray batches of each scan of the drive."""
    scans: list[list[tuple[np.ndarray, np.ndarray]]] = []
    cast = Bullet.cast

    def record(self, origins, directions, range_max_m):
        begin = np.full((len(origins), 3), amigobot.SONAR_HEIGHT_M)
        end = begin.copy()
        begin[:, :2] = origins
        end[:, :2] = origins + range_max_m[:, None] * directions
        if len(origins) == 8 * FAN_RAYS:
            scans.append([])
        scans[-1].append((begin, end))
        return cast(self, origins, directions, range_max_m)

    Bullet.cast = record
    try:
        sim.simulate(world, scans=SCANS, seed=0, driver="thesis", sonar="thesis")
    finally:
        Bullet.cast = cast
    return scans


def bare_loop(world: worlds.World, scans: list, steps: int) -> float:
    with open_engine("bullet", world) as engine:
        p, client = engine._p, engine._client
        engine.advance(amigobot.THESIS_LEFT_MPS, amigobot.THESIS_RIGHT_MPS, 1.0)
        begin = perf_counter()
        for batches in scans:
            for start, end in batches:
                p.rayTestBatch(
                    start, end, collisionFilterMask=bullet._WORLD_GROUP, physicsClientId=client
                )
            for _ in range(steps):
                p.stepSimulation(physicsClientId=client)
        return perf_counter() - begin


def timed(work) -> float:
    begin = perf_counter()
    work()
    return perf_counter() - begin


if __name__ == "__main__":
    main()
