"""The compiled drive with exact simple cones that fire all at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.robot.amigobot import BODY_LENGTH_M
from sim.runs.compiled.moving import decide_speeds, go_through
from sim.sonar.causes import cause_of
from sim.sonar.cone.exact.echo import hear_ring
from sim.sonar.cone.kernel import measured
from sonarmap import LogTruth
from sonarmap.kernels.jit import njit

__all__ = ["Cones", "run"]

_NO_SOURCE = int(LogTruth.NO_SOURCE)


class Cones(NamedTuple):
    """Simple cones in a room.

    Parameters
    ----------
    half_rad : float
        Half angle of the cones.
    limits, critical_cos, reflectivity
        See `sim.sonar.cone.exact.echo.hear_ring`.
    roughness_m : ndarray, shape (surfaces,)
        Of each surface.
    reading : tuple
        ``noise_std_m, scale, quantum_m, near_m, far_m, silent_m`` of `measured`.
    """

    half_rad: float
    limits: tuple[float, int, float]
    critical_cos: NDArray[np.float64]
    reflectivity: NDArray[np.float64]
    roughness_m: NDArray[np.float64]
    reading: tuple[float, float, float, float, float, float]


@njit(error_model="numpy")
def run(robot, controls, cones, noise, first_scan, end_scan, recorded):
    """Drive, listen and record for some scans; other threads go on meanwhile.

    Parameters
    ----------
    robot : Robot
        Changed, so that the next call goes on.
    controls : Controls
    cones : Cones
    noise : ndarray, shape (firings,)
        Standard normal numbers.
    first_scan, end_scan : int
        From which scan on, and the one after the last.
    recorded : Recorded
        Written.
    """
    sonars = len(robot.mounts)
    noise_std_m, scale, quantum_m, near_m, far_m, silent_m = cones.reading
    places, axes = np.empty((1, sonars, 2)), np.empty((1, sonars))
    for scan in range(first_scan, end_scan):
        go_through(robot, scan, places, axes, recorded)
        # No sonar is farther from the robot's middle than its body reaches.
        echoes = hear_ring(
            robot.table, 0, robot.pose[0], robot.pose[1], BODY_LENGTH_M, places[0], axes[0],
            cones.half_rad, cones.limits, cones.critical_cos, cones.reflectivity,
        )  # fmt: skip
        cause = cause_of(echoes.echo_m, echoes.bounces, echoes.axis_range_m, echoes.cone_range_m)
        for k in range(sonars):
            at, surface = scan * sonars + k, echoes.surface[k]
            recorded.range_m[at] = measured(
                echoes.echo_m[k], 0.0 if surface < 0 else cones.roughness_m[surface], noise[at],
                noise_std_m, scale, quantum_m, near_m, far_m, silent_m,
            )  # fmt: skip
            recorded.axis_range_m[at] = echoes.axis_range_m[k]
            recorded.cone_range_m[at] = echoes.cone_range_m[k]
            recorded.incidence_rad[at] = echoes.incidence_rad[k]
            recorded.level_db[at] = np.nan  # a simple cone knows no level
            recorded.cause[at], recorded.surface[at] = cause[k], surface
            recorded.bounces[at] = echoes.bounces[k]
            recorded.source[at] = _NO_SOURCE if surface < 0 else k
        decide_speeds(robot, controls, scan, recorded)
