"""Checks of what environments are given: names, values by their fields, and things in an order."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from sonarmap.errors import InputError, did_you_mean, finite, whole

__all__ = ["check_names", "in_order", "value_of"]

Value = TypeVar("Value")


def check_names(what: str, given: Mapping[str, Any], known: Iterable[str]) -> None:
    """Raise `InputError` if a name that is given is none of the known ones."""
    known = list(known)
    for name in given:
        if name not in known:
            raise InputError(f"{what} {name!r} is unknown{did_you_mean(str(name), known)}")


def value_of(
    what: str,
    kind: type[Value],
    given: Any,
    check: Callable[[str, Any], object] | None = None,
) -> Value:
    """Return a frozen value that is given as such, or as a mapping of its fields.

    Parameters
    ----------
    what : str
        What messages call it.
    kind : type
        Its dataclass.
    given : object
        One of them, or a mapping; fields that a mapping lacks have their defaults.
    check : callable, optional
        Checks each field by its name and value. By default a field whose default is a number must
        be one, a whole one if the default is.

    Raises
    ------
    InputError
        If it is neither, has a field that there is not, or a value breaks its rule.
    """
    fields = {each.name: each for each in dataclasses.fields(kind) if each.init}  # type: ignore[arg-type]
    if not isinstance(given, kind):
        if not isinstance(given, Mapping):
            raise InputError(
                f"{what} must be {kind.__name__} or a mapping of its fields, got {given!r}"
            )
        check_names(what, given, fields)
        for name, value in given.items():
            (check or _by_default(fields[name].default))(f"{what}.{name}", value)
        return kind(**given)
    if check is not None:
        for name in fields:
            check(f"{what}.{name}", getattr(given, name))
    return given


def _by_default(default: Any) -> Callable[[str, Any], object]:
    if type(default) is int:
        return whole
    return finite if type(default) is float else lambda name, value: None


def in_order(things: Iterable[Value]) -> tuple[Value, ...]:
    """Return things in their order; those of a set, which has none, by their names."""
    if isinstance(things, set | frozenset):
        return tuple(sorted(things, key=_by_name))
    return tuple(things)


def _by_name(thing: object) -> tuple[str, str]:
    return str(getattr(thing, "name", thing)), repr(thing)
