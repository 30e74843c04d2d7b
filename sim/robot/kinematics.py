"""The motion of a differential drive, compiled: limited speeds, arcs, and walls in the way."""

from __future__ import annotations

import math

from sim.robot.amigobot import (
    ACCELERATION_MPS2,
    BODY_RADIUS_M,
    DECELERATION_MPS2,
    PHYSICS_DT_S,
    SPEED_MAX_MPS,
    TRACK_M,
    TURN_MAX_RADPS,
    WHEEL_RADIUS_M,
)
from sonarmap.kernels.jit import njit
from worlds.facetable import FaceTable
from worlds.raycast import clearance

__all__ = ["advance_along_arc", "drive", "limited_speeds"]

# In a corner the robot is pushed off one wall into another; after so many pushes it stays where
# it was.
_PUSHES = 3


@njit()
def limited_speeds(
    now_mps: tuple[float, float], wanted_mps: tuple[float, float], dt_s: float
) -> tuple[float, float]:
    """Return the wheel speeds one step later: towards the wanted ones, within the limits.

    Parameters
    ----------
    now_mps, wanted_mps : tuple of float
        Speeds of the left and right wheel along the floor, m/s.
    dt_s : float
        Length of the step, seconds.

    Notes
    -----
    First the wanted speeds are cut to the fastest drive and turn, keeping the curve; then each
    wheel moves towards its own by at most what the acceleration allows, or the deceleration
    when it gets slower.
    """
    left, right = wanted_mps
    excess = max(
        abs(left) / SPEED_MAX_MPS,
        abs(right) / SPEED_MAX_MPS,
        abs(right - left) / (TRACK_M * TURN_MAX_RADPS),
        1.0,
    )
    return (
        _approach(now_mps[0], left / excess, dt_s),
        _approach(now_mps[1], right / excess, dt_s),
    )


@njit()
def _approach(now: float, wanted: float, dt_s: float) -> float:
    slows_down = abs(wanted) < abs(now) or now * wanted < 0
    most = (DECELERATION_MPS2 if slows_down else ACCELERATION_MPS2) * dt_s
    return now + math.copysign(min(abs(wanted - now), most), wanted - now)


@njit()
def advance_along_arc(x, y, heading, left_m, right_m, track_m):
    """Return the pose (x, y, heading) after the wheels have rolled along an arc."""
    forward_m, turn = (left_m + right_m) / 2, (right_m - left_m) / track_m
    # The chord of the arc, which a straight line is its own.
    chord_m = forward_m * math.sin(turn / 2) / (turn / 2) if turn != 0.0 else forward_m
    direction = heading + turn / 2
    return (
        x + chord_m * math.cos(direction),
        y + chord_m * math.sin(direction),
        heading + turn,
    )


@njit()
def drive(table: FaceTable, room, pose, speeds_mps, turns_rad, left_mps, right_mps, steps):
    """Drive for some steps of the physics; return whether the robot touched something.

    The wheels never slip sideways. A disc of the body's radius that would overlap a face is
    pushed off it along the face's normal, so the robot slides along walls while its wheels go
    on turning. (In PyBullet friction turns it against the wall as well.)

    Parameters
    ----------
    table : FaceTable
        The rooms, metres.
    room : int
        The robot's.
    pose : ndarray, shape (3,)
        x, y in metres and heading in radians; changed in place.
    speeds_mps, turns_rad : ndarray, shape (2,)
        Speeds of the left and right wheel and how far each has turned; changed in place.
    left_mps, right_mps : float
        Wanted speeds.
    steps : int
        Steps of `sim.robot.amigobot.PHYSICS_DT_S`.
    """
    dt_s = PHYSICS_DT_S
    # Far from all faces nothing can be touched.
    near_m = BODY_RADIUS_M + SPEED_MAX_MPS * dt_s * steps
    is_near = clearance(table, room, pose[0], pose[1], near_m)[0] < near_m
    touched = False
    for _ in range(steps):
        left, right = limited_speeds((speeds_mps[0], speeds_mps[1]), (left_mps, right_mps), dt_s)
        speeds_mps[0], speeds_mps[1] = left, right
        turns_rad[0] += left * dt_s / WHEEL_RADIUS_M
        turns_rad[1] += right * dt_s / WHEEL_RADIUS_M
        x, y, heading = advance_along_arc(
            pose[0], pose[1], pose[2], left * dt_s, right * dt_s, TRACK_M
        )
        pose[2] = heading
        free = True
        if is_near:
            for push in range(_PUSHES + 1):
                apart_m, away_x, away_y = clearance(table, room, x, y, BODY_RADIUS_M)
                free = apart_m >= BODY_RADIUS_M
                if free or push == _PUSHES:
                    break
                touched = True
                # A hair more, so that rounding does not leave the overlap.
                x += (BODY_RADIUS_M - apart_m + 1e-9) * away_x
                y += (BODY_RADIUS_M - apart_m + 1e-9) * away_y
        if free:
            pose[0], pose[1] = x, y
    return touched
