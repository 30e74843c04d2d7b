"""Passes of the robot by an opening, and of the bench at the same places."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import sonarmap as sm
import worlds
from sim.sonar.protocol import Sonar
from sonarbed.reporting.bench import readings
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.openings.passes import RIG, SPEED_MPS, detects
from worlds import World

__all__ = ["DrivenPass", "drive_past"]

_SEED = 0


@dataclass(frozen=True)
class DrivenPass:
    """One pass of the robot at `distance_m`.

    `detected` readings show the opening; on the bench, at the same places, `on_bench` do, and
    `agreeing` of all `readings` show the same.
    """

    distance_m: float
    detected: int
    on_bench: int
    agreeing: int
    readings: int


def drive_past(
    context: StudyContext, sonar: Sonar, gap_m: float, distances_m: Sequence[float]
) -> list[DrivenPass]:
    """Pass an opening with the robot, and again on the bench from the same places."""
    rig = worlds.load(RIG, gap_m=gap_m)
    way_m = gap_m / 2 + 0.2 - rig.start.x_m
    scans = math.ceil(way_m / (SPEED_MPS * sonar.firing.period_s))
    specs = [
        spec
        for distance_m in distances_m
        for spec in context.specs(
            RIG,
            driver="straight",
            scans=scans,
            seeds=[_SEED],
            parameters={"gap_m": gap_m, "distance_m": distance_m},
        )
    ]
    logs = context.logs(specs, "driving past an opening")
    return [
        _compared(sonar, rig, log, distance_m)
        for log, distance_m in zip(logs, distances_m, strict=True)
    ]


def _compared(sonar: Sonar, rig: World, log: sm.SonarLog, distance_m: float) -> DrivenPass:
    """Return what the left sonar reads, beside the bench from where it truly was."""
    left = int(np.argmin(np.abs(sonar.ring.heading_rad - np.pi / 2)))
    read = log.select(log.sonar == left)
    there = read.at_true_poses()
    again = readings(sonar, rig, there.sensor_xy_m, there.axis_rad, np.random.default_rng(_SEED))
    by_robot, on_bench = detects(read.range_m, distance_m), detects(again, distance_m)
    return DrivenPass(
        distance_m,
        int(by_robot.sum()),
        int(on_bench.sum()),
        int((by_robot == on_bench).sum()),
        by_robot.size,
    )
