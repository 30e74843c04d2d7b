"""The compiled control step of many robots with simple cones: drive, reckon, fire, read.

It calls what the engine `segments` and `sim.ConeSonar` are made of, robot by robot, so that a
batch does what one robot does, to the last bit.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from sim.envs.backends.compiled.cone import cone_echo, cone_memory
from sim.envs.backends.compiled.fan import faces_near
from sim.robot.amigobot import BODY_LENGTH_M, PHYSICS_DT_S, WHEEL_RADIUS_M
from sim.robot.kinematics import drive
from sim.robot.odometry import reckon
from sim.sonar.causes import cause_of
from sim.sonar.cone.kernel import measured
from sonarmap import LogTruth

__all__ = ["advance_alone", "advance_together", "body_dtype"]

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


@njit(cache=True)
def _fire(
    table, state, body, critical_cos, reflectivity, roughness_m, mounts, cos_bearing, sin_bearing,
    noise,
):  # fmt: skip
    """Let all sonars of a robot fire and read them, as `sim.ConeSonar.listen` does."""
    sonars = mounts.shape[0]
    x, y, heading = state.true_pose[0], state.true_pose[1], state.true_pose[2]
    cos, sin = math.cos(heading), math.sin(heading)
    memory = cone_memory(cos_bearing.size)
    # No sonar is farther from the robot's middle than its body reaches.
    near = faces_near(table, body.room, x, y, body.far_m + BODY_LENGTH_M)
    echo_m, bounces = np.empty(sonars), np.empty(sonars, np.int16)
    for k in range(sonars):
        echo_m[k], surface, bounces[k], incidence_cos, axis_range_m, cone_range_m = cone_echo(
            table, body.room, near,
            x + cos * mounts[k, 0] - sin * mounts[k, 1],
            y + sin * mounts[k, 0] + cos * mounts[k, 1],
            heading + mounts[k, 2],
            cos_bearing, sin_bearing, body.far_m, body.max_bounces,
            critical_cos, reflectivity, body.threshold, memory,
        )  # fmt: skip
        silent = surface < 0
        state.range_m[k] = measured(
            echo_m[k], 0.0 if silent else roughness_m[surface], noise[k],
            body.noise_std_m, body.scale, body.quantum_m, body.near_m, body.far_m, body.silent_m,
        )  # fmt: skip
        state.axis_range_m[k], state.cone_range_m[k] = axis_range_m, cone_range_m
        state.surface[k], state.bounces[k] = surface, bounces[k]
        state.incidence_rad[k] = np.nan if silent else math.acos(min(incidence_cos, 1.0))
        state.level_db[k] = np.nan  # a simple cone knows no level
        state.source[k] = _NO_SOURCE if silent else k
        state.fired_s[k] = body.steps * PHYSICS_DT_S
        for axis in range(3):
            state.fired_true_pose[k, axis] = state.true_pose[axis]
            state.fired_pose[k, axis] = state.believed_pose[axis]
        state.fresh[k] = 1
    cause = cause_of(echo_m, bounces, state.axis_range_m, state.cone_range_m)
    for k in range(sonars):
        state.cause[k] = cause[k]


@njit(cache=True)
def _advance(
    table, state, body, critical_cos, reflectivity, roughness_m, mounts, cos_bearing, sin_bearing,
    noise, slip,
    left_mps, right_mps, steps,
):  # fmt: skip
    """Drive one robot for some steps of the physics and fire when it is due."""
    state.touched = False
    for k in range(mounts.shape[0]):
        state.fresh[k] = 0
    left_rad, right_rad = body.turns_rad[0], body.turns_rad[1]
    left = steps
    while True:
        # A firing at the very end of a step belongs to it: the newest that can be known.
        on = min(body.next_firing - body.steps, left)
        if on > 0:
            touched = drive(
                table, body.room, state.true_pose, body.speeds_mps, body.turns_rad,
                left_mps, right_mps, on,
            )  # fmt: skip
            state.touched = state.touched or touched
            reckon(
                body.odometry, state.believed_pose, body.ticks,
                body.turns_rad[0], body.turns_rad[1], slip[body.slips, 0], slip[body.slips, 1],
            )  # fmt: skip
            body.slips += 1
            body.steps += on
            left -= on
        if body.steps < body.next_firing:
            break
        _fire(
            table, state, body, critical_cos, reflectivity, roughness_m, mounts, cos_bearing,
            sin_bearing, noise[body.noises],
        )  # fmt: skip
        body.noises += 1
        body.next_firing += body.firing_period
    state.time_s = body.steps * PHYSICS_DT_S
    if steps > 0:
        per_rad = WHEEL_RADIUS_M / (steps * PHYSICS_DT_S)
        state.wheel_mps[0] = (body.turns_rad[0] - left_rad) * per_rad
        state.wheel_mps[1] = (body.turns_rad[1] - right_rad) * per_rad


@njit(cache=True)
def advance_alone(
    table,
    states,
    bodies,
    materials,
    mounts,
    cos_bearing,
    sin_bearing,
    noise,
    slip,
    wanted_mps,
    steps,
    row,
):
    """Advance the robot of one row; see `advance_together`."""
    _advance(
        table, states[row], bodies[row], materials[row, 0], materials[row, 1], materials[row, 2],
        mounts, cos_bearing, sin_bearing, noise[row], slip[row],
        wanted_mps[row, 0], wanted_mps[row, 1], steps,
    )  # fmt: skip


@njit(cache=True, parallel=True)
def advance_together(
    table,
    states,
    bodies,
    materials,
    mounts,
    cos_bearing,
    sin_bearing,
    noise,
    slip,
    wanted_mps,
    steps,
    rows,
):
    """Advance robots by one control step, on all cores.

    Parameters
    ----------
    table : FaceTable
        The rooms.
    states, bodies : structured ndarray, shape (robots,)
        `sim.envs.states.robot_dtype` and `body_dtype`, changed in place.
    materials : ndarray, shape (robots, 3, surfaces)
        Cosine of the critical incidence, reflectivity and roughness in metres of each surface.
    mounts : ndarray, shape (sonars, 3)
        Place and axis of each sonar in the robot's frame.
    cos_bearing, sin_bearing : ndarray, shape (rays,)
        Bearings of a fan.
    noise, slip : ndarray, shapes (robots, firings, sonars), (robots, moves, 2)
        Standard normal numbers.
    wanted_mps : ndarray, shape (robots, 2)
        Wanted speeds of the left and right wheel.
    steps : int
        Steps of the physics in a control step.
    rows : ndarray of int
        Which robots.
    """
    for k in prange(rows.size):
        row = rows[k]
        _advance(
            table, states[row], bodies[row], materials[row, 0], materials[row, 1],
            materials[row, 2], mounts, cos_bearing, sin_bearing, noise[row], slip[row],
            wanted_mps[row, 0], wanted_mps[row, 1], steps,
        )  # fmt: skip
