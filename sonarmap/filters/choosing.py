"""Reading filters chosen by name, and whatever else may stand where one is wanted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sonarmap.catalogue import FILTERS
from sonarmap.errors import InputError, flag
from sonarmap.filters.protocol import Filtered, ReadingFilter
from sonarmap.log import SonarLog
from sonarmap.parameters import Space, at_point, replaced, with_parameters
from sonarmap.tuned import tuned_point

__all__ = ["FunctionFilter", "as_filter", "filter", "filters"]


def filters() -> Mapping[str, type[ReadingFilter]]:
    """Return the classes of all reading filters by name, those of installed packages included."""
    return FILTERS


def filter(  # noqa: A001 - the field's word
    name: str, *, tuned: bool = False, **parameters: Any
) -> ReadingFilter:
    """Return the reading filter called `name` with parameters.

    Parameters
    ----------
    name : str
        A name of `filters`, or ``package.module:Name`` of a class, an instance or a function
        ``(log) -> Filtered or SonarLog``.
    tuned : bool
        Whether parameters have the values of the tuning that ships (`sonarbed arena --tune`, on
        generated rooms) in place of the paper's.
    **parameters
        Fields of the filter's dataclass; the others have their defaults, or tuned values.

    Raises
    ------
    InputError
        If there is no such filter or parameter, a value breaks its rule, or it was not tuned.
    """
    part = FILTERS.find(name)
    if not flag("tuned", tuned):
        return as_filter(part, label=name, **parameters)
    made: ReadingFilter = at_point(part, tuned_point("filter", name))
    return replaced(f"filter {name!r}", made, parameters) if parameters else made


def as_filter(part: Any, *, label: str | None = None, **parameters: Any) -> ReadingFilter:
    """Return what is given as a reading filter: a filter, its class, or any callable.

    Parameters
    ----------
    part : ReadingFilter, class, or callable
        A callable takes a log and returns a `Filtered`, or the log as it makes it.
    label : str, optional
        What messages, and a callable's `name`, call it.
    **parameters
        For a class, the values of its fields; nothing else takes any.
    """
    label = getattr(part, "__name__", type(part).__name__) if label is None else label
    if isinstance(part, type):
        part, parameters = with_parameters(f"filter {label!r}", part, parameters), {}
    if parameters:
        raise InputError(f"filter {label!r} takes no parameters, got {', '.join(parameters)}")
    if callable(getattr(part, "apply", None)):
        return part  # type: ignore[no-any-return]
    if callable(part):
        return FunctionFilter(part, label)
    raise InputError(
        f"filter {label!r} must have .apply(log) or be a function of it, got {type(part).__name__}"
    )


@dataclass(frozen=True)
class FunctionFilter:
    """A person's own function of a log as a reading filter.

    Parameters
    ----------
    function : callable
        Returns a `Filtered`, or the log as it makes it.
    name : str
        What it is called.
    """

    source: ClassVar[str] = "a function of one's own"

    function: Callable[[SonarLog], Filtered | SonarLog]
    name: str = "own"

    def apply(self, log: SonarLog) -> Filtered:
        """Return what the function makes of a log."""
        made = self.function(log)
        if isinstance(made, Filtered):
            return made
        if not isinstance(made, SonarLog) or len(made) != len(log):
            what = f"a log of {len(made)}" if isinstance(made, SonarLog) else type(made).__name__
            raise InputError(
                f"filter {self.name!r} must return a log of {len(log)} readings, got {what}"
            )
        return Filtered(made, made.range_m != log.range_m)

    @classmethod
    def space(cls) -> Space:
        """Return nothing: a function's insides are its own."""
        return {}
