"""Exact cones beside fans of 31 rays, and many drives in one call.

Rates are by the clock; costs in microseconds are processor time, which other work on the machine
does not lengthen. `growth.py` measures and draws how both grow.
"""

import math
from time import perf_counter, process_time
from typing import NamedTuple

import gymnasium

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
# Control steps of all robots in a run that is timed.
STEPS = 2560


class Speed(NamedTuple):
    """The best rate by the clock and the least processor time, microseconds, of some runs."""

    a_second: float
    cost_us: float


def main() -> None:
    many_drives()
    for robots in (1, 16, 256):
        exact, fan = vector(robots, None), vector(robots, FAN_RAYS)
        print(
            f"vector of {robots}, Navigate: exact {exact.a_second:,.0f} steps/s, "
            f"{exact.cost_us:.0f} us a step; {FAN_RAYS} rays {fan.a_second:,.0f} steps/s, "
            f"{fan.cost_us:.0f} us"
        )


def many_drives() -> None:
    """Print readings a second of many drives, beside one step by step, one after the other."""
    rooms = [worlds.load(name) for name in ROOMS]
    drives = [BatchDrive(rooms[k % 4], 1000, k, "wander") for k in range(16)]
    list(simulate_batch(drives[:4]))
    readings = sum(drive.scans for drive in drives) * len(EXACT.ring)
    best = speed_of(lambda: list(simulate_batch(drives)), readings)
    asked = DriveArguments.of(
        rooms[0], scans=1000, seed=0, driver="wander", sonar=EXACT, engine="segments"
    )
    alone = speed_of(
        lambda: plain_log(asked),
        1000 * len(EXACT.ring),
        runs=1,
    )
    print(
        f"many drives: {best.a_second:,.0f} readings/s (wanted 500,000 on two cores), "
        f"{best.cost_us:.2f} us a reading; step by step {alone.cost_us:.1f} us"
    )


def vector(robots: int, rays: int | None) -> Speed:
    """Return the speed of a vector of robots on Navigate, a step of a robot, by number of rays."""
    env = gymnasium.make_vec(
        NAVIGATE, num_envs=robots, vectorization_mode="vector_entry_point", world="office",
        sonar=sonars.preset("aria").replace(rays=rays),
    )  # fmt: skip
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(max(2, STEPS // robots))]
    env.step(actions[0])
    speed = speed_of(lambda: [env.step(action) for action in actions], robots * len(actions))
    env.close()
    return speed


def speed_of(work, count: int, runs: int = 5) -> Speed:
    """Return the speed of a work that is to be done so many times."""
    best, cost = math.inf, math.inf
    for _ in range(runs):
        begin, used = perf_counter(), process_time()
        work()
        best, cost = min(best, perf_counter() - begin), min(cost, process_time() - used)
    return Speed(count / best, cost / count * 1e6)


if __name__ == "__main__":
    main()
