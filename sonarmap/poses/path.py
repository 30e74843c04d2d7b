"""`CorrectedPath`: the poses of a drive as its odometry's errors would have it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import non_negative, positive
from sonarmap.log import SonarLog

__all__ = ["CorrectedPath", "OdometryErrors"]

# More knots than this grow no wiser and cost memory: on longer ways they lie farther apart.
_MOST_KNOTS = 100


@dataclass(frozen=True)
class OdometryErrors:
    """How wrong a robot's odometry may be: standard deviations.

    Parameters
    ----------
    scale : float
        Of distances, metres per metre.
    turn : float
        Of turns, radians per radian.
    slip : float
        Of the heading after one metre of the wheels' way, radians; grows with the root of the way.
    track_m : float
        Distance between the wheels, metres: turning on the spot is way for them, too.
    """

    # The AmigoBot's odometry as AMRISim has it: evenly within half of 0.0075, whose standard
    # deviation is 0.0022, here a little more for robots that are not calibrated.
    scale: float = 0.003
    turn: float = 0.003
    # Assumed, as in the simulator: each wheel slips 1 mm after 1 m, over the AmigoBot's track.
    slip: float = 0.005
    track_m: float = 0.28

    def __post_init__(self) -> None:
        for name in ("scale", "turn", "slip"):
            positive(name, getattr(self, name))
        non_negative("track_m", self.track_m)


class CorrectedPath:
    """The poses of a log's readings as a function of the errors of its odometry.

    The parameters are the error of distances, that of turns, and a drift of the heading, linear
    between knots that lie evenly on the wheels' way. The first pose stays where it is.

    Parameters
    ----------
    log : SonarLog
        The drive.
    errors : OdometryErrors
        What is likely.
    knot_m : float
        Way between two knots, metres.
    """

    def __init__(self, log: SonarLog, errors: OdometryErrors, knot_m: float) -> None:
        self._xy_m = np.column_stack([log.x_m, log.y_m])
        self._step_m = np.diff(self._xy_m, axis=0, prepend=self._xy_m[:1])
        turn_rad = np.diff(log.heading_rad, prepend=log.heading_rad[:1])
        turn_rad = (turn_rad + math.pi) % math.tau - math.pi
        self._heading_rad = log.heading_rad[0] + np.cumsum(turn_rad)
        wheels_m = np.hypot(*self._step_m.T) + np.abs(turn_rad) * errors.track_m / 2
        self.way_m: NDArray[np.float64] = np.cumsum(wheels_m)
        """Way of the wheels up to each reading, metres, shape (n,)."""
        knots = min(max(1, math.ceil(self.way_m[-1] / knot_m)), _MOST_KNOTS)
        self.parameters = 2 + knots
        """Number of parameters."""
        # Rows: by how much each parameter turns the heading of a reading.
        drift = _hats(self.way_m, knots)
        turned = self._heading_rad - self._heading_rad[0]
        self._turns = np.column_stack([np.zeros(len(turned)), turned, drift])
        between_m = max(self.way_m[-1], 1e-9) / knots
        self.prior: NDArray[np.float64] = _prior(errors, knots, between_m)
        """What multiplies the parameters to likely sizes: its product with them is standard normal,
        shape (parameters, parameters)."""

    def poses(
        self, parameters: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return places (n, 2), metres, and headings (n,), radians, for some parameters."""
        turned = self._turns @ parameters
        steps_m = (1 + parameters[0]) * _rotated(self._step_m, _midway(turned))
        return self._xy_m[0] + np.cumsum(steps_m, axis=0), self._heading_rad + turned

    def derivatives(
        self, parameters: NDArray[np.float64], rows: NDArray[np.intp]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return by how much each parameter moves (n, 2, m) and turns (n, m) some readings."""
        steps_m = _rotated(self._step_m, _midway(self._turns @ parameters))
        turned = (1 + parameters[0]) * np.column_stack([-steps_m[:, 1], steps_m[:, 0]])
        rates = _midway(self._turns)
        moves = np.empty((len(rows), 2, self.parameters))
        for axis in range(2):
            moves[:, axis] = np.cumsum(turned[:, axis, None] * rates, axis=0)[rows]
        moves[:, :, 0] = np.cumsum(steps_m, axis=0)[rows]
        return moves, self._turns[rows]


def _hats(way_m: NDArray[np.float64], knots: int) -> NDArray[np.float64]:
    """Return the share of each knot but the first in each reading's drift, shape (n, knots)."""
    at = way_m / max(way_m[-1], 1e-9) * knots
    shares: NDArray[np.float64] = np.maximum(1 - np.abs(at[:, None] - np.arange(1, knots + 1)), 0.0)
    return shares


def _prior(errors: OdometryErrors, knots: int, between_m: float) -> NDArray[np.float64]:
    steps = np.eye(knots) - np.eye(knots, k=-1)
    prior = np.zeros((2 + knots, 2 + knots))
    prior[0, 0], prior[1, 1] = 1 / errors.scale, 1 / errors.turn
    prior[2:, 2:] = steps / (errors.slip * math.sqrt(between_m))
    return prior


def _midway(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values halfway between each reading and the one before; the first is not moved."""
    middle = np.zeros_like(values)
    middle[1:] = (values[1:] + values[:-1]) / 2
    return middle


def _rotated(xy: NDArray[np.float64], angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.column_stack([cos * xy[:, 0] - sin * xy[:, 1], sin * xy[:, 0] + cos * xy[:, 1]])
