"""Exact cones beside fans of 31 rays, many drives in one call, and how both grow.

Rates are by the clock; costs in microseconds are processor time, which other work on the machine
does not lengthen.
"""

import math
from time import perf_counter, process_time

import gymnasium
import numpy as np
from rays import hall

import worlds
from sim.envs.registration import IDS
from sim.runs.arguments import DriveArguments
from sim.runs.batch.drives import BatchDrive, simulate_batch
from sim.runs.plain import plain_log
from sim.sonar import presets as sonars
from sim.sonar.cone.sonar import FAN_RAYS

ROOMS = ("office", "clutter", "corridor", "thesis-exp1")
EXACT = sonars.preset("thesis")
NAVIGATE = next(name for name in IDS if "Navigate" in name)


def main() -> None:
    many_drives()
    vectors()
    faces()


def many_drives() -> None:
    """Print readings a second of many drives, beside one step by step, one after the other."""
    rooms = [worlds.load(name) for name in ROOMS]
    drives = [BatchDrive(rooms[k % 4], 1000, k, "wander") for k in range(16)]
    list(simulate_batch(drives[:4]))
    best, cost = math.inf, math.inf
    for _ in range(5):
        begin, used = perf_counter(), process_time()
        readings = sum(len(log) for _, log in simulate_batch(drives))
        best, cost = min(best, perf_counter() - begin), min(cost, process_time() - used)
    used = process_time()
    alone = len(
        plain_log(
            DriveArguments.of(
                rooms[0], scans=1000, seed=0, driver="wander", sonar=EXACT, engine="segments"
            )
        )
    )
    used = process_time() - used
    print(
        f"many drives: {readings / best:,.0f} readings/s (wanted 500,000 on two cores), "
        f"{cost / readings * 1e6:.2f} us a reading; step by step {used / alone * 1e6:.1f} us"
    )


def vectors() -> None:
    """Print steps a second of vectors of robots, exact and with fans."""
    for robots in (1, 16, 256):
        rates, costs = [], []
        for rays in (None, FAN_RAYS):
            env = gymnasium.make_vec(
                NAVIGATE, num_envs=robots, vectorization_mode="vector_entry_point", world="office",
                sonar=sonars.preset("aria").replace(rays=rays),
            )  # fmt: skip
            env.reset(seed=0)
            actions = [env.action_space.sample() for _ in range(max(2, 2560 // robots))]
            env.step(actions[0])
            best, cost = math.inf, math.inf
            for _ in range(5):
                begin, used = perf_counter(), process_time()
                for action in actions:
                    env.step(action)
                best, cost = min(best, perf_counter() - begin), min(cost, process_time() - used)
            env.close()
            rates.append(robots * len(actions) / best)
            costs.append(cost / robots / len(actions) * 1e6)
        print(
            f"vector of {robots}, Navigate: exact {rates[0]:,.0f} steps/s, {costs[0]:.0f} us a "
            f"step; {FAN_RAYS} rays {rates[1]:,.0f} steps/s, {costs[1]:.0f} us"
            + (" (wanted 4 times as many)" if robots == 256 else "")
        )


def faces() -> None:
    """Print what a reading costs in halls with more and more walls of four faces."""
    rng = np.random.default_rng(0)
    places, axes = rng.uniform(2, 18, (400, 2)), rng.uniform(-math.pi, math.pi, 400)
    for walls in (3, 25, 250, 2500):
        room, costs = hall(walls), []
        for rays in (None, FAN_RAYS):
            sonar, best = EXACT.replace(rays=rays), math.inf
            for _ in range(5):
                begin = process_time()
                sonar.listen(room.faces, room, places, axes, np.random.default_rng(0))
                best = min(best, process_time() - begin)
            costs.append(best / axes.size * 1e6)
        print(
            f"{4 * walls:,} faces: exact {costs[0]:.1f} us a reading, "
            f"{FAN_RAYS} rays one by one {costs[1]:.1f} us"
        )


if __name__ == "__main__":
    main()
