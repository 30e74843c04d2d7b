"""`simulate_batch`: whole drives of simple cones on `segments`, each in one compiled call."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from functools import lru_cache
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.engines.opening import open_engine
from sim.engines.segments import Segments
from sim.robot import drivers
from sim.robot.clock import physics_steps
from sim.robot.compiled import CompiledDriver
from sim.robot.drivers import Driver
from sim.robot.odometry import OdometryModel, drawn_errors
from sim.runs.batch.kernel import Recorded, run
from sim.runs.simulation import _described
from sim.sonar import presets as sonars
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.firing import AllAtOnce, Slot, check_firing, pings
from sim.sonar.protocol import Sonar
from sonarmap import InputError, LogTruth, SonarLog
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
        A name, or an exact simple cone: ``compiled_cone()`` has one without rays.
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


def is_compiled(driver: Driver, sonar: Sonar) -> bool:
    """Return whether whole drives of a driver with a sonar can run compiled.

    Drivers and sonars say so themselves; a person's own need not.
    """
    return _numbers_of(driver) is not None and _exact_cone(sonar) is not None


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
        yield from enumerate(_simulate(each) for each in drives)
        return
    todo = enumerate(drives)
    with ThreadPoolExecutor(threads) as pool:
        running: dict[Future[SonarLog], int] = {}
        done: deque[Future[SonarLog]] = deque()
        try:
            while True:
                # One waits for each that works.
                for index, each in islice(todo, 2 * threads - len(running) - len(done)):
                    running[pool.submit(_simulate, each)] = index
                if not running:
                    return
                done.extend(wait(running, return_when=FIRST_COMPLETED).done)
                while done:
                    future = done.popleft()
                    yield running.pop(future), future.result()
        finally:
            for future in running:
                future.cancel()


def _simulate(wanted: BatchDrive) -> SonarLog:
    """Return the log of one drive."""
    world, scans, seed = wanted.world, wanted.scans, wanted.seed
    if scans < 1:
        raise InputError(f"scans must be >= 1, got {scans!r}")
    if seed < 0:
        raise InputError(f"seed must be >= 0, got {seed!r}")
    sonar = sonars.preset(wanted.sonar) if isinstance(wanted.sonar, str) else wanted.sonar
    driver = wanted.driver
    driver = drivers.driver(driver, world) if isinstance(driver, str) else driver
    odometry = OdometryModel() if wanted.odometry is None else wanted.odometry
    ring = sonar.ring
    check_firing(sonar.firing, len(ring))
    cone, told = _exact_cone(sonar), _numbers_of(driver)
    if cone is None:
        raise InputError(f"sonar {sonar.name!r} must be an exact simple cone to be compiled")
    if told is None:
        raise InputError(f"driver must be one that is compiled, got {driver!r}")
    engine = open_engine("segments", world, start=wanted.start)
    assert isinstance(engine, Segments)
    pose = engine.pose
    # A stream each, so that one does not shift when another draws more.
    noise_rng, odometry_rng, driver_rng = np.random.default_rng(seed).spawn(3)
    errors = drawn_errors(odometry, odometry_rng)
    time_s, steps = _times(sonar, scans)
    recorded = _blank(scans, len(ring))
    heading_deg = np.rad2deg(ring.heading_rad)
    run(
        tuple(engine.table),
        np.array([pose.x_m, pose.y_m, pose.heading_rad], float),
        steps,
        time_s,
        np.column_stack([ring.x_m, ring.y_m, ring.heading_rad]),
        ring.half_angle_rad,
        (ring.range_max_m, cone.max_bounces, float(cone.threshold)),
        np.cos(world.critical_incidence_rad),
        world.reflectivity,
        world.roughness_m,
        (
            float(cone.noise_std_m),
            float(cone.scale),
            float(cone.quantum_m),
            ring.range_min_m,
            ring.range_max_m,
            cone.silent_m,
        ),
        noise_rng.normal(size=(scans, len(ring))),
        odometry_rng.normal(size=(scans, 2)),
        errors,
        told.kind,
        np.array(told.numbers, float),
        np.array(told.points_m, float).reshape(-1, 2),
        np.array(
            [(heading_deg >= low) & (heading_deg <= high) for low, high in told.sectors_deg], bool
        ).reshape(-1, len(ring)),
        driver_rng,
        tuple(recorded),
    )
    provenance = {
        "world": world.name,
        "world_parameters": dict(world.parameters),
        "seed": seed,
        "scans": scans,
        "driver": _described(driver),
        "sonar": _described(sonar),
        "engine": "segments",
        "odometry": _described(odometry),
    }
    return _log(wanted, sonar, time_s, recorded, provenance)


def _log(
    wanted: BatchDrive,
    sonar: Sonar,
    time_s: NDArray[np.float64],
    recorded: Recorded,
    provenance: dict[str, Any],
) -> SonarLog:
    """Return the log of what was recorded."""
    scans, k = recorded.range_m.shape
    # One name more: -1, no surface, is the last.
    names = np.array([solid.name for solid in wanted.world.solids] + [""])
    sonar_of = np.tile(np.arange(k, dtype=np.int16), scans)
    surface = recorded.surface.ravel()
    truth = LogTruth(
        **_columns(recorded.true_pose, k),
        axis_range_m=recorded.axis_range_m.ravel(),
        cone_range_m=recorded.cone_range_m.ravel(),
        cause=recorded.cause.ravel(),
        surface=names[surface],
        incidence_rad=recorded.incidence_rad.ravel(),
        bounces=recorded.bounces.ravel(),
        collision=np.repeat(recorded.touched, k),
        source=np.where(surface < 0, LogTruth.NO_SOURCE, sonar_of),
        level_db=np.full(surface.size, np.nan),
    )
    return SonarLog(
        ring=sonar.ring,
        scan=np.repeat(np.arange(scans), k),
        sonar=sonar_of,
        time_s=np.repeat(time_s, k),
        **_columns(recorded.believed_pose, k),
        range_m=recorded.range_m.ravel(),
        truth=truth,
        provenance=provenance,
    )


def _columns(poses: NDArray[np.float64], k: int) -> dict[str, Any]:
    names = ("x_m", "y_m", "heading_rad")
    return {name: np.repeat(poses[:, i], k) for i, name in enumerate(names)}


def _blank(scans: int, k: int) -> Recorded:
    def readings(dtype: Any = float) -> NDArray[Any]:
        return np.empty((scans, k), dtype)

    return Recorded(
        np.empty((scans, 3)),
        np.empty((scans, 3)),
        np.empty(scans, bool),
        readings(),
        readings(),
        readings(),
        readings(),
        readings(np.int8),
        readings(np.int32),
        readings(np.int16),
    )


def _times(sonar: Sonar, scans: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the time of each scan and the steps of the physics before it."""
    return _times_of(sonar.firing.period_s, scans)


@lru_cache(maxsize=64)
def _times_of(period_s: float, scans: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    times = [ping.time_s for ping in pings(AllAtOnce(period_s), 1, scans=scans)]
    steps = np.diff([physics_steps(time_s) for time_s in times], prepend=0)
    return np.array(times), steps.astype(np.int64)


def _numbers_of(driver: Driver) -> CompiledDriver | None:
    compiled = getattr(driver, "compiled", None)
    numbers: CompiledDriver | None = None if compiled is None else compiled()
    return numbers


def _exact_cone(sonar: Sonar) -> CompiledCone | None:
    """Return a sonar as a simple cone without rays whose ring fires all at once, else None."""
    cone, k = sonar.compiled_cone(), len(sonar.ring)
    if cone is None or cone.rays is not None:
        return None
    together = (Slot(0.0, tuple(range(k))),)
    return cone if sonar.firing.slots(0, k) == together else None
