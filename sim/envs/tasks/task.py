"""`Task`: what a robot is asked to do, how well it does, and when it is done."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray

from sim.envs.values import value_of
from sonarmap.errors import finite
from worlds import Pose

if TYPE_CHECKING:  # `import sim` loads the tasks, and what they are handed is slow to load
    from _typeshed import DataclassInstance

    from sim.envs.facts import RoomFacts
    from sim.envs.maps.grids import MapGrids

__all__ = ["Evaluation", "StepOutcome", "Task", "TaskSetup", "weighted"]


@dataclass(frozen=True, slots=True, eq=False)
class TaskSetup:
    """What the task of one robot begins with.

    Parameters
    ----------
    facts : RoomFacts
        The truth of the room.
    start : Pose
        Where the robot begins.
    goal : str or tuple of float
        "random", or a place (x, y) in metres, for tasks that have a goal.
    rng : numpy.random.Generator
        What the task draws comes from it.
    """

    facts: RoomFacts
    start: Pose
    goal: str | tuple[float, float]
    rng: np.random.Generator


@dataclass(frozen=True, slots=True, eq=False)
class StepOutcome:
    """What a task evaluates: robots at the end of a control step, a row a robot.

    Parameters
    ----------
    states : structured ndarray, shape (robots,)
        See `sim.envs.states.robot_dtype`.
    stuck : ndarray of bool, shape (robots,)
        Robots that have touched something for too long.
    effort : ndarray, shape (robots,)
        Mean square of the wanted wheel speeds, as shares of the fastest; in [0, 1].
    maps : MapGrids or None
        What the robots have mapped, if anybody asks for it.
    """

    states: NDArray[np.void]
    stuck: NDArray[np.bool_]
    effort: NDArray[np.float64]
    maps: MapGrids | None


@dataclass(frozen=True, slots=True, eq=False)
class Evaluation:
    """How well the robots do, a row a robot.

    Parameters
    ----------
    terms : mapping of str to ndarray, shape (robots,)
        The terms of the reward, without their weights.
    reward : ndarray, shape (robots,)
        Their weighted sum.
    terminated : ndarray of bool, shape (robots,)
        Who is done.
    info : mapping of str to ndarray
        What else the environment's info has.
    """

    terms: Mapping[str, NDArray[np.float64]]
    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    info: Mapping[str, NDArray[Any]]


class Task(ABC):
    """What robots are asked to do; holds the task's state of every robot.

    A task is one file. The docstring of its class is the specification of its environments, which
    are made from it (`sim.envs.environments`): what is observed beside what all robots sense, the
    terms of the reward, and when an episode ends.

    Parameters
    ----------
    robots : int
        How many.
    weights : object, optional
        Weights of the reward's terms, see `weights_of`.
    """

    weights_class: ClassVar[type[DataclassInstance]]
    """Frozen dataclass of the weights, a field a term of the reward, with defaults."""

    max_episode_steps: ClassVar[int | None] = None
    """Episodes are truncated after so many control steps; None: never."""

    needs_maps: ClassVar[bool] = False
    """Whether it evaluates the robots' maps."""

    observations: ClassVar[Mapping[str, Box]] = {}
    """What the robot observes beside what it senses."""

    def __init__(self, robots: int, weights: DataclassInstance | None = None) -> None:
        self._weights = asdict(self.weights_of(weights))

    @classmethod
    def weights_of(cls, given: Any) -> DataclassInstance:
        """Return weights that are given as `weights_class`, as a mapping of its fields, or not.

        Parameters
        ----------
        given : object
            A value of `weights_class`, a mapping of some of its fields to finite numbers, or None
            for ``weights_class()``.

        Raises
        ------
        InputError
            If it is neither, or a weight is unknown or no finite number.
        """
        return value_of("weights", cls.weights_class, {} if given is None else given, finite)

    def begin(self, row: int, setup: TaskSetup) -> None:  # noqa: B027 - nothing, by default
        """Begin the episode of one robot."""

    def observe(self, states: NDArray[np.void]) -> dict[str, NDArray[np.float32]]:
        """Return new arrays of what is in `observations`, a row a robot."""
        return {}

    @abstractmethod
    def evaluate(self, outcome: StepOutcome) -> Evaluation:
        """Evaluate the control step that has just ended."""

    def goal_of(self, row: int) -> tuple[float, float] | None:
        """Return where a robot shall go, metres, for the picture; None without a goal."""
        return None

    def evaluation(
        self,
        terms: Mapping[str, NDArray[np.float64]],
        terminated: NDArray[np.bool_],
        **info: NDArray[Any],
    ) -> Evaluation:
        """Return the evaluation with the weighted sum of its terms as the reward."""
        return Evaluation(terms, weighted(terms, self._weights), terminated, info)


def weighted(
    terms: Mapping[str, NDArray[np.float64]], weights: Mapping[str, float]
) -> NDArray[np.float64]:
    """Return the weighted sum of the terms of a reward."""
    reward: NDArray[np.float64] = sum(weights[name] * value for name, value in terms.items())  # type: ignore[assignment]
    return reward
