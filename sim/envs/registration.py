"""Registers the environments with Gymnasium; `import sim` does it."""

from __future__ import annotations

from typing import Any

from gymnasium.envs.registration import register

from sim.envs.tasks.registry import SHIPPED, TASKS

__all__ = ["IDS", "register_all"]

IDS = tuple(f"sonarbed/{name}-v0" for name in SHIPPED)
"""Ids of the environments that ship, one a task."""

_CLASSES = "sim.envs.environments"
_ANY_TASK: dict[str, Any] = {
    "entry_point": f"{_CLASSES}:task_env",
    "vector_entry_point": f"{_CLASSES}:task_vector_env",
}


def register_all() -> None:
    """Register an environment for every task, and ``sonarbed/Task-v0`` for a person's own."""
    for name, identity in zip(SHIPPED, IDS, strict=True):
        register(
            identity,
            entry_point=f"{_CLASSES}:{name}Env",
            vector_entry_point=f"{_CLASSES}:{name}VectorEnv",
            max_episode_steps=TASKS[name].max_episode_steps,
        )
    for name in TASKS:
        # A name that is no identifier cannot be part of an id.
        if name not in SHIPPED and name.isidentifier():
            # Imported when it is made: a package that is broken breaks its own task alone.
            register(f"sonarbed/{name}-v0", kwargs={"task": name}, **_ANY_TASK)
    register("sonarbed/Task-v0", **_ANY_TASK)
