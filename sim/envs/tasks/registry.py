"""The tasks by name."""

from __future__ import annotations

from sim import catalogue
from sim.envs.tasks.task import Task
from sonarmap.registry import Registry

__all__ = ["SHIPPED", "TASKS"]

SHIPPED = catalogue.TASKS
"""``package.module:Name`` of each task that ships; its environment is ``sonarbed/<name>-v1``."""

TASKS = Registry[type[Task]]("task", "sonarbed.tasks", SHIPPED)
"""Classes of tasks: those that ship and those of installed packages."""
