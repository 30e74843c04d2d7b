"""`SB3VecEnv`: our vector environments as Stable-Baselines3 knows them. Needs the extra ``rl``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray

from sim.envs.env import Observation
from sim.envs.infos import of_robot
from sim.envs.vector import SonarVectorEnv
from sonarmap import InputError

try:
    from stable_baselines3.common.vec_env import VecEnv
except ImportError:
    raise InputError(
        "sim.envs.sb3 needs the package stable_baselines3: pip install 'sonarbed[rl]'"
    ) from None

__all__ = ["SB3VecEnv"]

_Indices = int | Iterable[int] | None


class SB3VecEnv(VecEnv):
    """A thin adapter of one of our vector environments to Stable-Baselines3's `VecEnv`.

    All robots still move in a few compiled calls. When an episode ends, its info holds what
    Stable-Baselines3 expects, ``terminal_observation`` and ``TimeLimit.truncated``, and the task's
    own (``is_success``, ``reward_terms``, ...); the infos of other robots are empty.

    Parameters
    ----------
    env : SonarVectorEnv
        Made by ``gymnasium.make_vec(id, num_envs=..., vectorization_mode="vector_entry_point",
        autoreset_mode="SameStep", ...)``. It is closed with the adapter.

    Raises
    ------
    InputError
        If `env` is another environment or does not begin the next episode in the same step.
    """

    def __init__(self, env: SonarVectorEnv) -> None:
        if not isinstance(env, SonarVectorEnv):
            raise InputError(
                f"env must be a vector environment of sonarbed, got {type(env).__name__}"
            )
        if env.metadata["autoreset_mode"] is not AutoresetMode.SAME_STEP:
            raise InputError('env must be made with autoreset_mode="SameStep"')
        self._env = env
        self._actions: NDArray[Any] | None = None
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Observation:
        """Begin episodes of all robots, with the seeds that `seed` was given."""
        options = self._options[0]
        if any(other != options for other in self._options):
            raise InputError(f"all robots must have the same options, got {self._options}")
        observations, _ = self._env.reset(seed=self._seeds, options=options or None)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of the next step."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[Observation, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Drive all robots for one control step."""
        observations, reward, terminated, truncated, info = self._env.step(self._actions)
        done = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for row in np.flatnonzero(done).tolist():
            infos[row] = {
                **_row_of(info["final_info"], row),
                "terminal_observation": info["final_obs"][row],
                "TimeLimit.truncated": bool(truncated[row] and not terminated[row]),
            }
        return observations, reward.astype(np.float32), done, infos

    def close(self) -> None:
        """Close the environment; closing twice is fine."""
        self._env.close()

    def get_attr(self, attr_name: str, indices: _Indices = None) -> list[Any]:
        """Return an attribute of the vector environment, once for each robot."""
        return [getattr(self._env, attr_name)] * len(self._rows(indices))

    def set_attr(self, attr_name: str, value: Any, indices: _Indices = None) -> None:
        """Refuse: the robots have no environments of their own whose attributes could differ."""
        raise InputError(f"{attr_name!r} cannot be set: the robots share one environment")

    def env_method(
        self, method_name: str, *method_args: Any, indices: _Indices = None, **method_kwargs: Any
    ) -> list[Any]:
        """Refuse: the robots have no environments of their own."""
        raise InputError(f"{method_name!r} cannot be called: the robots share one environment")

    def env_is_wrapped(
        self, wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]], indices: _Indices = None
    ) -> list[bool]:
        """Return False for each robot: nothing wraps them."""
        return [False] * len(self._rows(indices))

    def _rows(self, indices: _Indices) -> list[int]:
        return list(self._get_indices(indices))


def _row_of(info: Mapping[str, Any], row: int) -> dict[str, Any]:
    """Return one robot's part of a vector environment's info, without the masks."""
    return of_robot(_without_masks(info), row)


def _without_masks(info: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: _without_masks(rows) if isinstance(rows, Mapping) else rows
        for name, rows in info.items()
        if not (name.startswith("_") and name[1:] in info)
    }
