"""`plain_log`: a drive step by step, on any engine, with any sonar and driver."""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby

import numpy as np

from sim.engines.opening import open_engine
from sim.robot.drivers import Sensed
from sim.robot.odometry import Odometer
from sim.runs.arguments import DriveArguments
from sim.runs.motion import Motion, transducers
from sim.runs.packets import StatusPackets
from sim.runs.recorder import Recorder
from sim.sonar.firing import pings
from sonarmap import SonarLog

__all__ = ["plain_log"]


def plain_log(asked: DriveArguments, *, on_scan: Callable[[int], None] | None = None) -> SonarLog:
    """Return the log of a drive; see `sim.simulate`."""
    world, firing, carried = asked.world, asked.firing, asked.sonar.ring
    # A stream each, so that one does not shift when another draws more.
    noise_rng, odometry_rng, driver_rng = np.random.default_rng(asked.seed).spawn(3)
    with open_engine(asked.engine, world, gui=asked.gui) as robot:
        recorder = Recorder(carried, world, asked.packets)
        odometer = Odometer(asked.odometry, robot.pose, odometry_rng)
        motion = Motion(robot, odometer)
        send_packets = _packet_sender(motion, recorder, asked.packets)
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
    return recorder.log(asked.provenance)


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
