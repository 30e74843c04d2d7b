"""`EpisodeBatch`: robots in their episodes. Backend, task and maps meet here, for one or many."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, MultiBinary, Space
from numpy.typing import NDArray

from sim.engines.opening import ENGINES
from sim.envs.actions import action_mode
from sim.envs.backends.compiled.backend import CompiledBackend
from sim.envs.backends.engine import EngineBackend
from sim.envs.backends.protocol import Backend, EpisodeSetup
from sim.envs.episodes import EpisodeOptions, draw_episode
from sim.envs.maps.grids import MapGrids
from sim.envs.maps.method_maps import MapMethod, map_method, maps_by
from sim.envs.pictures.drawing import Scene
from sim.envs.pictures.layout import panel_aspect
from sim.envs.senses import record_step, sense
from sim.envs.tasks.task import StepOutcome, Task, TaskSetup
from sim.envs.threads import threads_for
from sim.envs.values import check_names
from sim.robot.clock import check_steps
from sim.sonar.cone.compiled import CompiledCone
from sim.sonar.firing import check_firing
from sim.sonar.protocol import Sonar
from sonarmap import InputError, OccupancyMap
from sonarmap.errors import one_of, positive, whole
from worlds import Pose

__all__ = ["BatchSpec", "EpisodeBatch", "TeamSpec", "split_arguments"]

# A robot that has touched something for so long without a break is stuck. Assumed.
_STUCK_S = 2.0
# More than this is a slip: a patch of 100 m, a step in which a robot crosses a room.
_PATCH_MAX, _CONTROL_MAX_S = 1000, 10.0
# How `validity` may be observed, as a space and as numbers.
_VALIDITY = {"box": np.float32, "multibinary": np.int8}


@dataclass(frozen=True, slots=True)
class BatchSpec:
    """What stays the same through all episodes.

    Parameters
    ----------
    engine : str
        What moves the robots and casts their rays: "segments", "bullet", or another that
        `sim.engines.opening.open_engine` knows.
    action : {"velocity", "wheels", "discrete"}
        What actions mean, see `sim.envs.actions`.
    map_patch : int
        Observe so many by so many cells of the map around the robot; 0 for none.
    control_s : float
        Length of a step of the environment, seconds, a multiple of 5 ms.
    map_resolution_m : float
        Side of a cell of the robot's map, metres, > 0.
    map_range_m : float
        Longer readings are not mapped, metres, > 0; by default the maximum range of the thesis's
        robot (Rashid 2006, p. 56).
    map_method : str, MappingMethod, mapping or None
        How a robot maps as it drives, see `sim.envs.maps.method_maps.map_method`: any method that
        takes readings one at a time. By default Bayesian updating with
        `sim.envs.maps.robot_maps.MAP_MODEL`.
    validity : {"box", "multibinary"}
        The space of the observation of this name: numbers 0 and 1 as a `Box` of float32, which
        every library takes, or as the `MultiBinary` of the ids ``-v0``.
    threads : int or "all", optional
        How many threads step the robots; by default as `sim.envs.threads` decides.
    """

    engine: str = "segments"
    action: str = "velocity"
    map_patch: int = 0
    control_s: float = 0.1
    map_resolution_m: float = 0.1
    map_range_m: float = 3.0
    map_method: str | MapMethod | Mapping[str, Any] | None = None
    validity: str = "box"
    threads: int | str | None = None

    def __post_init__(self) -> None:
        def accept(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        ENGINES.find(self.engine)
        accept("map_patch", whole("map_patch", self.map_patch, least=0))
        if self.map_patch > _PATCH_MAX:
            raise InputError(f"map_patch must be <= {_PATCH_MAX}, got {self.map_patch!r}")
        action_mode(self.action)
        accept("control_s", positive("control_s", self.control_s))
        check_steps("control_s", self.control_s)
        if self.control_s > _CONTROL_MAX_S:
            raise InputError(f"control_s must be <= {_CONTROL_MAX_S:g} s, got {self.control_s!r}")
        accept("map_resolution_m", positive("map_resolution_m", self.map_resolution_m))
        accept("map_range_m", positive("map_range_m", self.map_range_m))
        accept("map_method", map_method(self.map_method))
        one_of("validity", self.validity, _VALIDITY)
        threads_for(self.threads, 1)


TeamSpec = BatchSpec
"""Former name of `BatchSpec`."""


def split_arguments(arguments: Mapping[str, Any]) -> tuple[BatchSpec, EpisodeOptions]:
    """Return arguments, fields of both by their names, as what stays and what may differ.

    Raises
    ------
    InputError
        If there is no such argument or its value breaks its rule.
    """
    stays = [field.name for field in fields(BatchSpec)]
    differs = [field.name for field in fields(EpisodeOptions)]
    check_names("argument", arguments, [*stays, *differs])
    return (
        BatchSpec(**{name: value for name, value in arguments.items() if name in stays}),
        EpisodeOptions(**{name: value for name, value in arguments.items() if name in differs}),
    )


@dataclass(frozen=True, slots=True, eq=False)
class BatchStep:
    """What a step of a batch gives, a row a robot."""

    observations: dict[str, NDArray[Any]]
    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    info: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class _SonarParts:
    """What depends on the sonar: itself, the backend that knows it, the maps."""

    fixed: tuple[object, ...]
    sonar: Sonar
    backend: Backend
    maps: MapGrids | None


class EpisodeBatch:
    """Robots in their episodes, independent of each other, all with the same task.

    Parameters
    ----------
    spec : BatchSpec
        What stays the same through all episodes.
    options : EpisodeOptions
        What may differ between them, if a reset says nothing else.
    make_task : callable
        Returns the task of so many robots.
    robots : int
        How many.
    """

    def __init__(
        self,
        spec: BatchSpec,
        options: EpisodeOptions,
        make_task: Callable[[int], Task],
        robots: int,
    ) -> None:
        self._spec, self._options, self._robots = spec, options, robots
        self._threads = threads_for(spec.threads, robots)
        self.task = make_task(robots)
        self._actions = action_mode(spec.action)
        # A copy: a space has a generator of its own.
        self.action_space: Space[Any] = deepcopy(self._actions.space)
        self._setups: list[EpisodeSetup | None] = [None] * robots
        self._last_shares = np.zeros((robots, 2))
        self._touching_s = np.zeros(robots)
        self._parts = self._open(options.sonar)  # type: ignore[arg-type]
        self.observation_space = self._observation_space()

    @property
    def states(self) -> NDArray[np.void]:
        """State of each robot, see `sim.envs.states.robot_dtype`."""
        return self._parts.backend.states

    def begin(
        self, rngs: Mapping[int, np.random.Generator], options: Mapping[str, Any] | None
    ) -> None:
        """Begin new episodes of some robots.

        Parameters
        ----------
        rngs : mapping of int to numpy.random.Generator
            Row of each robot and where its episode is drawn from.
        options : mapping, optional
            Fields of `EpisodeOptions` that differ this once.
        """
        chosen = self._options.updated(options)
        self._change_to(chosen.sonar, len(rngs))  # type: ignore[arg-type]
        drawn = {
            row: draw_episode(chosen, self._spec.map_resolution_m, rng) for row, rng in rngs.items()
        }
        for row, (setup, task_setup) in drawn.items():
            self._begin_row(row, setup, task_setup)
        if self._parts.maps is not None:
            self._parts.maps.add(self.states, np.array(list(drawn)))

    def step(self, actions: Any, moves: NDArray[np.bool_]) -> BatchStep:
        """Drive the robots of the rows that move for one control step.

        Raises
        ------
        gymnasium.error.InvalidAction
            If an action is not in the space.
        """
        shares = self._actions.shares(actions, self._robots)
        wanted_mps = self._actions.wheels_mps(shares)
        self._parts.backend.advance(wanted_mps, moves)
        states = self.states
        if self._parts.maps is not None:
            self._parts.maps.add(states, np.flatnonzero(moves))
        effort = np.empty(self._robots)
        record_step(
            states,
            moves,
            shares,
            wanted_mps,
            self._spec.control_s,
            self._last_shares,
            self._touching_s,
            effort,
        )
        stuck = self._touching_s >= _STUCK_S - 1e-9
        evaluation = self.task.evaluate(StepOutcome(states, stuck, effort, self._parts.maps))
        info = {"reward_terms": evaluation.terms, "stuck": stuck, **evaluation.info}
        return BatchStep(self.observe(), evaluation.reward, evaluation.terminated, info)

    def observe(self) -> dict[str, NDArray[Any]]:
        """Return what the robots know, new arrays, a row a robot."""
        states, ring, robots = self.states, self._parts.sonar.ring, self._robots
        sensed: dict[str, NDArray[Any]] = {
            "range": np.empty((robots, len(ring)), np.float32),
            "validity": np.empty((robots, len(ring)), _VALIDITY[self._spec.validity]),
            "speed": np.empty((robots, 2), np.float32),
            "last_action": np.empty((robots, 2), np.float32),
        }
        sense(states, self._last_shares, ring.range_max_m, *sensed.values())
        observed = {**sensed, **self.task.observe(states)}
        if self._spec.map_patch:
            maps = self._parts.maps
            assert maps is not None, "a patch needs maps"
            spec = self._spec
            observed["map"] = maps.patches(states, spec.map_patch, spec.map_resolution_m)
        return observed

    def map_of(self, row: int) -> OccupancyMap | None:
        """Return a copy of one robot's map, None if nobody asks for maps."""
        return None if self._parts.maps is None else self._parts.maps.map_of(row)

    def setup_of(self, row: int) -> EpisodeSetup:
        """Return what one robot's episode began with."""
        setup = self._setups[row]
        assert setup is not None, "asked before begin"
        return setup

    def scene(self, row: int, trail_xy_m: NDArray[np.float64], caption: str) -> Scene:
        """Return what a picture of one robot shows."""
        state, map_ = self.states[row], self.map_of(row)
        return Scene(
            world=self.setup_of(row).world,
            pose=Pose(*state["true_pose"].tolist()),
            believed=Pose(*state["believed_pose"].tolist()),
            ring=self._parts.sonar.ring,
            range_m=state["range_m"].copy(),
            cause=state["cause"].copy(),
            trail_xy_m=trail_xy_m,
            goal_xy_m=self.task.goal_of(row),
            probability=None if map_ is None else map_.probability,
            grid=None if map_ is None else map_.grid,
            caption=caption,
            aspect=panel_aspect(self._options.world),  # type: ignore[arg-type]
        )

    def close(self) -> None:
        """Release what the engines hold; closing twice is fine."""
        self._parts.backend.close()

    def _open(self, sonar: Sonar) -> _SonarParts:
        """Open the backend and the maps that suit a sonar."""
        check_firing(sonar.firing, len(sonar.ring))
        spec, robots = self._spec, self._robots
        backend: Backend
        if spec.engine == "segments" and isinstance(sonar.compiled(), CompiledCone):
            backend = CompiledBackend(sonar, robots, spec.control_s, self._threads)
        else:
            backend = EngineBackend(spec.engine, robots, len(sonar.ring), spec.control_s)
        maps = None
        if self.task.needs_maps or spec.map_patch:
            chosen: MapMethod = spec.map_method  # type: ignore[assignment]  # its check made it one
            maps = maps_by(chosen, robots, sonar.ring, spec.map_range_m, self._threads)
        return _SonarParts(_fixed_by(sonar), sonar, backend, maps)

    def _change_to(self, sonar: Sonar, robots: int) -> None:
        """Open another backend and maps if those that are open do not suit a sonar."""
        # Whatever of it differs: what is fixed may be the same and the order of firing not.
        check_firing(sonar.firing, len(sonar.ring))
        if _fixed_by(sonar) == self._parts.fixed:
            return
        before = self._parts
        if len(sonar.ring) != len(before.sonar.ring):
            raise InputError(
                f"sonar {sonar.name!r} must have {len(before.sonar.ring)} sonars, as the "
                f"observation space says, got {len(sonar.ring)}"
            )
        if robots < self._robots:
            raise InputError(f"sonar {sonar.name!r} needs that all robots are reset together")
        self._parts = self._open(sonar)
        before.backend.close()

    def _begin_row(self, row: int, setup: EpisodeSetup, task_setup: TaskSetup) -> None:
        self._parts.backend.begin(row, setup)
        self.task.begin(row, task_setup)
        if self._parts.maps is not None:
            self._parts.maps.begin(row, task_setup.facts)
        self._setups[row] = setup
        self._last_shares[row] = 0.0
        self._touching_s[row] = 0.0

    def _observation_space(self) -> Dict:
        sonars, patch = len(self._parts.sonar.ring), self._spec.map_patch
        spaces: dict[str, Space[Any]] = {
            "range": Box(0.0, 1.0, (sonars,), np.float32),
            "validity": Box(0.0, 1.0, (sonars,), np.float32)
            if self._spec.validity == "box"
            else MultiBinary(sonars),
            "speed": Box(-1.0, 1.0, (2,), np.float32),
            "last_action": Box(-1.0, 1.0, (2,), np.float32),
            # Copies: a space has a generator of its own.
            **deepcopy(dict(self.task.observations)),
        }
        if patch:
            spaces["map"] = Box(0, 255, (1, patch, patch), np.uint8)
        return Dict(spaces)


def _fixed_by(sonar: Sonar) -> tuple[object, ...]:
    """Return what a sonar fixes of backend and maps, which cannot change while they are open."""
    cone = sonar.compiled()
    rays = cone.rays if isinstance(cone, CompiledCone) else None
    return str(sonar.ring.to_dict()), sonar.firing.period_s, rays
