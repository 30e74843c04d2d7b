"""Odometry: what the robot believes of its pose, from quantised wheel encoders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sim.amigobot import ENCODER_TICKS_PER_TURN, TRACK_M, WHEEL_RADIUS_M
from sonarmap.errors import InputError, non_negative
from worlds import Pose

__all__ = ["Odometer", "OdometryModel"]


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
        Standard deviation of each wheel's slip over one metre of its way; grows with the root
        of the distance.
    """

    ticks_per_turn: int = ENCODER_TICKS_PER_TURN
    # AMRISim's odometry error of the AmigoBot; as in Stage, which it extends, E means +-E/2.
    scale_spread: float = 0.0075
    turn_spread: float = 0.0075
    # Assumed: 1 mm after 1 m.
    slip_std_m: float = 0.001

    def __post_init__(self) -> None:
        if self.ticks_per_turn < 1:
            raise InputError(f"ticks_per_turn must be >= 1, got {self.ticks_per_turn!r}")
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
        self._model, self._rng, self._pose = model, rng, start
        self._tick_m = 2 * math.pi * WHEEL_RADIUS_M / model.ticks_per_turn
        self._ticks = (0, 0)
        scale, turn = rng.uniform(-0.5, 0.5, size=2)
        self._scale = 1 + model.scale_spread * scale
        # The error of the scale is in the wheels' ways and must not turn the robot as well.
        self._track_m = TRACK_M * self._scale / (1 + model.turn_spread * turn)

    @property
    def pose(self) -> Pose:
        """Where the robot believes to be."""
        return self._pose

    def update(self, wheel_turns_rad: tuple[float, float]) -> Pose:
        """Take the wheels' total turns and return the new pose."""
        ticks = tuple(
            math.floor(turn / math.tau * self._model.ticks_per_turn) for turn in wheel_turns_rad
        )
        left_m, right_m = (
            self._rolled(now - before) for now, before in zip(ticks, self._ticks, strict=True)
        )
        self._ticks = (ticks[0], ticks[1])
        self._pose = _along_arc(self._pose, left_m, right_m, self._track_m)
        return self._pose

    def _rolled(self, ticks: int) -> float:
        way_m = ticks * self._tick_m * self._scale
        # Drawn also for a wheel at rest: the stream of errors does not depend on the drive.
        return way_m + self._rng.normal() * self._model.slip_std_m * math.sqrt(abs(way_m))


def _along_arc(pose: Pose, left_m: float, right_m: float, track_m: float) -> Pose:
    """Return the pose after the wheels have rolled along an arc."""
    forward_m, turn = (left_m + right_m) / 2, (right_m - left_m) / track_m
    # The chord of the arc, which a straight line is its own.
    chord_m = forward_m * math.sin(turn / 2) / (turn / 2) if turn else forward_m
    direction = pose.heading_rad + turn / 2
    return Pose(
        pose.x_m + chord_m * math.cos(direction),
        pose.y_m + chord_m * math.sin(direction),
        pose.heading_rad + turn,
    )
