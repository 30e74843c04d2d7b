"""Mapping methods chosen by name, and whatever else may stand where one is wanted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from sonarmap.catalogue import METHODS
from sonarmap.errors import InputError
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.protocol import MappingMethod
from sonarmap.methods.recalibrated import Recalibrated
from sonarmap.occupancy import OccupancyMap
from sonarmap.parameters import Space, at_point, replaced, with_parameters
from sonarmap.tuned import Tuning, logistic_of, tuned_point

__all__ = ["FunctionMethod", "as_method", "method", "methods"]

MapFunction = Callable[[SonarLog, GridSpec], ArrayLike]


def methods() -> Mapping[str, type[MappingMethod]]:
    """Return the classes of all mapping methods by name, those of installed packages included."""
    return METHODS


def method(name: str, *, tuned: Tuning = False, **parameters: Any) -> MappingMethod:
    """Return the mapping method called `name` with parameters.

    Parameters
    ----------
    name : str
        A name of `methods`, or ``package.module:Name`` of a class, an instance or a function
        ``(log, grid) -> array of P(occupied)``.
    tuned : bool or "logistic"
        False: parameters have the paper's values. True: those of the tuning that ships
        (`sonarbed arena --tune`, on generated rooms). "logistic": these, and a logistic of two
        numbers after them, fitted on the same rooms.
    **parameters
        Fields of the method's dataclass; the others have their defaults, or tuned values.

    Raises
    ------
    InputError
        If there is no such method or parameter, a value breaks its rule, or it was not tuned.
    """
    if tuned not in (False, True, "logistic"):
        raise InputError(f"tuned must be False, True or 'logistic', got {tuned!r}")
    part = METHODS.find(name)
    if tuned is False:
        return as_method(part, label=name, **parameters)
    made = at_point(part, tuned_point("method", name))
    if parameters:
        made = replaced(f"method {name!r}", made, parameters)
    return made if tuned is True else Recalibrated(made, *logistic_of(name))


def as_method(part: Any, *, label: str | None = None, **parameters: Any) -> MappingMethod:
    """Return what is given as a mapping method: a method, its class, or any callable.

    Parameters
    ----------
    part : MappingMethod, class, or callable
        A callable takes a log and a grid and returns P(occupied), shape (rows, cols).
    label : str, optional
        What messages, and a callable's `name`, call it.
    **parameters
        For a class, the values of its fields; nothing else takes any.
    """
    label = getattr(part, "__name__", type(part).__name__) if label is None else label
    if isinstance(part, type):
        part, parameters = with_parameters(f"method {label!r}", part, parameters), {}
    if parameters:
        raise InputError(f"method {label!r} takes no parameters, got {', '.join(parameters)}")
    if callable(getattr(part, "map", None)):
        return part  # type: ignore[no-any-return]
    if callable(part):
        return FunctionMethod(part, label)
    raise InputError(
        f"method {label!r} must have .map(log, grid) or be a function of them, "
        f"got {type(part).__name__}"
    )


@dataclass(frozen=True)
class FunctionMethod:
    """A person's own function of a log and a grid as a mapping method.

    Parameters
    ----------
    function : callable
        Returns P(occupied) of each cell, shape (rows, cols), or a map.
    name : str
        What it is called.
    """

    source: ClassVar[str] = "a function of one's own"

    function: MapFunction
    name: str = "own"

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map that the function states.

        Raises
        ------
        InputError
            If what it returns is no map on the grid; the message names the function.
        """
        made: Any = self.function(log, grid)
        try:
            if hasattr(made, "grid"):
                built = OccupancyMap.of(made)
                if built.grid != grid:
                    raise InputError(f"its map must be on the grid given, got {built.grid}")
                return built
            return OccupancyMap.from_probability(grid, made)
        except InputError as error:
            raise InputError(f"method {self.name!r}: {error}") from None

    @classmethod
    def space(cls) -> Space:
        """Return nothing: a function's insides are its own."""
        return {}
