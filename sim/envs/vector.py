"""`SonarVectorEnv`: many robots as one Gymnasium vector environment, a batch in compiled calls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from sim.envs.env import Observation, SonarEnv
from sim.envs.episode_batch import EpisodeBatch, split_arguments
from sonarmap import InputError

__all__ = ["SonarVectorEnv"]


class SonarVectorEnv(VectorEnv[Observation, Any, NDArray[Any]]):
    """Robots in rooms of their own; each does what the single environment does, step for step.

    Robot ``i`` of ``reset(seed=s)`` has the seed ``s + i``. Made by ``gymnasium.make_vec(id,
    num_envs=..., vectorization_mode="vector_entry_point", ...)``.

    Parameters
    ----------
    num_envs : int
        How many robots, >= 1.
    max_episode_steps : int, optional
        Episodes are truncated after so many steps; the registration sets it.
    autoreset_mode : AutoresetMode or str
        "NextStep": the step after the last begins a new episode. "SameStep": the last step
        already returns the first observation of the new episode, and the last one as
        ``final_obs`` in the info.
    weights : object, optional
        Weights of the reward's terms, a frozen value of the task.
    render_mode : None
        Nothing is drawn.
    **arguments
        All others of `sim.envs.SonarEnv`: fields of `sim.envs.BatchSpec` and
        `sim.envs.EpisodeOptions`.
    """

    env_class: ClassVar[type[SonarEnv]] = SonarEnv

    def __init__(
        self,
        num_envs: int = 1,
        *,
        max_episode_steps: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        weights: Any = None,
        render_mode: str | None = None,
        **arguments: Any,
    ) -> None:
        if num_envs < 1:
            raise InputError(f"num_envs must be >= 1, got {num_envs!r}")
        if render_mode is not None:
            raise InputError("render_mode must be None: the vector environment draws nothing")
        try:
            self._same_step = AutoresetMode(autoreset_mode) is AutoresetMode.SAME_STEP
        except ValueError:
            modes = [mode.value for mode in AutoresetMode]
            raise InputError(
                f"autoreset_mode must be one of {modes}, got {autoreset_mode!r}"
            ) from None
        if AutoresetMode(autoreset_mode) is AutoresetMode.DISABLED:
            raise InputError("autoreset_mode must be NextStep or SameStep, got Disabled")
        self.metadata = {**self.env_class.metadata, "autoreset_mode": AutoresetMode(autoreset_mode)}
        self.num_envs = num_envs
        self.render_mode = render_mode
        self._batch = EpisodeBatch(
            *split_arguments(arguments),
            lambda robots: self.env_class.make_task(robots, weights),
            robots=num_envs,
        )
        self.single_observation_space = self._batch.observation_space
        self.single_action_space = self._batch.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._limit = max_episode_steps
        self._rngs: list[np.random.Generator] | None = None
        self._steps = np.zeros(num_envs, np.int64)
        self._done = np.zeros(num_envs, bool)
        self._is_reset = False

    @property
    def batch(self) -> EpisodeBatch:
        """The robots with their backend, task and maps."""
        return self._batch

    @property
    def team(self) -> EpisodeBatch:
        """Former name of `batch`."""
        return self._batch

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin episodes of all robots; see `SonarEnv` for the options."""
        self._check_open()
        self._seed(seed)
        self._begin(np.arange(self.num_envs), options)
        self._is_reset = True
        return self._batch.observe(), self._with_masks({})

    def step(
        self, actions: Any
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Drive all robots for one control step; the actions of robots that begin are ignored."""
        self._check_open()
        if not self._is_reset:
            raise gymnasium.error.ResetNeeded("reset must be called before the first step")
        moves = ~self._done
        begun = np.flatnonzero(self._done)
        self._begin(begun, None)
        outcome = self._batch.step(actions, moves)
        self._steps += moves
        terminated = outcome.terminated & moves
        truncated = np.zeros(self.num_envs, bool)
        if self._limit is not None:
            truncated = moves & (self._steps >= self._limit)
        reward = np.where(moves, outcome.reward, 0.0)
        info, observations = self._with_masks(outcome.info), outcome.observations
        done = terminated | truncated
        if self._same_step:
            if done.any():
                observations, info = self._begun_at_once(done, observations, info)
        else:
            self._done = done
        return observations, reward, terminated, truncated, info

    def close_extras(self, **kwargs: Any) -> None:
        """Release what is held."""
        self._batch.close()

    def _begun_at_once(
        self, done: NDArray[np.bool_], observations: Observation, info: dict[str, Any]
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin the next episodes of robots that are done; keep how the last ones ended."""
        final_obs = np.full(self.num_envs, None, object)
        for row in np.flatnonzero(done):
            final_obs[row] = {name: rows[row].copy() for name, rows in observations.items()}
        self._begin(np.flatnonzero(done), None)
        return self._batch.observe(), {
            **info,
            **self._with_masks({}),
            "final_obs": final_obs,
            "_final_obs": done.copy(),
            "final_info": info,
            "_final_info": done.copy(),
        }

    def _begin(self, rows: NDArray[np.int64], options: dict[str, Any] | None) -> None:
        assert self._rngs is not None
        if rows.size:
            self._batch.begin({int(row): self._rngs[row] for row in rows}, options)
        self._steps[rows] = 0
        self._done[rows] = False

    def _seed(self, seed: int | Sequence[int | None] | None) -> None:
        if isinstance(seed, int | np.integer):
            seeds: list[int | None] = [int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = [None] * self.num_envs if seed is None else list(seed)
        if len(seeds) != self.num_envs:
            raise InputError(
                f"seed must have one number a robot, {self.num_envs}, got {len(seeds)}"
            )
        known: Sequence[np.random.Generator | None] = self._rngs or [None] * self.num_envs
        # As a single environment: without a seed the generator goes on.
        self._rngs = [
            rng if rng is not None and number is None else seeding.np_random(number)[0]
            for rng, number in zip(known, seeds, strict=True)
        ]

    def _with_masks(self, info: Mapping[str, Any]) -> dict[str, Any]:
        """Return an info as Gymnasium's vector environments have it: arrays and their masks."""
        everybody = np.ones(self.num_envs, bool)
        masked: dict[str, Any] = {"true_pose": self._batch.states["true_pose"].copy()}
        masked["_true_pose"] = everybody
        for name, rows in info.items():
            masked[name] = dict(rows) if isinstance(rows, Mapping) else rows
            masked[f"_{name}"] = everybody
        return masked

    def _check_open(self) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError("the environment is closed")
