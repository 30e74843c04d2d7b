"""`simulate`: a robot drives in a known room and writes a log with the truth beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np

from sim import amigobot, cone, drivers
from sim.acoustics import Sonar
from sim.drivers import Driver, Sensed
from sim.engine import Engine, open_engine
from sim.odometry import Odometer, OdometryModel
from sim.recorder import Recorder
from sonarmap import InputError, SonarLog
from worlds import World

__all__ = ["simulate"]


def simulate(
    world: World,
    *,
    scans: int,
    seed: int,
    driver: str | Driver = "thesis",
    sonar: str | Sonar = "thesis",
    engine: str = "bullet",
    odometry: OdometryModel | None = None,
    gui: bool = False,
    on_scan: Callable[[int], None] | None = None,
) -> SonarLog:
    """Drive a robot through a world and return the log of its sonars.

    Parameters
    ----------
    world : World
        The room, see `worlds.load`.
    scans : int
        How many scans to take, >= 1. The first is taken at the start, at rest.
    seed : int
        Seed of all that is random, >= 0. The same world, arguments and seed give the same log,
        bit for bit, on one machine.
    driver : str or Driver
        Who drives: a name of `sim.drivers.names()` or a driver.
    sonar : str or Sonar
        The sonars: a name of `sim.cone.PRESETS` or a sonar.
    engine : str
        What moves the robot and casts the rays: "bullet".
    odometry : OdometryModel, optional
        Errors of the odometry, by default the AmigoBot's.
    gui : bool
        Show the engine's window.
    on_scan : callable, optional
        Called with the number of each scan taken, for a progress bar.

    Returns
    -------
    SonarLog
        With truth; its provenance tells how it was made.

    Raises
    ------
    InputError
        If a name is unknown, a number breaks its rule, or the robot does not fit at the start.
    """
    if scans < 1:
        raise InputError(f"scans must be >= 1, got {scans!r}")
    if seed < 0:
        raise InputError(f"seed must be >= 0, got {seed!r}")
    sonar_used = cone.preset(sonar) if isinstance(sonar, str) else sonar
    driver_used = drivers.driver(driver, world) if isinstance(driver, str) else driver
    odometry = OdometryModel() if odometry is None else odometry
    _whole_steps(sonar_used.scan_period_s)

    # A stream each, so that one does not shift when another draws more.
    noise_rng, odometry_rng, driver_rng = np.random.default_rng(seed).spawn(3)
    with open_engine(engine, world, gui=gui) as robot:
        recorder = Recorder(sonar_used.ring, world)
        odometer = Odometer(odometry, robot.pose, odometry_rng)
        control = driver_used.begin(driver_rng)
        touched = False
        for scan in range(scans):
            time_s = scan * sonar_used.scan_period_s
            sensor_xy_m, axis_rad = _transducers(sonar_used, robot)
            echoes = sonar_used.listen(robot, world, sensor_xy_m, axis_rad, noise_rng)
            recorder.add(time_s, odometer.pose, robot.pose, echoes, touched=touched)
            if on_scan is not None:
                on_scan(scan)
            if scan + 1 < scans:
                sensed = Sensed(
                    time_s, odometer.pose, echoes.range_m, sonar_used.ring, collided=touched
                )
                touched = robot.advance(*control(sensed), sonar_used.scan_period_s)
                odometer.update(robot.wheel_turns_rad)
    return recorder.log(
        {
            "world": world.name,
            "world_parameters": dict(world.parameters),
            "seed": seed,
            "scans": scans,
            "driver": _told(driver_used),
            "sonar": _told(sonar_used),
            "engine": engine,
            "odometry": _told(odometry),
        }
    )


def _transducers(sonar: Sonar, robot: Engine) -> tuple[Any, Any]:
    """Return true places (k, 2) and axes (k,) of the sonars."""
    pose, ring = robot.pose, sonar.ring
    cos, sin = np.cos(pose.heading_rad), np.sin(pose.heading_rad)
    x_m = pose.x_m + cos * ring.x_m - sin * ring.y_m
    y_m = pose.y_m + sin * ring.x_m + cos * ring.y_m
    return np.column_stack([x_m, y_m]), pose.heading_rad + ring.heading_rad


def _whole_steps(period_s: float) -> None:
    steps = period_s / amigobot.PHYSICS_DT_S
    if abs(steps - round(steps)) > 1e-6 or round(steps) < 1:
        raise InputError(
            f"scan_period_s must be a multiple of {amigobot.PHYSICS_DT_S} s, got {period_s!r}"
        )


def _told(part: object) -> dict[str, Any]:
    """Return a configuration as JSON-able values, for the provenance."""
    told: dict[str, Any] = {"kind": type(part).__name__}
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            # The log carries its ring itself.
            if field.name != "ring":
                told[field.name] = value
    return told
