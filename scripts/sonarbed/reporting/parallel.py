"""Tasks computed in parallel processes that report how far they are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from sim.runs.parallel import run_all

__all__ = ["OnProgress", "in_parts", "no_progress", "parallel_map"]

Task = TypeVar("Task")
Result = TypeVar("Result")
Key = TypeVar("Key")

OnProgress = Callable[[str, int, int], None]
"""Called with a label, how much is done, and how much there is."""


def no_progress(label: str, done: int, total: int) -> None:
    """Report nothing."""


def parallel_map(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    label: str,
    *,
    jobs: int = 1,
    on_progress: OnProgress = no_progress,
) -> list[Result]:
    """Return ``[function(task) for task in tasks]``, computed by `jobs` processes.

    Results come in the order of the tasks, so that nothing depends on which process was quicker.

    Parameters
    ----------
    function : callable
        Must pickle, as must the tasks and what it returns.
    tasks : sequence
        One argument each.
    label : str
        What is being done, for people.
    jobs : int
        Processes that work at once, >= 1.
    on_progress : OnProgress
        Hears the label with 0 of all tasks at the beginning, then after each task.
    """
    results: dict[int, Result] = {}
    on_progress(label, 0, len(tasks))
    run_all(
        function,
        tasks,
        results,
        jobs=jobs,
        on_done=lambda index: on_progress(label, len(results), len(tasks)),
    )
    return [results[index] for index in range(len(tasks))]


def in_parts(results: Sequence[Result], keys: Sequence[Key]) -> dict[Key, list[Result]]:
    """Return results in equal parts, in their order, a part for each key."""
    size = len(results) // len(keys)
    return {key: list(results[i * size : (i + 1) * size]) for i, key in enumerate(keys)}
