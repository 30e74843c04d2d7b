"""Physics of an environment: robots that drive and hear, an episode each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from itertools import count
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sim.engines.opening import open_engine
from sim.envs.states import new_states
from sim.robot.amigobot import WHEEL_RADIUS_M
from sim.robot.odometry import Odometer, OdometryModel
from sim.runs.drive import Drive, transducers
from sim.sonar.protocol import Echoes, Sonar
from worlds import Pose, World

__all__ = ["EnginePhysics", "Physics", "Setting"]


@dataclass(frozen=True, eq=False)
class Setting:
    """What an episode begins with.

    Parameters
    ----------
    world : World
        The room.
    start : Pose
        Where the robot begins, clear of every solid.
    sonar : Sonar
        Its sonars.
    odometry : OdometryModel
        Errors of its odometry.
    noise_rng, slip_rng : numpy.random.Generator
        Where the errors of the sonars and of the odometry are drawn from.
    """

    world: World
    start: Pose
    sonar: Sonar
    odometry: OdometryModel
    noise_rng: np.random.Generator
    slip_rng: np.random.Generator


class Physics(Protocol):
    """Robots that drive and hear, one a row."""

    @property
    def states(self) -> NDArray[np.void]:
        """State of each robot (`sim.envs.states.robot_dtype`), changed in place by the others."""

    def begin(self, row: int, setting: Setting) -> None:
        """Begin an episode of one robot; what fires at time 0 is heard."""

    def advance(self, wanted_mps: NDArray[np.float64], moves: NDArray[np.bool_]) -> None:
        """Drive the robots of the rows that move for one control step.

        Parameters
        ----------
        wanted_mps : ndarray, shape (robots, 2)
            Wanted speeds of the left and right wheel.
        moves : ndarray of bool, shape (robots,)
            Which robots; the others stay as they are.
        """

    def close(self) -> None:
        """Release what is held; closing twice is fine."""


class EnginePhysics:
    """Physics on any engine and any sonar, robot by robot.

    Parameters
    ----------
    engine : {"bullet", "segments"}
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

    def begin(self, row: int, setting: Setting) -> None:
        """Begin an episode of one robot; what fires at time 0 is heard."""
        self._leave(row)
        self.states[row] = new_states(1, len(setting.sonar.ring))[0]
        robot = self._robots[row] = _Robot(self._engine, setting)
        robot.advance(self.states[row], 0.0)

    def advance(self, wanted_mps: NDArray[np.float64], moves: NDArray[np.bool_]) -> None:
        """Drive the robots of the rows that move for one control step."""
        for row in np.flatnonzero(moves):
            robot = self._robots[row]
            assert robot is not None, "advanced before begin"
            left_mps, right_mps = wanted_mps[row].tolist()
            robot.drive.speeds_mps = (left_mps, right_mps)
            robot.advance(self.states[row], self._control_s)

    def close(self) -> None:
        """Close the engines; closing twice is fine."""
        for row in range(len(self._robots)):
            self._leave(row)

    def _leave(self, row: int) -> None:
        robot, self._robots[row] = self._robots[row], None
        if robot is not None:
            robot.engine.close()


class _Robot:
    """One robot in its episode."""

    def __init__(self, engine: str, setting: Setting) -> None:
        self.engine = open_engine(engine, setting.world, start=setting.start)
        odometer = Odometer(setting.odometry, setting.start, setting.slip_rng)
        self.drive = Drive(self.engine, odometer)
        self._sonar = setting.sonar
        self._ears = setting.sonar.ears(self.engine, setting.world, setting.noise_rng)
        self._firings = self._all_firings()
        self._next = next(self._firings)
        self._steps = 0

    def advance(self, state: np.void, control_s: float) -> None:
        """Drive for a control step, fire what is due, and write the state."""
        self._steps += 1 if control_s else 0
        end_s = self._steps * control_s
        turned_rad = self.engine.wheel_turns_rad
        state["fresh"] = 0
        fired: list[int] = []
        # A firing at the very end of a step belongs to it: the newest that can be known.
        while self._next[0] <= end_s + 1e-9:
            fired += self._fire(state, *self._next)
            self._next = next(self._firings)
        self.drive.until(end_s)
        if fired:
            echoes = self._ears.hear()
            for name in _HEARD:
                state[name][fired] = getattr(echoes, name)
            state["fresh"][fired] = 1
        state["time_s"] = end_s
        state["true_pose"] = _columns(self.drive.true_pose)
        state["believed_pose"] = _columns(self.drive.believed_pose)
        state["touched"] = self.drive.touched_since()
        if control_s:
            turned = np.subtract(self.engine.wheel_turns_rad, turned_rad)
            state["wheel_mps"] = turned * WHEEL_RADIUS_M / control_s

    def _fire(self, state: np.void, time_s: float, sonars: tuple[int, ...]) -> tuple[int, ...]:
        self.drive.until(time_s)
        true, numbers = self.drive.true_pose, list(sonars)
        self._ears.fire(time_s, sonars, *transducers(self._sonar.ring, true))
        state["fired_s"][numbers] = time_s
        state["fired_true_pose"][numbers] = _columns(true)
        state["fired_pose"][numbers] = _columns(self.drive.believed_pose)
        return sonars

    def _all_firings(self) -> Iterator[tuple[float, tuple[int, ...]]]:
        """Yield the time and the sonars of every firing, for ever."""
        firing, sonars = self._sonar.firing, len(self._sonar.ring)
        for scan in count():
            for slot in firing.slots(scan, sonars):
                yield scan * firing.period_s + slot.offset_s, slot.sonars


# Fields of a state that tell what a sonar heard.
_HEARD = [field.name for field in fields(Echoes)]


def _columns(pose: Pose) -> tuple[float, float, float]:
    return pose.x_m, pose.y_m, pose.heading_rad
