"""`simulate`: a robot drives in a known room and writes a log with the truth beside it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from sim.engines.opening import ENGINES, open_engine
from sim.robot import drivers
from sim.robot.clock import check_steps
from sim.robot.drivers import Driver, Sensed
from sim.robot.odometry import Odometer, OdometryModel
from sim.runs.motion import Motion, transducers
from sim.runs.packets import StatusPackets
from sim.runs.recorder import Recorder
from sim.sonar import presets as sonars
from sim.sonar.carried import with_ring
from sim.sonar.firing import Firing, check_firing, fitted, pings
from sim.sonar.protocol import Sonar
from sonarmap import InputError, SonarLog, SonarRing
from sonarmap.errors import flag, instance, whole
from worlds import World

__all__ = ["MOST_SCANS", "DriveArguments", "simulate"]

MOST_SCANS = 10_000_000
"""Longest drive in scans: the log of a longer one, 80 million readings, would fill the memory."""


@dataclass(frozen=True)
class DriveArguments:
    """What `simulate` is asked for, checked and with every name looked up; see there."""

    world: World
    scans: int
    seed: int
    driver: Driver
    sonar: Sonar
    firing: Firing
    engine: str
    odometry: OdometryModel
    packets: StatusPackets | None
    gui: bool

    @classmethod
    def of(
        cls,
        world: World,
        *,
        scans: int,
        seed: int,
        driver: str | Driver = "auto",
        sonar: str | Sonar = "physical",
        ring: str | Path | SonarRing | None = None,
        engine: str = "bullet",
        odometry: OdometryModel | None = None,
        packets: StatusPackets | None = None,
        gui: bool = False,
    ) -> DriveArguments:
        """Return the arguments, or raise `InputError` with the first that breaks its rule."""
        instance("world", world, World, "worlds.load(name) returns one")
        scans, seed = whole("scans", scans, least=1), whole("seed", seed, least=0)
        if scans > MOST_SCANS:
            raise InputError(
                f"scans must be <= {MOST_SCANS}, for the log of more would not fit into the "
                f"memory, got {scans}"
            )
        sonar_used = with_ring(sonars.of(sonar), ring)
        firing = fitted(sonar_used.firing, len(sonar_used.ring))
        check_firing(firing, len(sonar_used.ring))
        if packets is not None:
            instance("packets", packets, StatusPackets, "StatusPackets() are a Pioneer's")
            check_steps("packets.period_s", packets.period_s)
        ENGINES.find(engine)
        return cls(
            world,
            scans,
            seed,
            drivers.of(driver, world),
            sonar_used,
            firing,
            engine,
            OdometryModel() if odometry is None else instance("odometry", odometry, OdometryModel),
            packets,
            flag("gui", gui),
        )


def simulate(
    world: World,
    *,
    scans: int,
    seed: int,
    driver: str | Driver = "auto",
    sonar: str | Sonar = "physical",
    ring: str | Path | SonarRing | None = None,
    engine: str = "bullet",
    odometry: OdometryModel | None = None,
    packets: StatusPackets | None = None,
    gui: bool = False,
    on_scan: Callable[[int], None] | None = None,
) -> SonarLog:
    """Drive a robot through a world and return the log of its sonars.

    Parameters
    ----------
    world : World
        The room, see `worlds.load`.
    scans : int
        How many scans to take, 1 to `MOST_SCANS`. The first is taken at the start, at rest.
    seed : int
        Seed of all that is random, >= 0. The same world, arguments and seed give the same log,
        bit for bit, on one machine.
    driver : str or Driver
        Who drives: a name that `sim.robot.drivers.driver` knows, or a driver. "auto" follows
        the world's route, if it has one, and wanders otherwise.
    sonar : str or Sonar
        The sonars: a name that `sim.sonar.presets.preset` knows, or a sonar. By default those
        that behave like sonars; "thesis" is the simple cone, quicker and easier to reason about.
    ring : str, Path or SonarRing, optional
        Another ring for the sonars: a name or a TOML file, see `sonarmap.ring`, or a ring. Places,
        cones and ranges are its; the acoustics stay.
    engine : str
        What moves the robot and casts the rays: "bullet", PyBullet with its dynamics;
        "segments", exact faces and plain kinematics, many times faster; or another that
        `sim.engines.opening.open_engine` knows.
    odometry : OdometryModel, optional
        Errors of the odometry, by default the AmigoBot's.
    packets : StatusPackets, optional
        Log what the robot's status packets report, stale values repeated; by default each reading
        once, with the time and the pose of its own firing.
    gui : bool
        Show the engine's window.
    on_scan : callable, optional
        Called with the number of each scan taken, for a progress bar.

    Returns
    -------
    SonarLog
        With truth; its provenance records how it was made.

    Raises
    ------
    InputError
        If a name is unknown, an argument is of a wrong type or breaks its rule, or the robot does
        not fit at the start.
    """
    asked = DriveArguments.of(
        world,
        scans=scans,
        seed=seed,
        driver=driver,
        sonar=sonar,
        ring=ring,
        engine=engine,
        odometry=odometry,
        packets=packets,
        gui=gui,
    )
    firing, carried = asked.firing, asked.sonar.ring

    # A stream each, so that one does not shift when another draws more.
    noise_rng, odometry_rng, driver_rng = np.random.default_rng(asked.seed).spawn(3)
    with open_engine(engine, world, gui=asked.gui) as robot:
        recorder = Recorder(carried, world, packets)
        odometer = Odometer(asked.odometry, robot.pose, odometry_rng)
        motion = Motion(robot, odometer)
        send_packets = _packet_sender(motion, recorder, packets)
        array = asked.sonar.array(robot, world, noise_rng)
        control = asked.driver.begin(driver_rng)
        newest_m = np.full(len(carried), np.inf)
        schedule = pings(firing, len(carried), scans=asked.scans)
        for scan, in_scan in groupby(schedule, lambda ping: ping.scan):
            fired: list[int] = []
            for ping in in_scan:
                send_packets(ping.time_s)
                motion.until(ping.time_s)
                array.fire(ping.time_s, ping.sonars, *transducers(carried, robot.pose))
                recorder.fired(scan, ping.time_s, ping.sonars, odometer.pose, robot.pose)
                fired += ping.sonars
            echoes = array.detect()
            touched = motion.touched_since()
            recorder.detected(echoes, touched=touched)
            newest_m[fired] = echoes.range_m
            if on_scan is not None:
                on_scan(scan)
            # The driver decides once a scan, when its last sonar has been read.
            sensed = Sensed(
                motion.time_s, odometer.pose, newest_m.copy(), carried, collided=touched
            )
            motion.speeds_mps = control(sensed)
        send_packets(asked.scans * firing.period_s)  # the last packets have the last readings
    return recorder.log(
        {
            "world": world.name,
            "world_parameters": dict(world.parameters),
            "seed": asked.seed,
            "scans": asked.scans,
            "driver": _described(asked.driver),
            "sonar": _described(asked.sonar),
            "engine": engine,
            "odometry": _described(asked.odometry),
            **({} if packets is None else {"packets": _described(packets)}),
        }
    )


def _packet_sender(
    motion: Motion, recorder: Recorder, packets: StatusPackets | None
) -> Callable[[float], None]:
    """Return what drives on to the status packets that are due by a time and records them."""
    sent = 0

    def send(until_s: float) -> None:
        nonlocal sent
        while packets is not None and (due_s := (sent + 1) * packets.period_s) <= until_s + 1e-9:
            motion.until(due_s)
            recorder.packet(due_s, motion.believed_pose)
            sent += 1

    return send


def _described(part: object) -> dict[str, Any]:
    """Return a configuration as JSON-able values, for the provenance."""
    described: dict[str, Any] = {"kind": type(part).__name__}
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            # The log carries its ring itself.
            if field.name != "ring":
                is_part = dataclasses.is_dataclass(value)
                described[field.name] = _described(value) if is_part else value
    return described
