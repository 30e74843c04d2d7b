"""Registers the environments with Gymnasium; `import sim` does it."""

from __future__ import annotations

from gymnasium.envs.registration import register

__all__ = ["IDS", "register_all"]

# Time limits in control steps of a tenth of a second; assumed.
_LIMITS = {"Explore": 1200, "Navigate": 400, "FollowWall": 600}

IDS = tuple(f"sonarbed/{name}-v0" for name in _LIMITS)


def register_all() -> None:
    """Register every environment."""
    for name, limit in _LIMITS.items():
        register(
            f"sonarbed/{name}-v0",
            entry_point=f"sim.envs.environments:{name}Env",
            vector_entry_point=f"sim.envs.environments:{name}VectorEnv",
            max_episode_steps=limit,
        )
