"""What the physical sonar costs: against the simple cone, and against the time that it simulates.

Both sonars stand at the same places of a drive in `office`, with the same ring, fire all at once
and follow one bounce; the shipped preset, which fires in turn, is then driven as it is.
"""

import math
from time import perf_counter

import numpy as np

import sim
import worlds
from sim import AllAtOnce
from sim.engines.bullet import Bullet
from sim.sonar.presets import preset

SCANS, STOPS = 200, 20


def main() -> None:
    world = worlds.load("office")
    cone = preset("thesis").replace(max_bounces=1)
    physical = preset("physical")
    alike = physical.replace(ring=cone.ring, firing=AllAtOnce(cone.scan_period_s), max_bounces=1)
    poses = driven(world)
    listening = np.array([listen(world, (cone, alike), poses) for _ in range(5)])
    ratios = listening[:, 1] / listening[:, 0]
    print(
        f"physical / thesis, listening only: {np.median(ratios):.2f}, {ratios.min():.2f} to "
        f"{ratios.max():.2f} in 5 runs (target at most 2.50)"
    )
    whole = np.array([[drive(world, sonar) for sonar in (cone, alike)] for _ in range(5)])
    ratios = whole[:, 1] / whole[:, 0]
    print(
        f"physical / thesis, a whole scan with its driving: {np.median(ratios):.2f}, "
        f"{ratios.min():.2f} to {ratios.max():.2f} in 5 runs (target at most 2.50)"
    )
    drive_s = SCANS * physical.firing.period_s
    wall_s = [drive(world, physical) for _ in range(3)]
    print(f"physical, in turn: {drive_s / np.median(wall_s):.1f} x real time (target 20)")


def driven(world: worlds.World) -> list[worlds.Pose]:
    """Return places along the route."""
    truth = sim.simulate(world, scans=STOPS * 20, seed=0, driver="route", sonar="aria").truth
    rows = slice(None, None, 8 * 20)
    return [
        worlds.Pose(*pose)
        for pose in zip(truth.x_m[rows], truth.y_m[rows], truth.heading_rad[rows], strict=True)
    ]


def listen(
    world: worlds.World, sonars: tuple[sim.Sonar, ...], poses: list[worlds.Pose]
) -> list[float]:
    """Return each sonar's time of a scan at all of the places, the best of twenty a place.

    The sonars take turns, so that what else the machine does meets them alike.
    """
    ring = sonars[0].ring
    best_s = np.full((len(poses), len(sonars)), math.inf)
    with Bullet(world, world.start) as engine:
        arrays = [sonar.array(engine, world, np.random.default_rng(0)) for sonar in sonars]
        for stop, pose in enumerate(poses):
            places = ring.sensor_xy_m(slice(None), pose.x_m, pose.y_m, pose.heading_rad)
            axes = pose.heading_rad + ring.heading_rad
            for again in range(20):
                for k, array in enumerate(arrays):
                    begin = perf_counter()
                    array.fire(20.0 * stop + again, tuple(range(8)), places, axes)
                    array.detect()
                    best_s[stop, k] = min(best_s[stop, k], perf_counter() - begin)
    return best_s.sum(axis=0).tolist()


def drive(world: worlds.World, sonar: sim.Sonar) -> float:
    begin = perf_counter()
    sim.simulate(world, scans=SCANS, seed=0, driver="route", sonar=sonar)
    return perf_counter() - begin


if __name__ == "__main__":
    main()
