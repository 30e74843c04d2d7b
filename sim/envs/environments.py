"""The environments of the tasks: `ExploreEnv`, `ExploreVectorEnv` and so on, by `env_class`.

Every task in `sim.envs.tasks.registry.TASKS` has two classes here, made when they are first asked
for: ``<name>Env`` and ``<name>VectorEnv``. `task_env` makes those of a person's own task.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from inspect import cleandoc
from typing import Any

import gymnasium
from gymnasium.wrappers import TimeLimit

from sim.envs.env import Observation, SonarEnv
from sim.envs.tasks.registry import TASKS
from sim.envs.tasks.task import Task
from sim.envs.vector import SonarVectorEnv
from sonarmap import InputError

__all__ = ["env_class", "task_env", "task_vector_env", "vector_env_class"]


def __getattr__(name: str) -> Any:
    """Return the class ``<task>Env`` or ``<task>VectorEnv`` of a known task."""
    for ending, make in (("VectorEnv", vector_env_class), ("Env", env_class)):
        task = name.removesuffix(ending)
        if task != name and task in TASKS:
            return make(TASKS[task])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


@cache
def env_class(task: type[Task]) -> type[SonarEnv]:
    """Return the environment of a task; the task's docstring is the head of its specification."""
    members = {
        "__doc__": cleandoc(task.__doc__ or ""),
        "__module__": __name__,
        "__reduce__": _by_task(task, "single"),
        "task_class": task,
    }
    return type(f"{task.__name__}Env", (SonarEnv,), members)


@cache
def vector_env_class(task: type[Task]) -> type[SonarVectorEnv]:
    """Return the vector environment of a task."""
    single = env_class(task)
    doc = f"Many of `{single.__name__}` at once, see `SonarVectorEnv`."
    members = {
        "__doc__": doc,
        "__module__": __name__,
        "__reduce__": _by_task(task, "vector"),
        "env_class": single,
    }
    return type(f"{task.__name__}VectorEnv", (SonarVectorEnv,), members)


def _by_task(task: type[Task], kind: str) -> Callable[[Any], tuple[Any, ...]]:
    """Return the ``__reduce__`` of the environment of a task.

    Its class is made here and cannot be found by its name, but for a task in `TASKS`; the task can.
    """

    def reduced(env: Any) -> tuple[Any, ...]:
        return _unfilled, (task, kind), env.__getstate__()

    return reduced


def _unfilled(task: type[Task], kind: str) -> Any:
    """Return an environment of a task before its state is set."""
    made: Any = env_class(task) if kind == "single" else vector_env_class(task)
    return made.__new__(made)


def task_env(task: str | type[Task], **arguments: Any) -> gymnasium.Env[Observation, Any]:
    """Return the environment of a task, with the task's time limit.

    ``gymnasium.make("sim:sonarbed/Task-v1", task=..., ...)`` calls it.

    Parameters
    ----------
    task : str or type of Task
        A name of `TASKS`, ``package.module:Name`` of a task's class, or the class.
    **arguments
        Those of `SonarEnv`.
    """
    known = _task_class(task)
    env = env_class(known)(**arguments)
    if known.max_episode_steps is None:
        return env
    return TimeLimit(env, known.max_episode_steps)


def task_vector_env(task: str | type[Task], num_envs: int = 1, **arguments: Any) -> SonarVectorEnv:
    """Return the vector environment of a task, with the task's time limit.

    ``gymnasium.make_vec("sim:sonarbed/Task-v1", task=..., ...)`` calls it.

    Parameters
    ----------
    task : str or type of Task
        As for `task_env`.
    num_envs : int
        How many robots, >= 1.
    **arguments
        Those of `SonarVectorEnv`.
    """
    known = _task_class(task)
    limit = {"max_episode_steps": known.max_episode_steps}
    return vector_env_class(known)(num_envs, **limit | arguments)


def _task_class(task: str | type[Task]) -> type[Task]:
    found = TASKS.find(task) if isinstance(task, str) else task
    if not (isinstance(found, type) and issubclass(found, Task)):
        raise InputError(f"task {task!r} must be a subclass of sim.envs.Task, got {found!r}")
    return found
