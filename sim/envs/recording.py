"""Episodes kept: as a `SonarLog` with its truth, and as a Minari data set."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from sim.envs.env import Observation
from sim.envs.episode_batch import EpisodeBatch
from sim.envs.policies.policies import Policy
from sim.runs.recorder import Recorder
from sim.sonar.protocol import Echoes
from sonarmap import InputError, SonarLog
from worlds import Pose

if TYPE_CHECKING:
    from minari import MinariDataset

__all__ = ["RecordLog", "record_minari"]


class RecordLog(gymnasium.Wrapper[Observation, Any, Observation, Any], RecordConstructorArgs):
    """Records what the sonars say in each episode as a `sonarmap.SonarLog`, with the truth.

    A scan is what fired in one control step; of a sonar that fires twice in one, its newest
    reading counts. The wrapper may stand anywhere around one of our environments, best outside
    of all others: then it sees episodes end that the time limit ends.

    Parameters
    ----------
    env : gymnasium.Env
        One of ``sonarbed/*``, wrapped or not.

    Attributes
    ----------
    logs : list of SonarLog
        Of the episodes that have ended, by a termination, a truncation or the next ``reset``, in
        their order. Empty it whenever you like.

    Notes
    -----
    The provenance of a log records the environment's id and arguments, the last seed that a
    ``reset`` was given and how many more resets there have been since (with both the episode can
    be had again), the options of this reset, the room, the sonar and the sum of the rewards.
    """

    def __init__(self, env: gymnasium.Env[Observation, Any]) -> None:
        RecordConstructorArgs.__init__(self)
        gymnasium.Wrapper.__init__(self, env)
        self.logs: list[SonarLog] = []
        self._episode: _Episode | None = None
        self._seed: int | None = None
        self._resets_since_seed = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode; what was recorded of one that has not ended is kept, too."""
        self._keep()
        begun = self.env.reset(seed=seed, options=options)
        self._resets_since_seed = self._resets_since_seed + 1 if seed is None else 0
        self._seed = self._seed if seed is None else seed
        spec = self.env.spec
        self._episode = _Episode(
            self._batch,
            {
                "environment": None if spec is None else spec.id,
                "arguments": {} if spec is None else _plain(spec.kwargs),
                "seed": self._seed,
                "resets_since_seed": self._resets_since_seed,
                "options": _plain(options or {}),
            },
        )
        return begun

    def step(self, action: Any) -> tuple[Observation, Any, bool, bool, dict[str, Any]]:
        """Drive for one control step and record what was detected."""
        if self._episode is None:
            raise gymnasium.error.ResetNeeded("reset must be called before the next step")
        step = self.env.step(action)
        _, reward, terminated, truncated, _ = step
        self._episode.add(float(reward))
        if terminated or truncated:
            self._keep()
        return step

    def log(self) -> SonarLog:
        """Return the log of the running episode so far, or of the last one if it has ended.

        Raises
        ------
        InputError
            If nothing has been recorded yet.
        """
        if self._episode is not None:
            return self._episode.log()
        if not self.logs:
            raise InputError("there is no log: reset must be called first")
        return self.logs[-1]

    @property
    def _batch(self) -> EpisodeBatch:
        batch = getattr(self.env.unwrapped, "batch", None)
        if not isinstance(batch, EpisodeBatch):
            raise InputError(
                f"RecordLog must wrap an environment of sonarbed, got {self.env.unwrapped}"
            )
        return batch

    def _keep(self) -> None:
        episode, self._episode = self._episode, None
        if episode is not None and episode.has_readings:
            self.logs.append(episode.log())


class _Episode:
    """What is recorded of one episode of the first robot of a batch."""

    def __init__(self, batch: EpisodeBatch, provenance: Mapping[str, Any]) -> None:
        setup = batch.setup_of(0)
        self._batch = batch
        self._provenance = {"world": setup.world.name, "sonar": setup.sonar.name, **provenance}
        self._recorder = Recorder(setup.sonar.ring, setup.world)
        self._scan, self._touched, self._score = 0, False, 0.0
        self.has_readings = False
        self._record()

    def add(self, reward: float) -> None:
        """Record what happened in the control step that has just ended."""
        self._score += reward
        self._record()

    def log(self) -> SonarLog:
        """Return the log so far."""
        return self._recorder.log({**self._provenance, "reward": self._score})

    def _record(self) -> None:
        state = self._batch.states[0]
        self._touched |= bool(state["touched"])
        fresh = np.flatnonzero(state["fresh"])
        if not fresh.size:
            return
        fired = fresh[np.argsort(state["fired_s"][fresh], kind="stable")]
        for sonar in fired.tolist():
            self._recorder.fired(
                self._scan,
                float(state["fired_s"][sonar]),
                (sonar,),
                _pose(state["fired_pose"][sonar]),
                _pose(state["fired_true_pose"][sonar]),
            )
        echoes = {field.name: state[field.name][fired] for field in dataclasses.fields(Echoes)}
        self._recorder.detected(Echoes(**echoes), touched=self._touched)
        self._scan, self._touched, self.has_readings = self._scan + 1, False, True


def record_minari(
    env: gymnasium.Env[Observation, Any],
    policy: Policy,
    dataset_id: str,
    *,
    episodes: int,
    seed: int,
    **description: Any,
) -> MinariDataset:
    """Drive episodes with a policy and keep them as a Minari data set on this machine.

    The data set lies in the folder that the environment variable ``MINARI_DATASETS_PATH`` names,
    by default ``~/.minari/datasets``; ``minari.load_dataset(dataset_id)`` reads it.

    Parameters
    ----------
    env : gymnasium.Env
        One of ``sonarbed/*``, made by ``gymnasium.make`` with arguments that JSON can hold: rooms
        and sonars by their names. It is left open.
    policy : callable
        From an observation to an action.
    dataset_id : str
        As Minari names data sets: ``namespace/name-v0``.
    episodes : int
        How many, >= 1.
    seed : int
        Of the first episode; each one after it has the next number, which the data set notes.
    **description
        What ``minari.create_dataset_from_buffers`` takes beside: ``author``, ``author_email``,
        ``code_permalink``, ``algorithm_name``, ``description`` and others.

    Raises
    ------
    InputError
        If `episodes` is not >= 1, the data set exists already, JSON cannot hold how the
        environment was made, or Minari is not installed.

    Notes
    -----
    ``minari.DataCollector`` would need JAX (Minari's extra ``create``), this does not. Minari
    warns of an author, an address and a link to the code that are not given.
    """
    minari = _minari()
    if episodes < 1:
        raise InputError(f"episodes must be >= 1, got {episodes!r}")
    if dataset_id in minari.list_local_datasets():
        raise InputError(f"dataset_id must be new, got {dataset_id!r}, which exists")
    _check_spec(env)
    buffers = [
        minari.data_collector.EpisodeBuffer(id=number, seed=seed + number, **episode)
        for number in range(episodes)
        for episode in [_driven(env, policy, seed + number)]
    ]
    return minari.create_dataset_from_buffers(
        dataset_id,
        buffers,
        env=env,
        # Maps are no photographs: JPEG would blur what is known of a cell.
        jpeg_encoding=False,
        **{"eval_env": env.spec, **description},
    )


def _check_spec(env: gymnasium.Env[Observation, Any]) -> None:
    """Check that the data set can record how its environment is made again."""
    if env.spec is None:
        raise InputError("env must be made by gymnasium.make, so that the data set can name it")
    try:
        env.spec.to_json()
    except (TypeError, ValueError) as error:
        raise InputError(
            "env must be made with arguments that JSON can hold (rooms and sonars by their "
            f"names), got {error}"
        ) from None


def _driven(env: gymnasium.Env[Observation, Any], policy: Policy, seed: int) -> dict[str, Any]:
    """Drive an episode; return its steps as Minari names them."""
    observation, _ = env.reset(seed=seed)
    observations, actions = [observation], []
    steps: dict[str, list[Any]] = {"rewards": [], "terminations": [], "truncations": []}
    ended = False
    while not ended:
        actions.append(policy(observation))
        observation, reward, terminated, truncated, _ = env.step(actions[-1])
        observations.append(observation)
        for values, value in zip(steps.values(), (reward, terminated, truncated), strict=True):
            values.append(value)
        ended = terminated or truncated
    names = observation.keys()
    return {
        "observations": {name: np.stack([seen[name] for seen in observations]) for name in names},
        "actions": np.stack(actions),
        **steps,
    }


def _minari() -> Any:
    try:
        import minari
    except ImportError:
        raise InputError(
            "a Minari data set needs the package minari: pip install 'sonarbed[minari]'"
        ) from None
    return minari


def _pose(columns: NDArray[np.float64]) -> Pose:
    return Pose(*columns.tolist())


def _plain(value: Any) -> Any:
    """Return a value as JSON can hold it; of rooms and sonars their names."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(part) for part in value]
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    name = getattr(value, "name", None)
    if isinstance(name, str):
        return name
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {
            field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)
        }
    return str(value)
