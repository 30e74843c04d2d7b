"""Truth of a room and what a log could have observed of it: seconds, and cells a second."""

from time import perf_counter

import sim
import worlds


def main() -> None:
    world = worlds.load("office")
    log = sim.simulate(world, scans=500, seed=0, driver="route", sonar="thesis")
    for resolution_m in (0.05, 0.01):
        truth, made_s = timed(lambda size=resolution_m: worlds.truth(world, resolution_m=size))
        _, seen_s = timed(lambda grid=truth: grid.observable(log))
        cells = truth.state.size
        print(
            f"office, {resolution_m * 100:g} cm cells: truth {made_s:.2f} s "
            f"({cells / made_s:,.0f} cells/s), observable by {len(log)} readings {seen_s:.2f} s"
        )


def timed(work):
    work()  # compile
    begin = perf_counter()
    result = work()
    return result, perf_counter() - begin


if __name__ == "__main__":
    main()
