"""`SonarEnv`: one robot as a Gymnasium environment, a thin adapter to a `Team` of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from sim.acoustics import Sonar
from sim.envs.drawing import draw
from sim.envs.episodes import EpisodeOptions, Randomisation, WorldChoice
from sim.envs.tasks.task import Task
from sim.envs.team import Team, TeamSpec
from sim.envs.window import Window
from sim.odometry import OdometryModel
from sonarmap import InputError, OccupancyMap
from sonarmap.errors import did_you_mean

__all__ = ["SonarEnv"]

Observation = dict[str, NDArray[Any]]


class SonarEnv(gymnasium.Env[Observation, Any]):
    """A robot with sonars and a task; see the environments for what they ask.

    Parameters
    ----------
    engine, action, map_patch, control_s, map_resolution_m, map_range_m
        What stays the same through all episodes, see `sim.envs.TeamSpec`.
    world, sonar, odometry, start, goal, randomisation
        What may differ from episode to episode, see `sim.envs.EpisodeOptions`. ``reset`` takes
        each of them by its name in ``options``, for that episode.
    weights : object, optional
        Weights of the reward's terms, a frozen value of the task.
    render_mode : {"rgb_array", "human"}, optional
        Return frames, or show them in a window (extra ``gui``).
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["human", "rgb_array"], "render_fps": 10}

    def __init__(
        self,
        *,
        engine: str = "segments",
        action: str = "velocity",
        map_patch: int = 0,
        control_s: float = 0.1,
        map_resolution_m: float = 0.1,
        map_range_m: float = 3.0,
        world: WorldChoice | Sequence[WorldChoice] = EpisodeOptions.world,
        sonar: str | Sonar = "aria",
        odometry: OdometryModel | None = None,
        start: str | tuple[float, float, float] = "random",
        goal: str | tuple[float, float] = "random",
        randomisation: Randomisation | Mapping[str, Any] | None = None,
        weights: Any = None,
        render_mode: str | None = None,
    ) -> None:
        modes = self.metadata["render_modes"]
        if render_mode is not None and render_mode not in modes:
            raise InputError(
                f"render_mode {render_mode!r} is unknown{did_you_mean(render_mode, modes)}"
            )
        self.render_mode = render_mode
        self._team = Team(
            TeamSpec(engine, action, map_patch, control_s, map_resolution_m, map_range_m),
            EpisodeOptions(world, sonar, odometry, start, goal, randomisation),
            lambda robots: self._make_task(robots, weights),
            robots=1,
        )
        self.observation_space = self._team.observation_space
        self.action_space = self._team.action_space
        self._window: Window | None = None
        self._trail: list[tuple[float, float]] = []
        self._score = 0.0
        # Why there is nothing to step, if so.
        self._needs_reset = "reset must be called before the first step"
        self._closed = False

    @classmethod
    def _make_task(cls, robots: int, weights: Any) -> Task:
        raise NotImplementedError

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; see the class for the options."""
        self._check_open()
        super().reset(seed=seed)
        self._team.begin({0: self.np_random}, options)
        self._trail, self._score, self._needs_reset = [], 0.0, ""
        observation = self._first(self._team.observe())
        self._show()
        return observation, {"true_pose": self._team.states["true_pose"][0].copy()}

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for one control step."""
        self._check_open()
        if self._needs_reset:
            raise gymnasium.error.ResetNeeded(self._needs_reset)
        outcome = self._team.step(action, np.ones(1, bool))
        reward, terminated = float(outcome.reward[0]), bool(outcome.terminated[0])
        if terminated:
            self._needs_reset = "the episode has ended: reset must be called before the next step"
        self._score += reward
        self._show()
        info = first_row(outcome.info)
        info["true_pose"] = self._team.states["true_pose"][0].copy()
        return self._first(outcome.observations), reward, terminated, False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a frame of shape (height, width, 3), or None when a window shows it."""
        self._check_open()
        if self.render_mode is None:
            gymnasium.logger.warn("render was called, but render_mode is None: nothing is drawn")
            return None
        return self._frame() if self.render_mode == "rgb_array" else None

    def close(self) -> None:
        """Release what is held; closing twice is fine."""
        self._closed = True
        self._team.close()
        if self._window is not None:
            self._window.close()

    @property
    def team(self) -> Team:
        """The robot with its physics, task and map, for wrappers that look behind the sonars."""
        return self._team

    @property
    def occupancy_map(self) -> OccupancyMap | None:
        """A copy of the map so far; None if neither the task nor the observation needs one."""
        return self._team.map_of(0)

    def _check_open(self) -> None:
        if self._closed:
            raise gymnasium.error.ClosedEnvironmentError("the environment is closed")

    def _first(self, observations: Observation) -> Observation:
        return {name: rows[0] for name, rows in observations.items()}

    def _show(self) -> None:
        if self.render_mode is None:
            return
        x_m, y_m, _ = self._team.states["true_pose"][0].tolist()
        self._trail.append((x_m, y_m))
        if self.render_mode == "human":
            self._window = self._window or Window(fps=self.metadata["render_fps"])
            self._window.show(self._frame())

    def _frame(self) -> NDArray[np.uint8]:
        if not self._trail:
            raise gymnasium.error.ResetNeeded("reset must be called before the first frame")
        time_s = float(self._team.states["time_s"][0])
        caption = f"{time_s:.1f} s · reward {self._score:.2f}"
        return draw(self._team.scene(0, np.array(self._trail), caption))


def first_row(info: Mapping[str, Any]) -> dict[str, Any]:
    """Return the first robot's part of a team's info as plain numbers."""
    return {
        name: first_row(rows) if isinstance(rows, Mapping) else rows[0].item()
        for name, rows in info.items()
    }
