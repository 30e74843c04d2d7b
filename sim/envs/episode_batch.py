"""`Team`: robots in their episodes. Physics, task and maps meet here, for one robot or many."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, MultiBinary, Space
from numpy.typing import NDArray

from sim.engines.opening import ENGINES
from sim.envs.actions import action_mode
from sim.envs.backends.compiled.backend import BatchPhysics, is_simple
from sim.envs.backends.engine import EnginePhysics, Physics, Setting
from sim.envs.episodes import EpisodeOptions, check_names, draw_episode
from sim.envs.maps.robot_maps import MAP_MODEL, RobotMaps
from sim.envs.pictures.drawing import Scene
from sim.envs.senses import keep_account, sense
from sim.envs.tasks.task import Briefing, Moment, Task
from sim.runs.drive import check_firing, check_steps
from sim.sonar.protocol import Sonar
from sonarmap import InputError, OccupancyMap
from sonarmap.errors import did_you_mean, positive
from worlds import Pose

__all__ = ["Team", "TeamSpec", "parted"]

# A robot that has touched something for so long without a break is stuck. Assumed.
_STUCK_S = 2.0


@dataclass(frozen=True, slots=True)
class TeamSpec:
    """What stays the same through all episodes.

    Parameters
    ----------
    engine : {"segments", "bullet"}
        What moves the robots and casts their rays.
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
    """

    engine: str = "segments"
    action: str = "velocity"
    map_patch: int = 0
    control_s: float = 0.1
    map_resolution_m: float = 0.1
    map_range_m: float = 3.0

    def __post_init__(self) -> None:
        if self.engine not in ENGINES:
            raise InputError(
                f"engine {self.engine!r} is unknown{did_you_mean(self.engine, ENGINES)}"
            )
        if self.map_patch < 0:
            raise InputError(f"map_patch must be >= 0, got {self.map_patch!r}")
        action_mode(self.action)
        check_steps("control_s", self.control_s)
        positive("map_resolution_m", self.map_resolution_m)
        positive("map_range_m", self.map_range_m)


def parted(arguments: Mapping[str, Any]) -> tuple[TeamSpec, EpisodeOptions]:
    """Return arguments, fields of both by their names, as what stays and what may differ.

    Raises
    ------
    InputError
        If there is no such argument or its value breaks its rule.
    """
    stays = [field.name for field in fields(TeamSpec)]
    differs = [field.name for field in fields(EpisodeOptions)]
    check_names("argument", arguments, [*stays, *differs])
    return (
        TeamSpec(**{name: value for name, value in arguments.items() if name in stays}),
        EpisodeOptions(**{name: value for name, value in arguments.items() if name in differs}),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What a step of a team gives, a row a robot."""

    observations: dict[str, NDArray[Any]]
    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    info: dict[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class _Gear:
    """What depends on the sonar: its kind, itself, the physics that knows it, the maps."""

    kind: tuple[object, ...]
    sonar: Sonar
    physics: Physics
    maps: RobotMaps | None


class Team:
    """Robots in their episodes, independent of each other, all with the same task.

    Parameters
    ----------
    spec : TeamSpec
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
        spec: TeamSpec,
        options: EpisodeOptions,
        make_task: Callable[[int], Task],
        robots: int,
    ) -> None:
        self._spec, self._options, self._robots = spec, options, robots
        self.task = make_task(robots)
        self._actions = action_mode(spec.action)
        self.action_space: Space[Any] = self._actions.space
        self._settings: list[Setting | None] = [None] * robots
        self._last_shares = np.zeros((robots, 2))
        self._touching_s = np.zeros(robots)
        self._gear = self._open(options.sonar)  # type: ignore[arg-type]
        self.observation_space = self._observation_space()

    @property
    def states(self) -> NDArray[np.void]:
        """State of each robot, see `sim.envs.states.robot_dtype`."""
        return self._gear.physics.states

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
        for row, (setting, briefing) in drawn.items():
            self._begin_row(row, setting, briefing)
        if self._gear.maps is not None:
            self._gear.maps.add(self.states, np.array(list(drawn)))

    def step(self, actions: Any, moves: NDArray[np.bool_]) -> Outcome:
        """Drive the robots of the rows that move for one control step.

        Raises
        ------
        gymnasium.error.InvalidAction
            If an action is not in the space.
        """
        shares = self._actions.shares(actions, self._robots)
        wanted_mps = self._actions.wheels_mps(shares)
        self._gear.physics.advance(wanted_mps, moves)
        states = self.states
        if self._gear.maps is not None:
            self._gear.maps.add(states, np.flatnonzero(moves))
        effort = np.empty(self._robots)
        keep_account(
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
        verdict = self.task.judge(Moment(states, stuck, effort, self._gear.maps))
        info = {"reward_terms": verdict.terms, "stuck": stuck, **verdict.info}
        return Outcome(self.observe(), verdict.reward, verdict.terminated, info)

    def observe(self) -> dict[str, NDArray[Any]]:
        """Return what the robots know, new arrays, a row a robot."""
        states, ring, robots = self.states, self._gear.sonar.ring, self._robots
        sensed: dict[str, NDArray[Any]] = {
            "range": np.empty((robots, len(ring)), np.float32),
            "validity": np.empty((robots, len(ring)), np.int8),
            "speed": np.empty((robots, 2), np.float32),
            "last_action": np.empty((robots, 2), np.float32),
        }
        sense(states, self._last_shares, ring.range_max_m, *sensed.values())
        observed = {**sensed, **self.task.observe(states)}
        if self._spec.map_patch:
            maps = self._gear.maps
            assert maps is not None, "a patch needs maps"
            spec = self._spec
            observed["map"] = maps.patches(states, spec.map_patch, spec.map_resolution_m)
        return observed

    def map_of(self, row: int) -> OccupancyMap | None:
        """Return a copy of one robot's map, None if nobody asks for maps."""
        return None if self._gear.maps is None else self._gear.maps.map_of(row)

    def setting_of(self, row: int) -> Setting:
        """Return what one robot's episode began with."""
        setting = self._settings[row]
        assert setting is not None, "asked before begin"
        return setting

    def scene(self, row: int, trail_xy_m: NDArray[np.float64], caption: str) -> Scene:
        """Return what a picture of one robot shows."""
        state, map_ = self.states[row], self.map_of(row)
        return Scene(
            world=self.setting_of(row).world,
            pose=Pose(*state["true_pose"].tolist()),
            believed=Pose(*state["believed_pose"].tolist()),
            ring=self._gear.sonar.ring,
            range_m=state["range_m"].copy(),
            cause=state["cause"].copy(),
            trail_xy_m=trail_xy_m,
            goal_xy_m=self.task.goal_of(row),
            probability=None if map_ is None else map_.probability,
            grid=None if map_ is None else map_.grid,
            caption=caption,
        )

    def close(self) -> None:
        """Release what the engines hold; closing twice is fine."""
        self._gear.physics.close()

    def _open(self, sonar: Sonar) -> _Gear:
        """Open physics and maps that suit a sonar."""
        check_firing(sonar.firing, len(sonar.ring))
        spec, robots = self._spec, self._robots
        physics: Physics
        if spec.engine == "segments" and is_simple(sonar):
            physics = BatchPhysics(sonar, robots, spec.control_s)
        else:
            physics = EnginePhysics(spec.engine, robots, len(sonar.ring), spec.control_s)
        maps = None
        if self.task.needs_maps or spec.map_patch:
            maps = RobotMaps(robots, sonar.ring, MAP_MODEL, spec.map_range_m)
        return _Gear(_kind(sonar), sonar, physics, maps)

    def _change_to(self, sonar: Sonar, robots: int) -> None:
        """Open other physics and maps if those that are open do not suit a sonar."""
        if _kind(sonar) == self._gear.kind:
            return
        before = self._gear
        if len(sonar.ring) != len(before.sonar.ring):
            raise InputError(
                f"sonar {sonar.name!r} must have {len(before.sonar.ring)} sonars, as the "
                f"observation space tells, got {len(sonar.ring)}"
            )
        if robots < self._robots:
            raise InputError(f"sonar {sonar.name!r} needs that all robots are reset together")
        self._gear = self._open(sonar)
        before.physics.close()

    def _begin_row(self, row: int, setting: Setting, briefing: Briefing) -> None:
        self._gear.physics.begin(row, setting)
        self.task.begin(row, briefing)
        if self._gear.maps is not None:
            self._gear.maps.begin(row, briefing.facts)
        self._settings[row] = setting
        self._last_shares[row] = 0.0
        self._touching_s[row] = 0.0

    def _observation_space(self) -> Dict:
        sonars, patch = len(self._gear.sonar.ring), self._spec.map_patch
        spaces: dict[str, Space[Any]] = {
            "range": Box(0.0, 1.0, (sonars,), np.float32),
            "validity": MultiBinary(sonars),
            "speed": Box(-1.0, 1.0, (2,), np.float32),
            "last_action": Box(-1.0, 1.0, (2,), np.float32),
            **self.task.observations,
        }
        if patch:
            spaces["map"] = Box(0, 255, (1, patch, patch), np.uint8)
        return Dict(spaces)


def _kind(sonar: Sonar) -> tuple[object, ...]:
    """Return what physics and maps depend on and cannot change from episode to episode."""
    ring = sonar.ring.to_dict()
    firing = sonar.firing.period_s
    return type(sonar), str(ring), firing, getattr(sonar, "rays", None)
