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
from sim.envs.infos import gathered
from sim.envs.pictures.frame_maker import FrameMaker
from sim.envs.specs import HasSpec
from sonarmap import InputError
from sonarmap.errors import one_of, whole

__all__ = ["SonarVectorEnv"]

_RENDER_MODES = ("rgb_array",)


class SonarVectorEnv(HasSpec, VectorEnv[Observation, Any, NDArray[Any]]):
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
        ``final_obs`` in the info. "Disabled": whoever steps resets those that are done, with
        ``options={"reset_mask": ...}``.
    weights : object or mapping, optional
        Weights of the reward's terms, see `SonarEnv`.
    render_mode : {"rgb_array"}, optional
        `render` returns a frame of each robot, all of one even size.
    **arguments
        All others of `sim.envs.SonarEnv`: fields of `sim.envs.BatchSpec` and
        `sim.envs.EpisodeOptions`.

    Notes
    -----
    Infos are those of Gymnasium's own vector environment of single ones, key by key: arrays, zero
    for robots that do not say a thing, and beside each ``name`` its mask ``_name``.
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
        self.num_envs = whole("num_envs", num_envs, least=1)
        if max_episode_steps is not None:
            max_episode_steps = whole("max_episode_steps", max_episode_steps, least=1)
        if render_mode is not None:
            one_of("render_mode", render_mode, _RENDER_MODES)
        try:
            self._mode = AutoresetMode(autoreset_mode)
        except ValueError:
            modes = [mode.value for mode in AutoresetMode]
            raise InputError(
                f"autoreset_mode must be one of {modes}, got {autoreset_mode!r}"
            ) from None
        self.metadata = {
            **self.env_class.metadata,
            "render_modes": list(_RENDER_MODES),
            "autoreset_mode": self._mode,
        }
        self.render_mode = render_mode
        self._batch = EpisodeBatch(
            *split_arguments(arguments),
            lambda robots: self.env_class.make_task(robots, weights),
            robots=self.num_envs,
        )
        self.single_observation_space = self._batch.observation_space
        self.single_action_space = self._batch.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._limit = max_episode_steps
        self._rngs: list[np.random.Generator | None] = [None] * self.num_envs
        self._seeds: list[int | None] = [None] * self.num_envs
        self._steps = np.zeros(self.num_envs, np.int64)
        self._done = np.zeros(self.num_envs, bool)
        # Whose first episode has begun.
        self._begun = np.zeros(self.num_envs, bool)
        # To keep the trails of thousands of robots costs time that only a picture is worth.
        self._frames = None if render_mode is None else FrameMaker(self._batch, self.num_envs)

    @property
    def batch(self) -> EpisodeBatch:
        """The robots with their backend, task and maps."""
        return self._batch

    @property
    def team(self) -> EpisodeBatch:
        """Former name of `batch`."""
        return self._batch

    @property  # type: ignore[misc]  # Gymnasium's own has tuples, too, and sets none of them
    def np_random(self) -> tuple[np.random.Generator | None, ...]:  # type: ignore[override]
        """The generators of the robots, as Gymnasium's own vector environment has them."""
        return tuple(self._rngs)

    @property
    def np_random_seed(self) -> tuple[int | None, ...]:  # type: ignore[override]
        """The seeds of the robots' generators."""
        return tuple(self._seeds)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin episodes.

        Parameters
        ----------
        seed : int or sequence of int or None, optional
            Of robot i it is ``seed + i``, or the i-th number. Without one its generator goes on.
        options : dict, optional
            See `SonarEnv`. ``reset_mask``, an array of bool of shape (num_envs,), says which
            robots begin episodes, at least one; by default all.

        Raises
        ------
        InputError
            If an option or a seed breaks its rule.
        """
        self._check_open()
        of_episodes = dict(options) if isinstance(options, Mapping) else options
        rows = np.ones(self.num_envs, bool)
        if of_episodes and "reset_mask" in of_episodes:
            rows = self._checked_mask(of_episodes.pop("reset_mask"))
        self._seed(seed, rows)
        self._begin(np.flatnonzero(rows), of_episodes)
        return self._batch.observe(), gathered(self._with_poses({}), rows)

    def step(
        self, actions: Any
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Drive all robots for one control step; the actions of robots that begin are ignored.

        Raises
        ------
        gymnasium.error.ResetNeeded
            If a robot has no episode: `reset` was not called, or with "Disabled" not since its
            last one ended.
        """
        self._check_open()
        if not self._begun.all():
            raise gymnasium.error.ResetNeeded("reset must be called before the first step")
        begun = np.flatnonzero(self._done)
        if begun.size and self._mode is AutoresetMode.DISABLED:
            raise gymnasium.error.ResetNeeded(
                f"the episodes of the robots {begun.tolist()} have ended: reset must be called "
                'with options={"reset_mask": ...} before the next step'
            )
        moves = ~self._done
        self._begin(begun, None)
        outcome = self._batch.step(_without(actions, begun, self.num_envs), moves)
        self._steps += moves
        terminated = outcome.terminated & moves
        truncated = np.zeros(self.num_envs, bool)
        if self._limit is not None:
            truncated = moves & (self._steps >= self._limit)
        reward = np.where(moves, outcome.reward, 0.0)
        if self._frames is not None:
            self._frames.step(np.flatnonzero(moves).tolist(), reward)
        self._done = terminated | truncated
        info, observations = self._with_poses(outcome.info), outcome.observations
        told = gathered(info, moves)
        if begun.size:
            told |= gathered(self._with_poses({}), np.ones(self.num_envs, bool))
        if self._mode is AutoresetMode.SAME_STEP and self._done.any():
            observations, told = self._begun_at_once(observations, info)
        return observations, reward, terminated, truncated, told

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a frame of each robot, shape (height, width, 3), all of one size."""
        self._check_open()
        if self._frames is None:
            gymnasium.logger.warn("render was called, but render_mode is None: nothing is drawn")
            return None
        return tuple(self._frames.frame(row) for row in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Release what is held."""
        self._batch.close()

    def _begun_at_once(
        self, observations: Observation, info: Mapping[str, Any]
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin the next episodes of robots that are done; keep how the last ones ended."""
        done = self._done.copy()
        final_obs = np.full(self.num_envs, None, object)
        for row in np.flatnonzero(done):
            final_obs[row] = {name: rows[row].copy() for name, rows in observations.items()}
        final_info, told = gathered(info, done), gathered(info, ~done)
        self._begin(np.flatnonzero(done), None)
        return self._batch.observe(), {
            **told,
            **gathered(self._with_poses({}), np.ones(self.num_envs, bool)),
            "final_obs": final_obs,
            "_final_obs": done,
            "final_info": final_info,
            "_final_info": done.copy(),
        }

    def _begin(self, rows: NDArray[np.int64], options: dict[str, Any] | None) -> None:
        if not rows.size:
            return
        rngs = {int(row): self._rngs[row] for row in rows}
        self._batch.begin(rngs, options)
        self._steps[rows] = 0
        self._done[rows] = False
        self._begun[rows] = True
        if self._frames is not None:
            self._frames.begin(rows.tolist())

    def _checked_mask(self, mask: Any) -> NDArray[np.bool_]:
        """Return which robots shall begin, under the rules of Gymnasium's vector environments."""
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_:
            raise InputError(f"reset_mask must be an array of bool, got {mask!r}")
        if mask.shape != (self.num_envs,):
            raise InputError(f"reset_mask must have shape ({self.num_envs},), got {mask.shape}")
        if not mask.any():
            raise InputError("reset_mask must name at least one robot, got none")
        if not (self._begun | mask).all():
            raise gymnasium.error.ResetNeeded("reset must begin all robots before some of them")
        return mask.copy()

    def _seed(self, seed: Any, rows: NDArray[np.bool_]) -> None:
        """Give the robots of some rows the generators of their seeds."""
        if seed is None:
            seeds: list[Any] = [None] * self.num_envs
        elif isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str):
            seeds = list(seed)
        else:
            first = whole("seed", seed, least=0)
            seeds = [first + i for i in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise InputError(
                f"seed must have one number a robot, {self.num_envs}, got {len(seeds)}"
            )
        seeds = [
            None if number is None else whole(f"seed[{i}]", number, least=0)
            for i, number in enumerate(seeds)
        ]
        for row in np.flatnonzero(rows):
            # As a single environment: without a seed the generator goes on.
            if seeds[row] is not None or self._rngs[row] is None:
                self._rngs[row], self._seeds[row] = seeding.np_random(seeds[row])

    def _with_poses(self, info: Mapping[str, Any]) -> dict[str, Any]:
        return {**info, "true_pose": self._batch.states["true_pose"]}

    def _check_open(self) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError("the environment is closed")


def _without(actions: Any, begun: NDArray[np.int64], robots: int) -> Any:
    """Return actions in which those of robots that begin are of no account."""
    if not begun.size:
        return actions
    # Anything else is refused by the batch, with its rule.
    counted = np.array(actions)
    if counted.shape[:1] == (robots,):
        counted[begun] = 0
    return counted
