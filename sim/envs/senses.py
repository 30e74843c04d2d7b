"""Compiled: what every task observes, and what a step leaves behind on each robot."""

from __future__ import annotations

import math

from sim.robot.amigobot import SPEED_MAX_MPS, TRACK_M, TURN_MAX_RADPS
from sonarmap.kernels.jit import njit

__all__ = ["record_step", "sense"]


@njit()
def sense(states, last_shares, range_max_m, ranges, validity, speed, last_action):
    """Write what robots sense into new arrays.

    Parameters
    ----------
    states : structured ndarray, shape (robots,)
        See `sim.envs.states.robot_dtype`.
    last_shares : ndarray, shape (robots, 2)
        What was wanted last, as shares of the limits.
    range_max_m : float
        Maximum range of the sonars.
    ranges, validity, speed, last_action : ndarray
        Written, see the environments' docstrings.
    """
    for i in range(states.size):
        state = states[i]
        for k in range(ranges.shape[1]):
            range_m = state.range_m[k]
            ranges[i, k] = min(max(range_m / range_max_m, 0.0), 1.0)
            validity[i, k] = 1 if math.isfinite(range_m) else 0
        left, right = state.wheel_mps[0], state.wheel_mps[1]
        # A slipping robot may turn its wheels a little faster than its limits.
        speed[i, 0] = min(max(0.5 * (left + right) / SPEED_MAX_MPS, -1.0), 1.0)
        speed[i, 1] = min(max((right - left) / (TRACK_M * TURN_MAX_RADPS), -1.0), 1.0)
        last_action[i, 0], last_action[i, 1] = last_shares[i, 0], last_shares[i, 1]


@njit()
def record_step(states, moves, shares, wanted_mps, dt_s, last_shares, touching_s, effort):
    """Record what a control step did to robots.

    Parameters
    ----------
    states : structured ndarray, shape (robots,)
        At the end of the step.
    moves : ndarray of bool, shape (robots,)
        Who moved.
    shares, wanted_mps : ndarray, shape (robots, 2)
        What was wanted: shares of the limits, speeds of the wheels.
    dt_s : float
        Length of the step.
    last_shares, touching_s, effort : ndarray
        Written: what was wanted last; for how long each has been touching something; mean square
        of the wanted wheel speeds over the fastest.
    """
    for i in range(states.size):
        touching_s[i] = touching_s[i] + dt_s if states[i].touched else 0.0
        if moves[i]:
            last_shares[i, 0], last_shares[i, 1] = shares[i, 0], shares[i, 1]
        left, right = wanted_mps[i, 0] / SPEED_MAX_MPS, wanted_mps[i, 1] / SPEED_MAX_MPS
        effort[i] = 0.5 * (min(left * left, 1.0) + min(right * right, 1.0))
