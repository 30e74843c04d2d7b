"""Odometry: what the robot believes of its pose, from quantised wheel encoders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.robot.amigobot import ENCODER_TICKS_PER_TURN, TRACK_M, WHEEL_RADIUS_M
from sim.robot.kinematics import advance_along_arc
from sonarmap.errors import non_negative, whole
from sonarmap.kernels.jit import njit
from worlds import Pose

__all__ = ["Odometer", "OdometryModel", "drawn_errors", "reckon"]


@dataclass(frozen=True)
class OdometryModel:
    """How wrong the odometry is; all zero makes it exact but for the encoders' steps.

    Parameters
    ----------
    ticks_per_turn : int
        Encoder ticks of a turn of the wheel, >= 1.
    scale_spread : float
        Error of distances, metres per metre: drawn once a drive, evenly from minus to plus half
        of the spread.
    turn_spread : float
        Error of turns, radians per radian, drawn likewise.
    slip_std_m : float
        Standard deviation of each wheel's slip over one metre of its path; grows with the root
        of the distance.
    """

    ticks_per_turn: int = ENCODER_TICKS_PER_TURN
    # AMRISim's odometry error of the AmigoBot; as in Stage, which it extends, E means +-E/2.
    scale_spread: float = 0.0075
    turn_spread: float = 0.0075
    # Assumed: 1 mm after 1 m.
    slip_std_m: float = 0.001

    def __post_init__(self) -> None:
        whole("ticks_per_turn", self.ticks_per_turn, least=1)
        for name in ("scale_spread", "turn_spread", "slip_std_m"):
            non_negative(name, getattr(self, name))

    @classmethod
    def exact(cls) -> OdometryModel:
        """Return a model whose only error is the step of a fine encoder."""
        return cls(ticks_per_turn=1_000_000, scale_spread=0, turn_spread=0, slip_std_m=0)


class Odometer:
    """Dead reckoning from wheel encoders, one robot's.

    Parameters
    ----------
    model : OdometryModel
        Its errors.
    start : Pose
        The pose it begins with.
    rng : numpy.random.Generator
        Where the errors are drawn from.
    """

    def __init__(self, model: OdometryModel, start: Pose, rng: np.random.Generator) -> None:
        self._rng = rng
        self._errors = drawn_errors(model, rng)
        self._pose = np.array([start.x_m, start.y_m, start.heading_rad], float)
        self._ticks = np.zeros(2)

    @property
    def pose(self) -> Pose:
        """Where the robot believes to be."""
        return Pose(*self._pose.tolist())

    def update(self, wheel_turns_rad: tuple[float, float]) -> Pose:
        """Take the wheels' total turns and return the new pose."""
        left_rad, right_rad = wheel_turns_rad
        # Drawn also for wheels at rest: the stream of errors does not depend on the drive.
        slip = self._rng.normal(0.0, 1.0, 2)
        reckon(self._errors, self._pose, self._ticks, left_rad, right_rad, slip[0], slip[1])
        return self.pose


def drawn_errors(model: OdometryModel, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw the errors of one drive, as `reckon` takes them."""
    scale, turn = 1 + np.array([model.scale_spread, model.turn_spread]) * rng.uniform(-0.5, 0.5, 2)
    tick_m = 2 * math.pi * WHEEL_RADIUS_M / model.ticks_per_turn
    # The error of the scale is in the wheels' distances and must not turn the robot as well.
    return np.array(
        [model.ticks_per_turn, tick_m * scale, TRACK_M * scale / turn, model.slip_std_m]
    )


@njit()
def reckon(errors, pose, ticks, left_rad, right_rad, left_slip, right_slip):  # type: ignore[no-untyped-def]
    """Move the believed pose on by what the encoders report; changes `pose` and `ticks`.

    Parameters
    ----------
    errors : ndarray, shape (4,)
        Ticks of a turn, believed length of a tick and track in metres, slip over a metre.
    pose : ndarray, shape (3,)
        x, y in metres and heading in radians.
    ticks : ndarray, shape (2,)
        The left and right encoder so far.
    left_rad, right_rad : float
        How far the wheels have turned since the start.
    left_slip, right_slip : float
        Standard normal numbers.
    """
    ticks_per_turn, tick_m, track_m, slip_std_m = errors
    left = math.floor(left_rad / math.tau * ticks_per_turn)
    right = math.floor(right_rad / math.tau * ticks_per_turn)
    left_m, right_m = (left - ticks[0]) * tick_m, (right - ticks[1]) * tick_m
    ticks[0], ticks[1] = left, right
    left_m += left_slip * slip_std_m * math.sqrt(abs(left_m))
    right_m += right_slip * slip_std_m * math.sqrt(abs(right_m))
    pose[0], pose[1], pose[2] = advance_along_arc(
        pose[0], pose[1], pose[2], left_m, right_m, track_m
    )
