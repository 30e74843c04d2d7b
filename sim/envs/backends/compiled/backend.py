"""`CompiledBackend`: many robots with simple cones at once, on the faces of their rooms."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sim.envs.backends.compiled.cone import RingGeometry
from sim.envs.backends.compiled.stepping import (
    Draws,
    advance,
    advance_alone,
    body_dtype,
)
from sim.envs.backends.protocol import EpisodeSetup
from sim.envs.rooms import Rooms
from sim.envs.states import new_states
from sim.envs.threads import in_parts
from sim.robot.clock import physics_steps
from sim.robot.odometry import drawn_errors
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.protocol import Sonar
from sonarmap import InputError
from worlds import World

__all__ = ["CompiledBackend"]

# Random numbers are drawn for so many control steps at once.
_STEPS_AHEAD = 64


class CompiledBackend:
    """What `EngineBackend` does on `segments` with simple cones, in a few compiled calls.

    Parameters
    ----------
    sonar : Sonar
        One that is a simple cone when compiled. Its ring, rays and firing period all robots share;
        noise, materials and threshold may differ between episodes.
    robots : int
        How many.
    control_s : float
        Length of a control step, a multiple of `sim.robot.amigobot.PHYSICS_DT_S`.
    threads : int
        How many threads advance them.
    """

    def __init__(self, sonar: Sonar, robots: int, control_s: float, threads: int = 1) -> None:
        self._threads = threads
        ring, sonars = sonar.ring, len(sonar.ring)
        rays = _cone_of(sonar).rays
        self._steps = physics_steps(control_s)
        self._period = physics_steps(sonar.firing.period_s)
        self.states = new_states(robots, sonars)
        self._bodies = np.zeros(robots, body_dtype())
        self._rooms = Rooms(robots)
        half_rad = ring.half_angle_rad
        bearing_rad = np.linspace(-half_rad, half_rad, 0 if rays is None else rays)
        mounts = np.column_stack([ring.x_m, ring.y_m, ring.heading_rad])
        self._ring = RingGeometry(mounts, half_rad, np.cos(bearing_rad), np.sin(bearing_rad))
        self._materials = np.zeros((robots, 3, 1))
        firings = math.ceil(_STEPS_AHEAD * self._steps / self._period) + 1
        self._noise = _Normals(robots, firings, sonars)
        # Of a step there is one move to each firing in it and one to its end.
        self._slip = _Normals(robots, firings + _STEPS_AHEAD, 2)
        self._draws = Draws(self._noise.values, self._slip.values)
        # Control steps for which there are random numbers yet.
        self._ahead = np.zeros(robots, np.int64)

    def begin(self, row: int, setup: EpisodeSetup) -> None:
        """Begin an episode of one robot; what fires at time 0 is read."""
        start, cone = setup.start, _cone_of(setup.sonar)
        state, body = self.states[row], self._bodies[row]
        state["true_pose"] = state["believed_pose"] = start.x_m, start.y_m, start.heading_rad
        state["wheel_mps"] = 0.0
        body["room"] = self._rooms.enter(row, setup.world)
        for name in ("turns_rad", "speeds_mps", "ticks", "steps", "next_firing"):
            body[name] = 0
        body["odometry"] = drawn_errors(setup.odometry, setup.slip_rng)
        body["firing_period"] = self._period
        for name in ("noise_std_m", "scale", "quantum_m", "silent_m", "threshold", "max_bounces"):
            body[name] = getattr(cone, name)
        body["near_m"] = setup.sonar.ring.range_min_m
        body["far_m"] = setup.sonar.ring.range_max_m
        self._set_materials(row, setup.world, cone)
        self._noise.begin(row, setup.noise_rng)
        self._slip.begin(row, setup.slip_rng)
        body["noises"] = body["slips"] = 0
        self._ahead[row] = _STEPS_AHEAD
        self._call(advance_alone, np.zeros((len(self.states), 2)), 0, row)

    def advance(self, wanted_mps: NDArray[np.float64], moves: NDArray[np.bool_]) -> None:
        """Drive the robots of the rows that move for one control step."""
        rows = np.flatnonzero(moves)
        for row in rows[self._ahead[rows] == 0]:
            body = self._bodies[row]
            self._noise.draw(row, body["noises"])
            self._slip.draw(row, body["slips"])
            body["noises"] = body["slips"] = 0
            self._ahead[row] = _STEPS_AHEAD
        self._ahead[rows] -= 1
        if rows.size == 1:
            self._call(advance_alone, wanted_mps, self._steps, rows[0])
        elif rows.size:

            def some(begin: int, end: int, _: int) -> None:
                self._call(advance, wanted_mps, self._steps, rows[begin:end])

            in_parts(some, rows.size, self._threads)

    def close(self) -> None:
        """Do nothing: there is nothing to release."""

    def _call(
        self,
        kernel: Callable[..., None],
        wanted_mps: NDArray[np.float64],
        steps: int,
        rows: NDArray[np.int64] | int,
    ) -> None:
        table = self._rooms.table
        assert table is not None, "advanced before begin"
        kernel(
            tuple(table),
            self.states,
            self._bodies,
            self._materials,
            tuple(self._ring),
            tuple(self._draws),
            wanted_mps,
            steps,
            rows,
        )

    def _set_materials(self, row: int, world: World, cone: CompiledCone) -> None:
        robots, _, surfaces = self._materials.shape
        if surfaces < self._rooms.surfaces:
            grown = np.zeros((robots, 3, self._rooms.surfaces))
            grown[:, :, :surfaces] = self._materials
            self._materials = grown
        self._materials[row, :, : len(world.solids)] = cone.materials(world)


def _cone_of(sonar: Sonar) -> CompiledCone:
    cone = sonar.compiled()
    if not isinstance(cone, CompiledCone):
        raise InputError(f"sonar {sonar.name!r} must be a simple cone to be compiled")
    return cone


class _Normals:
    """Standard normal numbers drawn ahead, of each robot from its own generator.

    They come in the order in which the robot would draw them one by one.
    """

    def __init__(self, robots: int, rows: int, columns: int) -> None:
        self.values = np.zeros((robots, rows, columns))
        self._rngs: list[np.random.Generator | None] = [None] * robots

    def begin(self, robot: int, rng: np.random.Generator) -> None:
        """Draw the first numbers of an episode."""
        self._rngs[robot] = rng
        self.draw(robot, len(self.values[robot]))

    def draw(self, robot: int, used: int) -> None:
        """Keep the rows that are not used up, and draw as many as are."""
        of_robot, rng = self.values[robot], self._rngs[robot]
        assert rng is not None, "drawn before begin"
        left = len(of_robot) - used
        of_robot[:left] = of_robot[used:]
        of_robot[left:] = rng.normal(size=(used, of_robot.shape[1]))
