"""Registers the environments with Gymnasium; `import sim` does it."""

from __future__ import annotations

from typing import Any

from gymnasium.envs.registration import register

from sim.envs.tasks.registry import SHIPPED, TASKS

__all__ = ["FORMER_IDS", "IDS", "VERSION", "register_all"]

VERSION = 1
"""Of the environments: what their ids end with."""
IDS = tuple(f"sonarbed/{name}-v{VERSION}" for name in SHIPPED)
"""Ids of the environments that ship, one a task."""
FORMER_IDS = tuple(f"sonarbed/{name}-v0" for name in SHIPPED)
"""Their former ids, for policies that were learned with them; see the versions in `SonarEnv`."""

_CLASSES = "sim.envs.environments"
_ANY_TASK: dict[str, Any] = {
    "entry_point": f"{_CLASSES}:task_env",
    "vector_entry_point": f"{_CLASSES}:task_vector_env",
}
# What makes an environment of a version, in place of the defaults.
_ARGUMENTS: dict[int, dict[str, Any]] = {0: {"validity": "multibinary"}, VERSION: {}}


def register_all() -> None:
    """Register an environment for every task, and ``sonarbed/Task-v1`` for a person's own."""
    for version, arguments in _ARGUMENTS.items():
        for name in SHIPPED:
            register(
                f"sonarbed/{name}-v{version}",
                entry_point=f"{_CLASSES}:{name}Env",
                vector_entry_point=f"{_CLASSES}:{name}VectorEnv",
                max_episode_steps=TASKS[name].max_episode_steps,
                kwargs=dict(arguments),
            )
        for name in TASKS:
            # A name that is no identifier cannot be part of an id.
            if name not in SHIPPED and name.isidentifier():
                # Imported when it is made: a package that is broken breaks its own task alone.
                register(
                    f"sonarbed/{name}-v{version}", kwargs={"task": name, **arguments}, **_ANY_TASK
                )
        register(f"sonarbed/Task-v{version}", kwargs=dict(arguments), **_ANY_TASK)
