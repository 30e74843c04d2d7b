"""The compiled drive: what `sim.simulate` does on `segments` with simple cones, in one call."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.robot.amigobot import BODY_LENGTH_M
from sim.robot.deciding import MEMORY, begin, decide
from sim.robot.kinematics import drive
from sim.robot.odometry import reckon
from sim.sonar.causes import cause_of
from sim.sonar.cone.exact.echo import hear_ring
from sim.sonar.cone.kernel import measured
from sonarmap.kernels.jit import njit
from worlds.facetable import FaceTable

__all__ = ["Recorded", "run"]


class Recorded(NamedTuple):
    """What is recorded of a drive: a row a scan, and of the readings a column a sonar.

    Parameters
    ----------
    true_pose, believed_pose : ndarray, shape (scans, 3)
        Place, metres, and heading, radians.
    touched : ndarray of bool, shape (scans,)
        Whether the robot touched something since the scan before.
    range_m, echo_m, axis_range_m, cone_range_m, incidence_rad : ndarray, shape (scans, sonars)
        See `sonarmap.LogTruth`; the echo is the range without noise.
    cause, surface, bounces : ndarray of int, shape (scans, sonars)
        Likewise; the surface as a number of the world's solids.
    """

    true_pose: NDArray[np.float64]
    believed_pose: NDArray[np.float64]
    touched: NDArray[np.bool_]
    range_m: NDArray[np.float64]
    axis_range_m: NDArray[np.float64]
    cone_range_m: NDArray[np.float64]
    incidence_rad: NDArray[np.float64]
    cause: NDArray[np.int8]
    surface: NDArray[np.int32]
    bounces: NDArray[np.int16]


@njit(error_model="numpy")
def run(
    table, start, steps, time_s, mounts, half_rad, limits, critical_cos, reflectivity, roughness_m,
    reading, noise, slip, errors, kind, numbers, points, looks, rng, recorded,
):  # fmt: skip
    """Drive, listen and record; other threads go on meanwhile.

    Parameters
    ----------
    table : tuple
        Fields of the `FaceTable` of the room.
    start : ndarray, shape (3,)
        Pose at the start.
    steps, time_s : ndarray, shape (scans,)
        Steps of the physics before each scan, and its time.
    mounts, half_rad
        Place and axis of each sonar, shape (sonars, 3), and the half angle of their cones.
    limits, critical_cos, reflectivity
        See `sim.sonar.cone.exact.echo.hear_ring`.
    roughness_m : ndarray, shape (surfaces,)
        Of each surface.
    reading : tuple
        ``noise_std_m, scale, quantum_m, near_m, far_m, silent_m`` of `measured`.
    noise, slip : ndarray, shapes (scans, sonars), (scans, 2)
        Standard normal numbers for the readings and for the wheels.
    errors : ndarray, shape (4,)
        See `sim.robot.odometry.reckon`.
    kind, numbers, points, rng
        See `sim.robot.deciding.decide`.
    looks : ndarray of bool, shape (sectors, sonars)
        Which sonars look into each sector of the driver.
    recorded : tuple
        Fields of a `Recorded`, written.
    """
    table, recorded = FaceTable(*table), Recorded(*recorded)
    noise_std_m, scale, quantum_m, near_m, far_m, silent_m = reading
    sonars = mounts.shape[0]
    pose, believed = start.copy(), start.copy()
    speeds_mps, turns_rad, ticks = np.zeros(2), np.zeros(2), np.zeros(2)
    places, axes = np.empty((sonars, 2)), np.empty(sonars)
    memory, nearest_m = np.empty(MEMORY), np.empty(looks.shape[0])
    begin(kind, numbers, memory, rng)
    left_mps, right_mps, moves = 0.0, 0.0, 0
    for scan in range(steps.size):
        touched = False
        if steps[scan] > 0:
            touched = drive(table, 0, pose, speeds_mps, turns_rad, left_mps, right_mps, steps[scan])
            reckon(
                errors, believed, ticks, turns_rad[0], turns_rad[1],
                slip[moves, 0], slip[moves, 1],
            )  # fmt: skip
            moves += 1
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        for k in range(sonars):
            places[k, 0] = pose[0] + cos * mounts[k, 0] - sin * mounts[k, 1]
            places[k, 1] = pose[1] + sin * mounts[k, 0] + cos * mounts[k, 1]
            axes[k] = pose[2] + mounts[k, 2]
        # No sonar is farther from the robot's middle than its body reaches.
        echoes = hear_ring(
            table, 0, pose[0], pose[1], BODY_LENGTH_M, places, axes, half_rad, limits,
            critical_cos, reflectivity,
        )  # fmt: skip
        cause = cause_of(echoes.echo_m, echoes.bounces, echoes.axis_range_m, echoes.cone_range_m)
        for k in range(sonars):
            surface = echoes.surface[k]
            recorded.range_m[scan, k] = measured(
                echoes.echo_m[k], 0.0 if surface < 0 else roughness_m[surface], noise[scan, k],
                noise_std_m, scale, quantum_m, near_m, far_m, silent_m,
            )  # fmt: skip
            recorded.axis_range_m[scan, k] = echoes.axis_range_m[k]
            recorded.cone_range_m[scan, k] = echoes.cone_range_m[k]
            recorded.incidence_rad[scan, k] = echoes.incidence_rad[k]
            recorded.cause[scan, k], recorded.surface[scan, k] = cause[k], surface
            recorded.bounces[scan, k] = echoes.bounces[k]
        recorded.touched[scan] = touched
        for axis in range(3):
            recorded.true_pose[scan, axis] = pose[axis]
            recorded.believed_pose[scan, axis] = believed[axis]
        for sector in range(looks.shape[0]):
            nearest_m[sector] = math.inf
            for k in range(sonars):
                if looks[sector, k]:
                    seen_m = max(recorded.range_m[scan, k], 0.0)
                    nearest_m[sector] = min(nearest_m[sector], seen_m)
        left_mps, right_mps = decide(
            kind, numbers, points, memory, rng, time_s[scan], believed, nearest_m, touched
        )
