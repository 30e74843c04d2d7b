"""`SonarEnv`: one robot as a Gymnasium environment, a thin adapter to an `EpisodeBatch` of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from inspect import cleandoc
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.spaces import Space
from numpy.typing import NDArray

from sim.envs.episode_batch import BatchSpec, EpisodeBatch
from sim.envs.episodes import EpisodeOptions, Randomisation, RingChoice, WorldChoice
from sim.envs.infos import of_robot
from sim.envs.maps.method_maps import MapMethod
from sim.envs.pictures.frame_maker import FrameMaker
from sim.envs.pictures.window import Window
from sim.envs.specs import HasSpec
from sim.envs.tasks.task import Task
from sim.robot.odometry import OdometryModel
from sim.sonar.protocol import Sonar
from sonarmap import OccupancyMap
from sonarmap.errors import one_of, whole
from worlds import Pose

__all__ = ["SonarEnv"]

Observation = dict[str, NDArray[Any]]


class SonarEnv(HasSpec, gymnasium.Env[Observation, Any]):
    """A robot with a ring of sonars and a task; what all environments have in common.

    Observation
    -----------
    A dictionary of new arrays, for a ring of k sonars (eight, if nothing else is said):

    ================  ================  =========  ================================================
    ``range``         float32 (k,)      [0, 1]     newest reading of each sonar over its maximum
                                                   range; 1 for no echo, 0 for too close
    ``validity``      float32 (k,)      {0, 1}     1 if that reading is a range
    ``speed``         float32 (2,)      [-1, 1]    speed ahead and turn rate by the encoders over
                                                   0.75 m/s and 0.87 rad/s
    ``last_action``   float32 (2,)      [-1, 1]    shares of the limits that were wanted last
    ``map``           uint8 (1, n, n)   [0, 255]   with ``map_patch=n``: P(occupied) times 255
                                                   around the robot by odometry, ahead is up; 128
                                                   is unknown
    ================  ================  =========  ================================================

    Action
    ------
    ``action="velocity"``: float32 (2,) in [-1, 1], speed ahead over 0.75 m/s and turn rate over
    0.87 rad/s. ``"wheels"``: float32 (2,) in [-1, 1], left and right wheel over 0.75 m/s.
    ``"discrete"``: 0 ahead, 1 and 2 in a curve to the left and right, 3 and 4 turn left and right
    in place, 5 back. Whatever is wanted, the robot's own limits of speed, turn rate and
    acceleration hold (`sim.robot.kinematics.limited_speeds`). A step is ``control_s``, 0.1 s.

    Reward
    ------
    The weighted sum of the task's terms. ``info["reward_terms"]`` has them without their weights.

    Begin, end, faults
    ------------------
    The robot begins at rest in a random place of the room (``start``). Every episode ends when it
    has touched something for 2 s without a break; the task may end it before, and the time limit
    belongs to the registration. An action outside of the space, a step after the end or after
    ``close``, an unknown option and a start in a wall are errors that name the rule.

    Parameters
    ----------
    engine, action, map_patch, control_s, map_resolution_m, map_range_m, map_method
        What stays the same through all episodes, see `sim.envs.BatchSpec`.
    validity, threads
        How an observation is given and a step is made, see `sim.envs.BatchSpec`.
    world, sonar, ring, odometry, start, goal, randomisation
        What may differ from episode to episode, see `sim.envs.EpisodeOptions`. ``reset`` takes
        each of them by its name in ``options``, for that episode; a sonar with as many
        transducers as the observation has.
    weights : object or mapping, optional
        Weights of the reward's terms, a frozen value of the task or a mapping of some of its
        fields.
    render_mode : {"rgb_array", "human"}, optional
        Return frames, all of one even size, or show them in a window (extra ``gui``).

    Versions
    --------
    v1: ``validity`` is a `Box` of float32. v0: it is a `MultiBinary` of int8, which some libraries
    do not take; kept for what was learned with it.

    Notes
    -----
    An environment on `segments` can be copied and pickled at any moment; the copy goes on as the
    original does. One on `bullet` cannot while an episode is under way, and says so.
    """

    task_class: ClassVar[type[Task] | None] = None
    """The task of the robot, see `sim.envs.environments.env_class`."""

    metadata: dict[str, Any] = {  # noqa: RUF012 - so declares Gymnasium
        "render_modes": ["human", "rgb_array"],
        "render_fps": 10,
    }

    def __init__(
        self,
        *,
        engine: str = "segments",
        action: str = "velocity",
        map_patch: int = 0,
        control_s: float = 0.1,
        map_resolution_m: float = 0.1,
        map_range_m: float = 3.0,
        map_method: str | MapMethod | Mapping[str, Any] | None = None,
        validity: str = "box",
        threads: int | str | None = None,
        world: WorldChoice | Sequence[WorldChoice] = EpisodeOptions.world,
        sonar: str | Sonar | Mapping[str, Any] = "aria",
        ring: RingChoice | None = None,
        odometry: OdometryModel | Mapping[str, Any] | None = None,
        start: str | Pose | tuple[float, float, float] = "random",
        goal: str | tuple[float, float] = "random",
        randomisation: Randomisation | Mapping[str, Any] | None = None,
        weights: Any = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            one_of("render_mode", render_mode, self.metadata["render_modes"])
        self.render_mode = render_mode
        self._batch = EpisodeBatch(
            BatchSpec(
                engine=engine,
                action=action,
                map_patch=map_patch,
                control_s=control_s,
                map_resolution_m=map_resolution_m,
                map_range_m=map_range_m,
                map_method=map_method,
                validity=validity,
                threads=threads,
            ),
            EpisodeOptions(world, sonar, ring, odometry, start, goal, randomisation),
            lambda robots: self.make_task(robots, weights),
            robots=1,
        )
        self.observation_space: Space[Any] = self._batch.observation_space
        self.action_space = self._batch.action_space
        self._frames = None if render_mode is None else FrameMaker(self._batch, 1)
        self._window: Window | None = None
        # Why there is nothing to step, if so.
        self._needs_reset = "reset must be called before the first step"
        self._closed = False

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy needs: all but the window, which is this process's."""
        return {**self.__dict__, "_window": None}

    def __init_subclass__(cls) -> None:
        """Let the docstring of an environment be its whole specification."""
        super().__init_subclass__()
        common = cleandoc(SonarEnv.__doc__ or "").partition("\n\n")[2]
        cls.__doc__ = f"{cleandoc(cls.__doc__ or '')}\n\n{common}\n"

    @classmethod
    def make_task(cls, robots: int, weights: Any) -> Task:
        """Return the task of so many robots."""
        if cls.task_class is None:
            raise NotImplementedError(f"{cls.__name__} has no task_class")
        return cls.task_class(robots, cls.task_class.weights_of(weights))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see the class for the options."""
        self._check_open()
        # Gymnasium would take True for a seed, and no number of numpy's.
        super().reset(seed=None if seed is None else whole("seed", seed, least=0))
        self._batch.begin({0: self.np_random}, options)
        self._needs_reset = ""
        if self._frames is not None:
            self._frames.begin([0])
            self._show(self._frames)
        return self._first(self._batch.observe()), self._told({})

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for one control step."""
        self._check_open()
        if self._needs_reset:
            raise gymnasium.error.ResetNeeded(self._needs_reset)
        outcome = self._batch.step(action, np.ones(1, bool))
        reward, terminated = float(outcome.reward[0]), bool(outcome.terminated[0])
        if terminated:
            self._needs_reset = "the episode has ended: reset must be called before the next step"
        if self._frames is not None:
            self._frames.step([0], outcome.reward)
            self._show(self._frames)
        info = self._told(outcome.info)
        return self._first(outcome.observations), reward, terminated, False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a frame of shape (height, width, 3), or None when a window shows it."""
        self._check_open()
        if self._frames is None:
            gymnasium.logger.warn("render was called, but render_mode is None: nothing is drawn")
            return None
        return self._frames.frame(0) if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Release what is held; closing twice is fine."""
        self._closed = True
        self._batch.close()
        if self._window is not None:
            self._window.close()

    @property
    def batch(self) -> EpisodeBatch:
        """The robot with its backend, task and map, for wrappers that look behind the sonars."""
        return self._batch

    @property
    def team(self) -> EpisodeBatch:
        """Former name of `batch`."""
        return self._batch

    @property
    def occupancy_map(self) -> OccupancyMap | None:
        """A copy of the map so far; None if neither the task nor the observation needs one."""
        return self._batch.map_of(0)

    def _check_open(self) -> None:
        if self._closed:
            raise gymnasium.error.ClosedEnvironmentError("the environment is closed")

    def _first(self, observations: Observation) -> Observation:
        return {name: rows[0] for name, rows in observations.items()}

    def _told(self, info: Mapping[str, Any]) -> dict[str, Any]:
        return of_robot({**info, "true_pose": self._batch.states["true_pose"]}, 0)

    def _show(self, frames: FrameMaker) -> None:
        if self.render_mode == "human":
            self._window = self._window or Window(fps=self.metadata["render_fps"])
            self._window.show(frames.frame(0))
