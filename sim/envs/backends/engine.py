"""`EngineBackend`: robots on any engine with any sonar, one by one."""

from __future__ import annotations

import weakref
from collections.abc import Iterator
from dataclasses import fields
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.engines.opening import open_engine
from sim.envs.backends.protocol import EpisodeSetup
from sim.envs.states import new_states
from sim.robot.amigobot import WHEEL_RADIUS_M
from sim.robot.odometry import Odometer
from sim.runs.motion import Motion, transducers
from sim.sonar.firing import Ping, pings
from sim.sonar.protocol import Echoes
from worlds import Pose

__all__ = ["EngineBackend"]


class EngineBackend:
    """The `Backend` for any engine and any sonar, robot by robot.

    Parameters
    ----------
    engine : str
        What moves the robots and casts their rays.
    robots : int
        How many.
    sonars : int
        Sonars of a robot.
    control_s : float
        Length of a control step, a multiple of `sim.robot.amigobot.PHYSICS_DT_S`.
    """

    def __init__(self, engine: str, robots: int, sonars: int, control_s: float) -> None:
        self._engine, self._control_s = engine, control_s
        self._robots: list[_Robot | None] = [None] * robots
        self.states = new_states(robots, sonars)
        self._close_when_dropped()

    def begin(self, row: int, setup: EpisodeSetup) -> None:
        """Begin an episode of one robot; what fires at time 0 is read."""
        self._leave(row)
        self.states[row] = new_states(1, len(setup.sonar.ring))[0]
        robot = self._robots[row] = _Robot(self._engine, setup)
        robot.advance(self.states[row], 0.0)

    def advance(self, wanted_mps: NDArray[np.float64], moves: NDArray[np.bool_]) -> None:
        """Drive the robots of the rows that move for one control step."""
        for row in np.flatnonzero(moves):
            robot = self._robots[row]
            assert robot is not None, "advanced before begin"
            left_mps, right_mps = wanted_mps[row].tolist()
            robot.motion.speeds_mps = (left_mps, right_mps)
            robot.advance(self.states[row], self._control_s)

    def close(self) -> None:
        """Close the engines; closing twice is fine."""
        _close_all(self._robots)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: all but the watch over this object."""
        return {name: value for name, value in self.__dict__.items() if name != "_finalizer"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._close_when_dropped()

    def _close_when_dropped(self) -> None:
        # Who drops an environment without closing it does not mean to keep its engine.
        self._finalizer = weakref.finalize(self, _close_all, self._robots)

    def _leave(self, row: int) -> None:
        robot, self._robots[row] = self._robots[row], None
        if robot is not None:
            robot.engine.close()


def _close_all(robots: list[_Robot | None]) -> None:
    for row, robot in enumerate(robots):
        robots[row] = None
        if robot is not None:
            robot.engine.close()


class _Robot:
    """One robot in its episode."""

    def __init__(self, engine: str, setup: EpisodeSetup) -> None:
        self.engine = open_engine(engine, setup.world, start=setup.start)
        odometer = Odometer(setup.odometry, setup.start, setup.slip_rng)
        self.motion = Motion(self.engine, odometer)
        self._sonar = setup.sonar
        try:
            self._array = setup.sonar.array(self.engine, setup.world, setup.noise_rng)
        except BaseException:
            self.engine.close()
            raise
        self._taken = 0
        self._pings = self._from_here()
        self._next = self._taken_next()
        self._steps = 0

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: all but the walk through the schedule, which does not copy."""
        return {name: value for name, value in self.__dict__.items() if name != "_pings"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._pings = self._from_here()

    def _from_here(self) -> Iterator[Ping]:
        """Return the walk through the schedule from the firings on that are not yet taken."""
        return islice(pings(self._sonar.firing, len(self._sonar.ring)), self._taken, None)

    def _taken_next(self) -> Ping:
        self._taken += 1
        return next(self._pings)

    def advance(self, state: np.void, control_s: float) -> None:
        """Drive for a control step, fire what is due, and write the state."""
        self._steps += 1 if control_s else 0
        end_s = self._steps * control_s
        turned_rad = self.engine.wheel_turns_rad
        state["fresh"] = 0
        fired: list[int] = []
        # A firing at the very end of a step belongs to it: the newest that can be known.
        while self._next.time_s <= end_s + 1e-9:
            self._fire(state, self._next)
            fired += self._next.sonars
            self._next = self._taken_next()
        self.motion.until(end_s)
        if fired:
            echoes = self._array.detect()
            for name in _DETECTED:
                state[name][fired] = getattr(echoes, name)
            state["fresh"][fired] = 1
        state["time_s"] = end_s
        state["true_pose"] = _columns(self.motion.true_pose)
        state["believed_pose"] = _columns(self.motion.believed_pose)
        state["touched"] = self.motion.touched_since()
        if control_s:
            turned = np.subtract(self.engine.wheel_turns_rad, turned_rad)
            state["wheel_mps"] = turned * WHEEL_RADIUS_M / control_s

    def _fire(self, state: np.void, ping: Ping) -> None:
        self.motion.until(ping.time_s)
        true, numbers = self.motion.true_pose, list(ping.sonars)
        self._array.fire(ping.time_s, ping.sonars, *transducers(self._sonar.ring, true))
        state["fired_s"][numbers] = ping.time_s
        state["fired_true_pose"][numbers] = _columns(true)
        state["fired_pose"][numbers] = _columns(self.motion.believed_pose)


# Fields of a state that hold what a sonar detected.
_DETECTED = [field.name for field in fields(Echoes)]


def _columns(pose: Pose) -> tuple[float, float, float]:
    return pose.x_m, pose.y_m, pose.heading_rad
