"""What may be searched of a part: the ranges that its parameters may take."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from sonarmap.errors import InputError, did_you_mean, finite

__all__ = [
    "Choice",
    "Real",
    "Space",
    "Whole",
    "at_point",
    "from_text",
    "replaced",
    "with_parameters",
]

Part = TypeVar("Part")


@dataclass(frozen=True, slots=True)
class Real:
    """A number between two others.

    Parameters
    ----------
    low, high : float
        Ends of the range, both included.
    log : bool
        Whether to search evenly in the logarithm; needs low > 0.
    """

    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        if finite("low", self.low) >= finite("high", self.high):
            raise InputError(f"low must be < high, got {self.low!r} and {self.high!r}")
        if self.log and self.low <= 0:
            raise InputError(f"low must be > 0 for a logarithmic range, got {self.low!r}")


@dataclass(frozen=True, slots=True)
class Whole:
    """A whole number between two others, both included."""

    low: int
    high: int

    def __post_init__(self) -> None:
        if self.low >= self.high:
            raise InputError(f"low must be < high, got {self.low!r} and {self.high!r}")


@dataclass(frozen=True, slots=True)
class Choice:
    """One of some values."""

    values: tuple[Any, ...]

    def __post_init__(self) -> None:
        if len(self.values) < 2:
            raise InputError(f"values must be at least two, got {self.values!r}")


Space = Mapping[str, Real | Whole | Choice]
"""Ranges by the name of a parameter."""


def with_parameters(kind: str, part: type[Part], parameters: Mapping[str, Any]) -> Part:
    """Return ``part(**parameters)``, or raise `InputError` for a parameter that it has not.

    Parameters
    ----------
    kind : str
        What messages call it: "method 'bayes-standard'".
    part : type
        A dataclass, or another class that takes keyword arguments.
    parameters : mapping
        Values by name.
    """
    if dataclasses.is_dataclass(part):
        known = [each.name for each in dataclasses.fields(part) if each.init]
        for name in parameters:
            if name not in known:
                raise InputError(f"{kind} has no parameter {name!r}{did_you_mean(name, known)}")
        needed = [
            each.name
            for each in dataclasses.fields(part)
            if each.init
            and each.default is dataclasses.MISSING
            and each.default_factory is dataclasses.MISSING
            and each.name not in parameters
        ]
        if needed:
            raise InputError(f"{kind} needs the parameter {needed[0]!r}")
    try:
        return part(**parameters)
    except InputError:
        raise
    except TypeError as error:
        raise InputError(f"{kind} cannot be made: {error}") from error


def at_point(part: type[Part], point: Mapping[str, Any]) -> Part:
    """Return the part that a point of its ``space()`` stands for; no coordinate, no change.

    A part whose coordinates are not its parameters has a class method ``at(point)``.
    """
    at = getattr(part, "at", None)
    return part(**point) if at is None or not point else at(point)


def replaced(kind: str, part: Part, parameters: Mapping[str, Any]) -> Part:
    """Return a frozen dataclass with some fields replaced, checked as `with_parameters` does."""
    known = [each.name for each in dataclasses.fields(part) if each.init]  # type: ignore[arg-type]
    for name in parameters:
        if name not in known:
            raise InputError(f"{kind} has no parameter {name!r}{did_you_mean(name, known)}")
    return dataclasses.replace(part, **parameters)  # type: ignore[type-var]


def from_text(kind: str, part: type, settings: Mapping[str, str]) -> dict[str, Any]:
    """Return parameters of a dataclass from text, as a command line gives them.

    ``NAME_deg`` stands for the parameter ``NAME_rad``.

    Raises
    ------
    InputError
        If there is no such parameter, it is given twice, or its value is not of its type.
    """
    if not dataclasses.is_dataclass(part):
        # Nobody knows its types: numbers where they are numbers, text elsewhere.
        return {name: _guessed(text) for name, text in settings.items()}
    hints = get_type_hints(part)
    known = [each.name for each in dataclasses.fields(part) if each.init]
    values: dict[str, Any] = {}
    for given, text in settings.items():
        in_degrees = given.endswith("_deg") and given not in known
        name = given.removesuffix("_deg") + "_rad" if in_degrees else given
        if name not in known:
            names = {n for known_name in known for n in (known_name, _degrees(known_name))}
            raise InputError(f"{kind} has no parameter {given!r}{did_you_mean(given, names)}")
        if name in values:
            raise InputError(f"{kind}: {name!r} is given twice")
        value = _typed(f"{kind}: {given}", hints[name], text)
        values[name] = math.radians(value) if in_degrees else value
    return values


def _degrees(name: str) -> str:
    return name.removesuffix("_rad") + "_deg" if name.endswith("_rad") else name


def _typed(place: str, hint: Any, text: str) -> Any:
    """Return the value of a text as one of the types of an annotation."""
    kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    if type(None) in kinds and text.lower() in ("none", ""):
        return None
    literals = [value for kind in kinds for value in get_args(kind) if isinstance(value, str)]
    if bool in kinds:
        words = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}
        if text.lower() not in words:
            raise InputError(f"{place} must be true or false, got {text!r}")
        return words[text.lower()]
    for kind, what in ((int, "a whole number"), (float, "a number")):
        if kind in kinds:
            if kind is int and float in kinds:
                continue
            try:
                return kind(text)
            except ValueError:
                raise InputError(f"{place} must be {what}, got {text!r}") from None
    if literals and text not in literals:
        raise InputError(f"{place} {text!r} is unknown{did_you_mean(text, literals)}")
    if literals or str in kinds:
        return text
    raise InputError(f"{place} cannot be given as text")


def _guessed(text: str) -> Any:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
