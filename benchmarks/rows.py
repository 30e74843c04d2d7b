"""What `before.py` measures, in words that an earlier commit of the project understands, too.

Not a benchmark by itself: `before.py` starts it as a process for each of the two, writes names of
`ROWS` to it and reads the rates, one a line. It imports of the project only what both have.
"""

import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context
from time import perf_counter

Measure = Callable[[], float]
DRIVES, SCANS = 8, 500
ROBOTS, STEPS = 256, 20
ALONE = 1000


def simulate_one(stack: ExitStack) -> Measure:
    """Readings a second of one drive of a simple cone, by `simulate`."""
    return _rate(lambda: _drive("thesis-exp1", "wander", "thesis", 0, SCANS))


def many_simple(stack: ExitStack) -> Measure:
    """Readings a second of many drives of a simple cone on two cores."""
    rooms = ("office", "clutter", "corridor", "thesis-exp1")
    return drives_of(
        stack, [(rooms[k % 4], "wander", "thesis", k, 2 * SCANS) for k in range(2 * DRIVES)], 2
    )


def physical_one(stack: ExitStack) -> Measure:
    """Readings a second of drives of the physical sonar, one after the other."""
    return drives_of(
        stack, [("office", "route", "physical", k, SCANS // 2) for k in range(DRIVES // 2)], 1
    )


def physical_two(stack: ExitStack) -> Measure:
    """Readings a second of drives of the physical sonar on two cores."""
    return drives_of(
        stack, [("office", "route", "physical", k, SCANS // 2) for k in range(DRIVES)], 2
    )


def vector(stack: ExitStack) -> Measure:
    """Steps a second of a vector of 256 robots on Navigate."""
    import gymnasium

    env = gymnasium.make_vec(
        _navigate(), num_envs=ROBOTS, vectorization_mode="vector_entry_point", world="office"
    )
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(STEPS)]

    def steps() -> int:
        for action in actions:
            env.step(action)
        return ROBOTS * STEPS

    return _rate(steps)


def alone(stack: ExitStack) -> Measure:
    """Steps a second of one environment on Navigate."""
    import gymnasium

    env = gymnasium.make(_navigate(), world="office")
    env.reset(seed=0)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(ALONE)]

    def steps() -> int:
        for action in actions:
            *_, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()
        return ALONE

    return _rate(steps)


ROWS: dict[str, Callable[[ExitStack], Measure]] = {
    each.__name__: each
    for each in (simulate_one, many_simple, physical_one, physical_two, vector, alone)
}


def _rate(work: Callable[[], int]) -> Measure:
    """Return what measures how much of a work is done in a second; it has run once before."""
    work()

    def measure() -> float:
        begin = perf_counter()
        done = work()
        return done / (perf_counter() - begin)

    return measure


def drives_of(
    stack: ExitStack, drives: list[tuple[str, str, str, int, int]], workers: int
) -> Measure:
    """Return what measures drives: compiled if these can be, else by `simulate` in processes."""
    if _compiled(drives[0]):
        import worlds
        from sim.runs.batch.drives import BatchDrive, simulate_batch

        rooms = {room: worlds.load(room) for room, *_ in drives}
        asked = [
            BatchDrive(rooms[room], scans, seed, driver, sonar)
            for room, driver, sonar, seed, scans in drives
        ]
        return _rate(lambda: sum(len(log) for _, log in simulate_batch(asked, workers=workers)))
    if workers == 1:
        return _rate(lambda: sum(_drive(*each) for each in drives))
    # Begun anew, not forked: numba's threads do not outlive a fork.
    pool = stack.enter_context(ProcessPoolExecutor(workers, mp_context=get_context("spawn")))
    return _rate(lambda: sum(pool.map(_drive, *zip(*drives, strict=True))))


def _drive(room: str, driver: str, sonar: str, seed: int, scans: int) -> int:
    """Return how many readings a drive has."""
    import sim
    import worlds

    return len(
        sim.simulate(
            worlds.load(room), scans=scans, seed=seed, driver=driver, sonar=sonar, engine="segments"
        )
    )


def _compiled(drive: tuple[str, str, str, int, int]) -> bool:
    try:
        from sim.runs.batch.drives import is_compiled
    except ImportError:  # the earlier commit
        return False
    import worlds
    from sim.robot import drivers
    from sim.sonar.presets import preset

    room, driver, sonar, _, _ = drive
    return is_compiled(drivers.driver(driver, worlds.load(room)), preset(sonar))


def _navigate() -> str:
    """Return the name of Navigate: its version differs."""
    from sim.envs.registration import IDS

    return next(name for name in IDS if "Navigate" in name)


def main() -> None:
    prepared: dict[str, Measure] = {}
    with ExitStack() as stack:
        for line in sys.stdin:
            name = line.strip()
            if name not in prepared:
                prepared[name] = ROWS[name](stack)
            print(prepared[name](), flush=True)


if __name__ == "__main__":
    main()
