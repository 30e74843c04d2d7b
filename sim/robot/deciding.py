"""The drivers compiled: what `sim.robot.drivers` decides, to the last bit."""

from __future__ import annotations

import math

from sim.robot.amigobot import TRACK_M
from sim.robot.compiled import CONSTANT, FOLLOW, ROUTE, WANDER
from sonarmap.kernels.jit import njit

__all__ = ["MEMORY", "begin", "decide"]

MEMORY = 4
"""How many numbers a driver may remember."""

# What each remembers.
_TARGET = 0
_SEARCHING, _LOST_AT, _BACK_UNTIL = 0, 1, 2
_TURNING, _TURN_UNTIL, _NEXT_WHIM = 0, 1, 3


@njit(error_model="numpy")
def begin(kind, numbers, memory, rng):
    """Write what a driver remembers when its drive begins; see `decide`."""
    memory[:] = 0.0
    if kind == FOLLOW:
        memory[_SEARCHING], memory[_BACK_UNTIL] = 1.0, -1.0
    elif kind == WANDER:
        memory[_TURNING], memory[_TURN_UNTIL], memory[_BACK_UNTIL] = 1.0, -1.0, -1.0
        memory[_NEXT_WHIM] = rng.exponential(numbers[2])


@njit(error_model="numpy")
def decide(kind, numbers, points, memory, rng, now_s, pose, nearest_m, collided):
    """Return the wanted speeds of the left and right wheel, m/s.

    Parameters
    ----------
    kind, numbers, points
        See `sim.robot.compiled.CompiledDriver`.
    memory : ndarray, shape (MEMORY,)
        What the driver remembers; changed in place.
    rng : numpy.random.Generator
        Of its whims.
    now_s : float
        Time since the start.
    pose : ndarray, shape (3,)
        By odometry.
    nearest_m : ndarray
        The nearest reading in each of its sectors; 0 too close, inf for none.
    collided : bool
        Whether the robot has touched something since it decided last.
    """
    if kind == CONSTANT:
        return numbers[0], numbers[1]
    if kind == ROUTE:
        return _go_to(numbers, points, memory, pose)
    if kind == FOLLOW:
        return _follow(numbers, memory, now_s, pose, nearest_m[0], nearest_m[1], collided)
    return _wander(numbers, memory, rng, now_s, nearest_m, collided)


@njit(error_model="numpy")
def _go_to(numbers, points, memory, pose):
    speed_mps, reached_m, turn_radps = numbers[0], numbers[1], numbers[2]
    target = int(memory[_TARGET])
    dx, dy = points[target, 0] - pose[0], points[target, 1] - pose[1]
    if math.hypot(dx, dy) < reached_m:
        target = (target + 1) % points.shape[0]
        memory[_TARGET] = target
        dx, dy = points[target, 0] - pose[0], points[target, 1] - pose[1]
    error = _remainder(math.atan2(dy, dx) - pose[2], math.tau)
    speed = speed_mps * max(0.0, math.cos(error)) ** 3.0
    return _wheels(speed, max(-turn_radps, min(turn_radps, 1.5 * error)))


@njit(error_model="numpy")
def _follow(numbers, memory, now_s, pose, front_m, beside_m, collided):
    distance_m, towards, speed_mps = numbers[0], numbers[1], numbers[2]
    turn_radps, back_s, give_up_rad = numbers[3], numbers[4], numbers[5]
    if collided and now_s >= memory[_BACK_UNTIL]:
        memory[_BACK_UNTIL] = now_s + back_s
    if now_s < memory[_BACK_UNTIL]:
        return _wheels(-0.5 * speed_mps, -towards * turn_radps / 2)
    if front_m < distance_m or beside_m < 0.5 * distance_m:
        memory[_SEARCHING] = 0.0
        return _wheels(0.0, -towards * turn_radps)
    error_m = min(beside_m, 2 * distance_m) - distance_m
    if error_m < distance_m:
        memory[_SEARCHING], memory[_LOST_AT] = 0.0, pose[2]
    elif abs(pose[2] - memory[_LOST_AT]) > give_up_rad:
        memory[_SEARCHING] = 1.0
    turn = 0.0
    if memory[_SEARCHING] == 0.0:
        turn = towards * max(-0.4, min(0.4, 1.2 * error_m))
    return _wheels(speed_mps, turn)


@njit(error_model="numpy")
def _wander(numbers, memory, rng, now_s, nearest_m, collided):
    speed_mps, clearance_m, whim_s = numbers[0], numbers[1], numbers[2]
    turn_radps, back_s = numbers[3], numbers[4]
    ahead_m = nearest_m[0]
    if collided and now_s >= memory[_BACK_UNTIL]:
        memory[_BACK_UNTIL] = now_s + back_s
        # As `Generator.choice` of -1 and 1.
        memory[_TURNING] = -1.0 if rng.integers(0, 2) == 0 else 1.0
        memory[_TURN_UNTIL] = memory[_BACK_UNTIL] + rng.uniform(2.0, 5.0)
    elif now_s >= memory[_TURN_UNTIL] and (ahead_m < clearance_m or now_s > memory[_NEXT_WHIM]):
        memory[_TURNING] = 1.0 if nearest_m[1] > nearest_m[2] else -1.0
        memory[_TURN_UNTIL] = now_s + rng.uniform(1.0, 4.0)
        memory[_NEXT_WHIM] = now_s + rng.exponential(whim_s)
    if now_s < memory[_BACK_UNTIL]:
        return _wheels(-0.5 * speed_mps, 0.0)
    if now_s < memory[_TURN_UNTIL] or ahead_m < clearance_m:
        return _wheels(0.0, memory[_TURNING] * turn_radps)
    return _wheels(speed_mps, 0.0)


@njit(error_model="numpy")
def _wheels(speed_mps, turn_radps):
    half = turn_radps * TRACK_M / 2
    return speed_mps - half, speed_mps + half


@njit(error_model="numpy")
def _remainder(x, y):
    """Return `math.remainder` of finite numbers, y > 0, which numba does not know."""
    rest = abs(x) % y
    other = y - rest
    if rest > other:
        rest = -other
    elif rest == other:
        rest -= 2.0 * (0.5 * (abs(x) - rest) % y)  # half-way: to the even multiple
    return math.copysign(1.0, x) * rest
