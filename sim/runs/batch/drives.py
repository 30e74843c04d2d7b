"""`simulate_batch`: whole drives on `segments`, each compiled, on all cores."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from itertools import islice
from threading import Event

from sim.robot.drivers import Driver
from sim.robot.odometry import OdometryModel
from sim.runs.arguments import DriveArguments
from sim.runs.compiled.drive import compiled_log, is_compiled
from sim.sonar.protocol import Sonar
from sonarmap import InputError, SonarLog
from sonarmap.cores import usable_cores
from worlds import Pose, World

__all__ = ["BatchDrive", "is_compiled", "simulate_batch"]


@dataclass(frozen=True, eq=False)
class BatchDrive:
    """One drive of a batch: the arguments of `sim.simulate` on the engine `segments`.

    Parameters
    ----------
    world, scans, seed
        See `sim.simulate`.
    driver : str or Driver
        A name, or a driver that has numbers for compiled code (``compiled()``).
    sonar : str or Sonar
        A name, or a sonar that drives compiled: see `is_compiled`.
    odometry : OdometryModel, optional
        Errors of the odometry, by default the AmigoBot's.
    start : Pose, optional
        Where the robot begins; by default the world's start.
    """

    world: World
    scans: int
    seed: int
    driver: str | Driver = "auto"
    sonar: str | Sonar = "thesis"
    odometry: OdometryModel | None = None
    start: Pose | None = None


def simulate_batch(
    drives: Iterable[BatchDrive], *, workers: int | None = None
) -> Iterator[tuple[int, SonarLog]]:
    """Yield the number and the log of each drive as it ends.

    Each log is that of `sim.simulate` with the same arguments on the engine `segments`, to the
    last bit. Few logs are in memory at a time: drives begin as logs are taken.

    Parameters
    ----------
    drives : iterable of BatchDrive
        May be a generator.
    workers : int, optional
        Threads, >= 1; by default one a core that this process may use. Compiled code needs no
        processes.

    Raises
    ------
    InputError
        If a drive cannot be compiled, see `is_compiled`, or an argument breaks its rule.
    """
    threads = usable_cores() if workers is None else workers
    if threads < 1:
        raise InputError(f"workers must be >= 1, got {workers!r}")
    if threads == 1:
        yield from enumerate(_simulate(each, Event()) for each in drives)
        return
    todo, stopped = enumerate(drives), Event()
    with ThreadPoolExecutor(threads) as pool:
        running: dict[Future[SonarLog], int] = {}
        done: deque[Future[SonarLog]] = deque()
        try:
            while True:
                # One waits for each that works.
                for index, each in islice(todo, 2 * threads - len(running) - len(done)):
                    running[pool.submit(_simulate, each, stopped)] = index
                if not running:
                    return
                done.extend(wait(running, return_when=FIRST_COMPLETED).done)
                while done:
                    future = done.popleft()
                    yield running.pop(future), future.result()
        finally:
            stopped.set()
            for future in running:
                future.cancel()


def _simulate(wanted: BatchDrive, stopped: Event) -> SonarLog:
    """Return the log of one drive."""
    asked = DriveArguments.of(
        wanted.world,
        scans=wanted.scans,
        seed=wanted.seed,
        driver=wanted.driver,
        sonar=wanted.sonar,
        engine="segments",
        odometry=wanted.odometry,
    )

    def stop_if_told(scan: int) -> None:
        if stopped.is_set():
            raise CancelledError

    return compiled_log(asked, start=wanted.start, on_scan=stop_if_told)
