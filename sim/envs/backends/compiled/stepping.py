"""The compiled control step of many robots with simple cones: drive, reckon, fire, read.

It calls what the engine `segments` and `sim.ConeSonar` are made of, robot by robot, so that a
batch does what one robot does, to the last bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.envs.backends.compiled.cone import (
    ConeLimits,
    RingGeometry,
    cone_echo,
    cone_memory,
)
from sim.envs.backends.compiled.fan import faces_near
from sim.robot.amigobot import BODY_LENGTH_M, PHYSICS_DT_S, WHEEL_RADIUS_M
from sim.robot.kinematics import drive
from sim.robot.odometry import reckon
from sim.sonar.causes import cause_of
from sim.sonar.cone.exact.echo import exact_echoes, hear_ring
from sim.sonar.cone.kernel import Surfaces, measured
from sonarmap import LogTruth
from sonarmap.kernels.jit import njit
from worlds.facetable import FaceTable

__all__ = ["Draws", "advance", "advance_alone", "body_dtype"]

_NO_SOURCE = int(LogTruth.NO_SOURCE)


def body_dtype() -> np.dtype[np.void]:
    """Return the type of what the backend knows of a robot beside its state.

    Fields
    ------
    room : int
        Its room in the table of faces.
    turns_rad, speeds_mps, ticks : float, shape (2,)
        Of the left and right wheel: turned since the start, speed now, encoder.
    odometry : float, shape (4,)
        See `sim.robot.odometry.reckon`.
    steps, next_firing, firing_period : int
        Steps of the physics so far, when it fires next, and how often.
    slips, noises : int
        Rows of the random numbers that are used up.
    noise_std_m, scale, quantum_m, near_m, far_m, silent_m : float
        See `sim.sonar.cone.kernel.measured`.
    threshold : float
        See `sim.sonar.cone.kernel.meet_surfaces`.
    max_bounces : int
        How many mirrors a sound is traced over.
    """
    pair = (2,)
    return np.dtype(
        [
            ("room", np.int64),
            ("turns_rad", float, pair),
            ("speeds_mps", float, pair),
            ("ticks", float, pair),
            ("odometry", float, (4,)),
            ("steps", np.int64),
            ("next_firing", np.int64),
            ("firing_period", np.int64),
            ("slips", np.int64),
            ("noises", np.int64),
            ("noise_std_m", float),
            ("scale", float),
            ("quantum_m", float),
            ("near_m", float),
            ("far_m", float),
            ("silent_m", float),
            ("threshold", float),
            ("max_bounces", np.int64),
        ],
        align=True,
    )


class Draws(NamedTuple):
    """Standard normal numbers, of each robot or, of one of them, without the first axis.

    Parameters
    ----------
    noise, slip : ndarray, shapes (robots, firings, sonars), (robots, moves, 2)
        For the readings, and for the wheels.
    """

    noise: NDArray[np.float64]
    slip: NDArray[np.float64]


@njit()
def _fire(table, state, body, surfaces, ring, noise):
    """Let all sonars of a robot fire and read them, as `sim.ConeSonar.listen` does."""
    x, y, heading = state.true_pose[0], state.true_pose[1], state.true_pose[2]
    cos, sin = math.cos(heading), math.sin(heading)
    mounts, sonars = ring.mounts, ring.mounts.shape[0]
    places, axes = np.empty((sonars, 2)), np.empty(sonars)
    for k in range(sonars):
        places[k, 0] = x + cos * mounts[k, 0] - sin * mounts[k, 1]
        places[k, 1] = y + sin * mounts[k, 0] + cos * mounts[k, 1]
        axes[k] = heading + mounts[k, 2]
    limits = ConeLimits(body.far_m, body.max_bounces, body.threshold)
    # No sonar is farther from the robot's middle than its body reaches.
    if ring.cos_bearing.size == 0:
        echoes = hear_ring(
            table, body.room, x, y, BODY_LENGTH_M, places, axes, ring.half_rad,
            limits, surfaces.critical_cos, surfaces.reflectivity,
        )  # fmt: skip
    else:
        near = faces_near(table, body.room, x, y, body.far_m + BODY_LENGTH_M)
        echoes = _fans(table, body.room, near, places, axes, ring, limits, surfaces)
    cause = cause_of(echoes.echo_m, echoes.bounces, echoes.axis_range_m, echoes.cone_range_m)
    for k in range(sonars):
        surface = echoes.surface[k]
        silent = surface < 0
        state.range_m[k] = measured(
            echoes.echo_m[k], 0.0 if silent else surfaces.roughness_m[surface], noise[k],
            body.noise_std_m, body.scale, body.quantum_m, body.near_m, body.far_m, body.silent_m,
        )  # fmt: skip
        state.axis_range_m[k] = echoes.axis_range_m[k]
        state.cone_range_m[k] = echoes.cone_range_m[k]
        state.surface[k], state.bounces[k] = surface, echoes.bounces[k]
        state.incidence_rad[k] = echoes.incidence_rad[k]
        state.cause[k] = cause[k]
        state.level_db[k] = np.nan  # a simple cone knows no level
        state.source[k] = _NO_SOURCE if silent else k
        state.fired_s[k] = body.steps * PHYSICS_DT_S
        for axis in range(3):
            state.fired_true_pose[k, axis] = state.true_pose[axis]
            state.fired_pose[k, axis] = state.believed_pose[axis]
        state.fresh[k] = 1


@njit()
def _fans(table, room, near, places, axes, ring, limits, surfaces):
    """Return the first returns of fans of rays."""
    echoes, memory = exact_echoes(axes.size), cone_memory(ring.cos_bearing.size)
    for k in range(axes.size):
        (
            echoes.echo_m[k], echoes.surface[k], echoes.bounces[k], incidence_cos,
            echoes.axis_range_m[k], echoes.cone_range_m[k],
        ) = cone_echo(
            table, room, near, (places[k, 0], places[k, 1], axes[k]), ring, limits, surfaces, memory
        )  # fmt: skip
        if echoes.surface[k] >= 0:
            echoes.incidence_rad[k] = math.acos(min(incidence_cos, 1.0))
    return echoes


@njit()
def _advance(table, state, body, surfaces, ring, draws, wanted_mps, steps):
    """Drive one robot for some steps of the physics and fire when it is due."""
    state.touched = False
    for k in range(state.fresh.size):
        state.fresh[k] = 0
    left_rad, right_rad = body.turns_rad[0], body.turns_rad[1]
    left = steps
    while True:
        # A firing at the very end of a step belongs to it: the newest that can be known.
        on = min(body.next_firing - body.steps, left)
        if on > 0:
            touched = drive(
                table, body.room, state.true_pose, body.speeds_mps, body.turns_rad,
                wanted_mps[0], wanted_mps[1], on,
            )  # fmt: skip
            state.touched = state.touched or touched
            reckon(
                body.odometry, state.believed_pose, body.ticks,
                body.turns_rad[0], body.turns_rad[1],
                draws.slip[body.slips, 0], draws.slip[body.slips, 1],
            )  # fmt: skip
            body.slips += 1
            body.steps += on
            left -= on
        if body.steps < body.next_firing:
            break
        _fire(table, state, body, surfaces, ring, draws.noise[body.noises])
        body.noises += 1
        body.next_firing += body.firing_period
    state.time_s = body.steps * PHYSICS_DT_S
    if steps > 0:
        per_rad = WHEEL_RADIUS_M / (steps * PHYSICS_DT_S)
        state.wheel_mps[0] = (body.turns_rad[0] - left_rad) * per_rad
        state.wheel_mps[1] = (body.turns_rad[1] - right_rad) * per_rad


@njit()
def advance_alone(table, states, bodies, materials, ring, draws, wanted_mps, steps, row):
    """Advance the robot of one row; see `advance`."""
    noise, slip = draws
    _advance(
        FaceTable(*table),
        states[row],
        bodies[row],
        Surfaces(materials[row, 0], materials[row, 1], materials[row, 2]),
        RingGeometry(*ring),
        Draws(noise[row], slip[row]),
        wanted_mps[row],
        steps,
    )


@njit()
def advance(table, states, bodies, materials, ring, draws, wanted_mps, steps, rows):
    """Advance robots by one control step, one after the other.

    Parameters
    ----------
    table, ring, draws : tuple
        Fields of a `FaceTable`, the rooms, and of the `RingGeometry` and the `Draws` of every
        robot. (Numba takes a plain tuple over from Python in less than half of the time of a
        named one.)
    states, bodies : structured ndarray, shape (robots,)
        `sim.envs.states.robot_dtype` and `body_dtype`, changed in place.
    materials : ndarray, shape (robots, 3, surfaces)
        The fields of `sim.sonar.cone.kernel.Surfaces` of each robot.
    wanted_mps : ndarray, shape (robots, 2)
        Wanted speeds of the left and right wheel.
    steps : int
        Steps of the physics in a control step.
    rows : ndarray of int
        Which robots.
    """
    for row in rows:
        advance_alone(table, states, bodies, materials, ring, draws, wanted_mps, steps, row)
