"""Actions: what a number or two of an agent mean for the wheels."""

from __future__ import annotations

from typing import Any, Protocol

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, Space
from numpy.typing import NDArray

from sim.robot.amigobot import SPEED_MAX_MPS, TRACK_M, TURN_MAX_RADPS
from sonarmap.errors import one_of

__all__ = ["MODES", "ActionMode", "action_mode"]

# Speeds of the left and right wheel at the fastest drive, and at the fastest turn.
_HALF_TURN_MPS = 0.5 * TRACK_M * TURN_MAX_RADPS
_WHEELS_OF_VELOCITY = np.array([[SPEED_MAX_MPS, SPEED_MAX_MPS], [-_HALF_TURN_MPS, _HALF_TURN_MPS]])


class ActionMode(Protocol):
    """How actions become wheel speeds."""

    space: Space[Any]
    """The actions of one robot."""

    def shares(self, actions: Any, robots: int) -> NDArray[np.float64]:
        """Return actions of robots as shares of the limits, shape (robots, 2).

        Raises
        ------
        gymnasium.error.InvalidAction
            If an action is not in the space; the message names the rule.
        """

    def wheels_mps(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the wanted speeds of the left and right wheel, shape (robots, 2)."""


class _Continuous:
    """Two numbers in [-1, 1]."""

    space: Space[Any] = Box(-1.0, 1.0, (2,), np.float32)

    def shares(self, actions: Any, robots: int) -> NDArray[np.float64]:
        """Check the actions; see `ActionMode`."""
        try:
            shares = np.asarray(actions, float)
        except (TypeError, ValueError):
            raise _invalid(f"an action must be numbers, got {actions!r}") from None
        if shares.shape not in ((robots, 2), (2,) if robots == 1 else (robots, 2)):
            rule = "(2,)" if robots == 1 else f"({robots}, 2)"
            raise _invalid(f"actions must have shape {rule}, got {shares.shape}")
        # NaN compares as False, too.
        if not (np.abs(shares) <= 1.0).all():
            raise _invalid(f"an action must be within [-1, 1], got {actions!r}")
        return shares.reshape(robots, 2)


class Wheels(_Continuous):
    """Speeds of the left and right wheel as shares of the fastest drive."""

    def wheels_mps(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the wanted speeds of the wheels."""
        return SPEED_MAX_MPS * shares


class Velocity(_Continuous):
    """Speed ahead and turn rate as shares of the fastest drive and turn."""

    def wheels_mps(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the wanted speeds of the wheels."""
        return _of_velocity(shares)


class Choices:
    """One of six manoeuvres."""

    # Shares of the fastest drive and turn: ahead, ahead in a curve to the left and to the right,
    # turn left and right in place, back.
    _VELOCITIES = np.array(
        [(0.5, 0.0), (0.4, 0.5), (0.4, -0.5), (0.0, 0.7), (0.0, -0.7), (-0.3, 0.0)]
    )

    space: Space[Any] = Discrete(len(_VELOCITIES))

    def shares(self, actions: Any, robots: int) -> NDArray[np.float64]:
        """Check the actions; see `ActionMode`."""
        chosen = np.asarray(actions)
        if chosen.shape not in ((robots,), () if robots == 1 else (robots,)):
            rule = "a whole number" if robots == 1 else f"of shape ({robots},)"
            raise _invalid(f"a discrete action must be {rule}, got {actions!r}")
        last = len(self._VELOCITIES) - 1
        if chosen.dtype.kind not in "iu" or not ((chosen >= 0) & (chosen <= last)).all():
            raise _invalid(f"a discrete action must be a whole number 0 to {last}, got {actions!r}")
        shares: NDArray[np.float64] = self._VELOCITIES[chosen.reshape(robots)]
        return shares

    def wheels_mps(self, shares: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the wanted speeds of the wheels."""
        return _of_velocity(shares)


MODES = ("velocity", "wheels", "discrete")


def action_mode(name: str) -> ActionMode:
    """Return the action mode called `name`, or raise `InputError`."""
    modes: dict[str, type[Velocity | Wheels | Choices]] = dict(
        zip(MODES, (Velocity, Wheels, Choices), strict=True)
    )
    return modes[one_of("action", name, MODES)]()


def _of_velocity(shares: NDArray[np.float64]) -> NDArray[np.float64]:
    wheels_mps: NDArray[np.float64] = shares @ _WHEELS_OF_VELOCITY
    return wheels_mps


def _invalid(message: str) -> Exception:
    return gymnasium.error.InvalidAction(message)
