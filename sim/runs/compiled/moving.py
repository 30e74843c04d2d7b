"""Compiled: what every kind of drive has in common, from the start to the driver's decisions."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.robot.deciding import decide
from sim.robot.kinematics import drive
from sim.robot.odometry import reckon
from sim.runs.compiled.schedule import Schedule
from sonarmap.kernels.jit import njit
from worlds.facetable import FaceTable

__all__ = ["Controls", "Recorded", "Robot", "decide_speeds", "go_through"]


class Controls(NamedTuple):
    """The driver as numbers.

    Parameters
    ----------
    kind, numbers, points, rng
        See `sim.robot.deciding.decide`.
    looks : ndarray of bool, shape (sectors, sonars)
        Which sonars look into each of its sectors.
    """

    kind: int
    numbers: NDArray[np.float64]
    points: NDArray[np.float64]
    looks: NDArray[np.bool_]
    rng: np.random.Generator


class Robot(NamedTuple):
    """A robot under way, with all that is known of it beforehand; arrays are changed in place.

    Parameters
    ----------
    table : FaceTable
        The room.
    schedule : Schedule
        When which sonars fire.
    mounts : ndarray, shape (sonars, 3)
        Place and axis of each sonar in the robot's frame.
    errors : ndarray, shape (4,)
        Of its odometry, see `sim.robot.odometry.reckon`.
    slip : ndarray, shape (pings, 2)
        Standard normal numbers for the way to each ping.
    pose, believed : ndarray, shape (3,)
        Where it is, and where it believes to be: metres and radians.
    speeds_mps, turns_rad, ticks, wanted_mps : ndarray, shape (2,)
        Of the left and right wheel: speed now, turned since the start, encoder, wanted speed.
    newest_m : ndarray, shape (sonars,)
        The newest reading of each sonar.
    memory : ndarray, shape (MEMORY,)
        What the driver remembers.
    """

    table: FaceTable
    schedule: Schedule
    mounts: NDArray[np.float64]
    errors: NDArray[np.float64]
    slip: NDArray[np.float64]
    pose: NDArray[np.float64]
    believed: NDArray[np.float64]
    speeds_mps: NDArray[np.float64]
    turns_rad: NDArray[np.float64]
    ticks: NDArray[np.float64]
    wanted_mps: NDArray[np.float64]
    newest_m: NDArray[np.float64]
    memory: NDArray[np.float64]


class Recorded(NamedTuple):
    """What is recorded of a drive.

    Parameters
    ----------
    true_pose, believed_pose : ndarray, shape (pings, 3)
        Place, metres, and heading, radians.
    touched : ndarray of bool, shape (scans,)
        Whether the robot touched something since the scan before.
    range_m, axis_range_m, cone_range_m, incidence_rad, level_db : ndarray, shape (firings,)
        See `sonarmap.LogTruth`.
    cause, surface, bounces, source : ndarray of int, shape (firings,)
        Likewise; the surface as a number of the world's solids, -1 for none.
    """

    true_pose: NDArray[np.float64]
    believed_pose: NDArray[np.float64]
    touched: NDArray[np.bool_]
    range_m: NDArray[np.float64]
    axis_range_m: NDArray[np.float64]
    cone_range_m: NDArray[np.float64]
    incidence_rad: NDArray[np.float64]
    level_db: NDArray[np.float64]
    cause: NDArray[np.int8]
    surface: NDArray[np.int32]
    bounces: NDArray[np.int16]
    source: NDArray[np.int16]

    @classmethod
    def blank(cls, schedule: Schedule) -> Recorded:
        """Return what a drive of a schedule fills."""
        pings, firings = len(schedule.time_s), len(schedule.sonar)
        return cls(
            true_pose=np.empty((pings, 3)),
            believed_pose=np.empty((pings, 3)),
            touched=np.empty(len(schedule.scan), bool),
            range_m=np.empty(firings),
            axis_range_m=np.empty(firings),
            cone_range_m=np.empty(firings),
            incidence_rad=np.empty(firings),
            level_db=np.empty(firings),
            cause=np.empty(firings, np.int8),
            surface=np.empty(firings, np.int32),
            bounces=np.empty(firings, np.int16),
            source=np.empty(firings, np.int16),
        )


@njit(error_model="numpy")
def go_through(robot, scan, places, axes, recorded):
    """Drive from ping to ping of a scan and record it; set where the transducers are at each.

    Parameters
    ----------
    robot : Robot
    scan : int
    places, axes : ndarray, shapes (p, sonars, 2), (p, sonars)
        Of the transducers at the scan's first pings; written.
    recorded : Recorded
    """
    schedule, mounts, pose = robot.schedule, robot.mounts, robot.pose
    first, touched = schedule.first_ping[scan], False
    for ping in range(first, schedule.first_ping[scan + 1]):
        if schedule.steps[ping] > 0:
            touches = drive(
                robot.table, 0, pose, robot.speeds_mps, robot.turns_rad,
                robot.wanted_mps[0], robot.wanted_mps[1], schedule.steps[ping],
            )  # fmt: skip
            touched = touched or touches
            reckon(
                robot.errors, robot.believed, robot.ticks, robot.turns_rad[0], robot.turns_rad[1],
                robot.slip[ping, 0], robot.slip[ping, 1],
            )  # fmt: skip
        for axis in range(3):
            recorded.true_pose[ping, axis] = pose[axis]
            recorded.believed_pose[ping, axis] = robot.believed[axis]
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        for k in range(len(mounts)):
            places[ping - first, k, 0] = pose[0] + cos * mounts[k, 0] - sin * mounts[k, 1]
            places[ping - first, k, 1] = pose[1] + sin * mounts[k, 0] + cos * mounts[k, 1]
            axes[ping - first, k] = pose[2] + mounts[k, 2]
    recorded.touched[scan] = touched


@njit(error_model="numpy")
def decide_speeds(robot, controls, scan, recorded):
    """Let the driver decide when the last sonar of a scan has been read."""
    schedule = robot.schedule
    end = schedule.first_ping[scan + 1]
    for firing in range(
        schedule.first_firing[schedule.first_ping[scan]], schedule.first_firing[end]
    ):
        robot.newest_m[schedule.sonar[firing]] = recorded.range_m[firing]
    nearest_m = np.full(len(controls.looks), np.inf)
    for sector in range(len(nearest_m)):
        for k in range(len(robot.newest_m)):
            if controls.looks[sector, k]:
                nearest_m[sector] = min(nearest_m[sector], max(robot.newest_m[k], 0.0))
    robot.wanted_mps[0], robot.wanted_mps[1] = decide(
        controls.kind, controls.numbers, controls.points, robot.memory, controls.rng,
        schedule.time_s[end - 1], robot.believed, nearest_m, recorded.touched[scan],
    )  # fmt: skip
