"""The tasks by name. A task that ships is its own file and a line here."""

from __future__ import annotations

from sim.envs.tasks.task import Task
from sonarmap.registry import Registry

__all__ = ["SHIPPED", "TASKS"]

SHIPPED = {
    "Explore": "sim.envs.tasks.explore:Explore",
    "Navigate": "sim.envs.tasks.navigate:Navigate",
    "FollowWall": "sim.envs.tasks.follow_wall:FollowWall",
}
"""``package.module:Name`` of each task that ships; its environment is ``sonarbed/<name>-v0``."""

TASKS = Registry[type[Task]]("task", "sonarbed.tasks", SHIPPED)
"""Classes of tasks: those that ship and those of installed packages."""
