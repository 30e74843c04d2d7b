"""`compiled_log`: a whole drive on `segments` in a few compiled calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.engines.opening import open_engine
from sim.engines.segments import Segments
from sim.robot.compiled import CompiledDriver
from sim.robot.deciding import MEMORY, begin
from sim.robot.drivers import Driver
from sim.robot.odometry import drawn_errors
from sim.runs.arguments import DriveArguments
from sim.runs.compiled import cones, images
from sim.runs.compiled.cones import Cones
from sim.runs.compiled.moving import Controls, Recorded, Robot
from sim.runs.compiled.schedule import Schedule, schedule_of
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.firing import Slot
from sim.sonar.physical import columns as t
from sim.sonar.physical.images.setup import CompiledImages
from sim.sonar.protocol import Sonar
from sonarmap import InputError, LogTruth, SonarLog, SonarRing
from worlds import Pose, World

__all__ = ["PIECE_SCANS", "compiled_log", "is_compiled", "runs_compiled"]

PIECE_SCANS = 250
"""So many scans run in one call: between two calls Ctrl-C is heard."""

Drive = Callable[[Robot, Controls, int, int, Recorded], None]
"""Runs from a scan to the one before another."""


def is_compiled(driver: Driver, sonar: Sonar) -> bool:
    """Return whether whole drives of a driver with a sonar can run compiled.

    Drivers and sonars say so themselves; a person's own need not.
    """
    return _numbers_of(driver) is not None and _compiled_sonar(sonar) is not None


def runs_compiled(asked: DriveArguments) -> bool:
    """Return whether a drive can run compiled."""
    return (
        asked.engine == "segments"
        and asked.packets is None
        and not asked.gui
        and is_compiled(asked.driver, asked.sonar)
    )


def compiled_log(
    asked: DriveArguments,
    *,
    start: Pose | None = None,
    on_scan: Callable[[int], None] | None = None,
) -> SonarLog:
    """Return the log of a drive, that of `sim.runs.plain.plain_log` to the last bit.

    Parameters
    ----------
    asked : DriveArguments
        On the engine "segments".
    start : Pose, optional
        Where the robot begins; by default the world's start.
    on_scan : callable, optional
        Called with the number of each scan, for some hundred scans at once.

    Raises
    ------
    InputError
        If driver or sonar cannot be compiled, or the robot does not fit at the start.
    """
    world, ring = asked.world, asked.sonar.ring
    sonar, driver = _compiled_sonar(asked.sonar), _numbers_of(asked.driver)
    if sonar is None:
        raise InputError(
            f"sonar {asked.sonar.name!r} must be an exact simple cone, or a physical sonar without "
            "rays and interferers, to be compiled"
        )
    if driver is None:
        raise InputError(f"driver must be one that is compiled, got {asked.driver!r}")
    # A stream each, so that one does not shift when another draws more.
    noise_rng, odometry_rng, driver_rng = np.random.default_rng(asked.seed).spawn(3)
    schedule = schedule_of(asked.firing, len(ring), asked.scans)
    with open_engine("segments", world, start=start) as engine:
        assert isinstance(engine, Segments)
        robot = _robot(engine, ring, schedule, drawn_errors(asked.odometry, odometry_rng))
        moves = schedule.steps > 0
        robot.slip[moves] = odometry_rng.normal(size=(moves.sum(), 2))
        controls = _controls(driver, ring, driver_rng)
        begin(controls.kind, controls.numbers, robot.memory, driver_rng)
        run = (
            _with_cones(sonar, ring, world, schedule, noise_rng)
            if isinstance(sonar, CompiledCone)
            else _with_images(sonar, engine, world, schedule, noise_rng)
        )
    recorded, scans = Recorded.blank(schedule), len(schedule.scan)
    for first in range(0, scans, PIECE_SCANS):
        end = min(first + PIECE_SCANS, scans)
        run(robot, controls, first, end, recorded)
        if on_scan is not None:
            for scan in schedule.scan[first:end].tolist():
                on_scan(scan)
    return _log(asked, schedule, recorded)


def _robot(
    engine: Segments, ring: SonarRing, schedule: Schedule, errors: NDArray[np.float64]
) -> Robot:
    """Return a robot at rest at its start."""
    pose = np.array([engine.pose.x_m, engine.pose.y_m, engine.pose.heading_rad], float)
    return Robot(
        table=engine.table,
        schedule=schedule,
        mounts=np.column_stack([ring.x_m, ring.y_m, ring.heading_rad]),
        errors=errors,
        slip=np.zeros((len(schedule.time_s), 2)),
        pose=pose,
        believed=pose.copy(),
        speeds_mps=np.zeros(2),
        turns_rad=np.zeros(2),
        ticks=np.zeros(2),
        wanted_mps=np.zeros(2),
        newest_m=np.full(len(ring), np.inf),
        memory=np.zeros(MEMORY),
    )


def _controls(driver: CompiledDriver, ring: SonarRing, rng: np.random.Generator) -> Controls:
    heading_deg = np.rad2deg(ring.heading_rad)
    looks = [(heading_deg >= low) & (heading_deg <= high) for low, high in driver.sectors_deg]
    return Controls(
        driver.kind,
        np.array(driver.numbers, float),
        np.array(driver.points_m, float).reshape(-1, 2),
        np.array(looks, bool).reshape(-1, len(ring)),
        rng,
    )


def _with_cones(
    cone: CompiledCone,
    ring: SonarRing,
    world: World,
    schedule: Schedule,
    rng: np.random.Generator,
) -> Drive:
    """Return what drives with simple cones."""
    critical_cos, reflectivity, roughness_m = cone.materials(world)
    in_room = Cones(
        half_rad=ring.half_angle_rad,
        limits=(ring.range_max_m, cone.max_bounces, float(cone.threshold)),
        critical_cos=critical_cos,
        reflectivity=reflectivity,
        roughness_m=roughness_m,
        reading=(
            float(cone.noise_std_m),
            float(cone.scale),
            float(cone.quantum_m),
            ring.range_min_m,
            ring.range_max_m,
            cone.silent_m,
        ),
    )
    noise = rng.normal(size=len(schedule.sonar))

    def run(robot: Robot, controls: Controls, first: int, end: int, recorded: Recorded) -> None:
        cones.run(robot, controls, in_room, noise, first, end, recorded)

    return run


def _with_images(
    sonar: CompiledImages,
    engine: Segments,
    world: World,
    schedule: Schedule,
    rng: np.random.Generator,
) -> Drive:
    """Return what drives with a physical sonar."""
    # A plain tuple, as the array of a plain drive passes it: compiled once for both.
    setup = tuple(sonar.drawn(engine.faces, world, rng))
    noise = rng.normal(size=len(schedule.sonar))
    sounds = np.empty((0, t.SOUND_COLUMNS))

    def run(robot: Robot, controls: Controls, first: int, end: int, recorded: Recorded) -> None:
        nonlocal sounds
        sounds = images.run(robot, controls, setup, noise, sounds, first, end, recorded)

    return run


def _log(asked: DriveArguments, schedule: Schedule, recorded: Recorded) -> SonarLog:
    """Return the log of what was recorded."""
    # One name more: -1, no surface, is the last.
    names = np.array([solid.name for solid in asked.world.solids] + [""])
    of_pings, of_scans = schedule.firings_of_pings, schedule.firings_of_scans
    truth = LogTruth(
        **_columns(recorded.true_pose, of_pings),
        axis_range_m=recorded.axis_range_m,
        cone_range_m=recorded.cone_range_m,
        cause=recorded.cause,
        surface=names[recorded.surface],
        incidence_rad=recorded.incidence_rad,
        bounces=recorded.bounces,
        collision=np.repeat(recorded.touched, of_scans),
        source=recorded.source,
        level_db=recorded.level_db,
    )
    return SonarLog(
        ring=asked.sonar.ring,
        scan=np.repeat(schedule.scan, of_scans),
        sonar=schedule.sonar.astype(np.int16),
        time_s=np.repeat(schedule.time_s, of_pings),
        **_columns(recorded.believed_pose, of_pings),
        range_m=recorded.range_m,
        truth=truth,
        provenance=asked.provenance,
    )


def _columns(poses: NDArray[np.float64], times: NDArray[np.int64]) -> dict[str, Any]:
    names = ("x_m", "y_m", "heading_rad")
    return {name: np.repeat(poses[:, i], times) for i, name in enumerate(names)}


def _numbers_of(driver: Driver) -> CompiledDriver | None:
    if not _speaks_for_itself(driver, ("begin",)):
        return None
    numbers: CompiledDriver | None = driver.compiled()  # type: ignore[attr-defined]
    return numbers


def _compiled_sonar(sonar: Sonar) -> CompiledCone | CompiledImages | None:
    """Return a sonar as numbers if it is a kind that drives compiled, else None.

    A simple cone must be without rays, and its ring must fire all at once.
    """
    if not _speaks_for_itself(sonar, ("array", "listen")):
        return None
    compiled = sonar.compiled()
    if not isinstance(compiled, CompiledCone):
        return compiled
    k = len(sonar.ring)
    together = (Slot(0.0, tuple(range(k))),)
    is_exact = compiled.rays is None and sonar.firing.slots(0, k) == together
    return compiled if is_exact else None


def _speaks_for_itself(part: object, methods: tuple[str, ...]) -> bool:
    """Return whether what a part says of its compiled form holds for what it does.

    A person's subclass that overrides what a part does, and not ``compiled``, is not what that
    says.
    """
    for kind in type(part).__mro__:
        if "compiled" in vars(kind):
            return True
        if any(method in vars(kind) for method in methods):
            return False
    return False
