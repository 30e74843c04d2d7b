"""`PlainSpec`: the specification of an environment, with arguments that JSON can hold.

``EnvSpec.from_json(env.spec.to_json())`` makes the same environment again, whatever it was made
with. Rooms and sonars that ship become their names, files their paths, values the mappings of their
fields; a value whose class does not follow from the argument keeps it as ``type``,
``package.module:Name``.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from pathlib import PurePath
from typing import Any

import numpy as np
from gymnasium.envs.registration import EnvSpec

import worlds
from sim.envs.values import in_order
from sim.sonar.presets import PRESETS
from sonarmap.errors import InputError
from sonarmap.parameters import with_parameters
from sonarmap.registry import import_object
from worlds import Pose, World

__all__ = ["HasSpec", "PlainSpec", "described", "plain_arguments"]

_TYPE = "type"
# Arguments that say by themselves what their fields are of.
_OF_ONE_CLASS = ("weights", "odometry", "randomisation")


class PlainSpec(EnvSpec):
    """An `EnvSpec` that keeps its arguments as they were given, and writes them as plain values."""

    @classmethod
    def of(cls, spec: EnvSpec | None) -> EnvSpec | None:
        """Return a specification as one of these."""
        if spec is None:
            return None
        names = [field.name for field in dataclasses.fields(spec) if field.init]
        return cls(**{name: getattr(spec, name) for name in names})

    def to_json(self) -> str:
        """Return the specification as JSON.

        Raises
        ------
        InputError
            If JSON cannot hold an argument; the message names it.
        """
        names = [field.name for field in dataclasses.fields(self) if field.init]
        plain = EnvSpec(**{name: getattr(self, name) for name in names})
        plain.kwargs = plain_arguments(self.kwargs)
        return plain.to_json()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, EnvSpec):
            return NotImplemented
        return all(
            getattr(self, field.name) == getattr(other, field.name)
            for field in dataclasses.fields(self)
        )

    __hash__ = None  # type: ignore[assignment]  # as of every EnvSpec


class HasSpec:
    """What has a specification: Gymnasium sets it once an environment is made."""

    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """The specification that makes the environment again; None of one made directly."""
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = PlainSpec.of(spec)


def plain_arguments(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments of an environment as values that JSON can hold.

    Raises
    ------
    InputError
        If it cannot hold one; the message names the argument and the reason.
    """
    return {name: _plain(name, value) for name, value in arguments.items()}


def described(what: str, given: Mapping[str, Any]) -> Any:
    """Return the value that a mapping with its ``type`` describes.

    Parameters
    ----------
    what : str
        What messages call it.
    given : mapping
        ``type``, ``package.module:Name`` of its dataclass, and its fields by their names; fields
        may be described so as well.

    Raises
    ------
    InputError
        If there is no such class or field, or a value breaks its rule.
    """
    path = given.get(_TYPE)
    if not isinstance(path, str):
        raise InputError(
            f"{what} given as a mapping must have the key {_TYPE!r}, package.module:Name of its "
            f"class, got {dict(given)!r}"
        )
    kind = import_object(what, path)
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        raise InputError(f"{what} {path!r} must be a dataclass to have its fields in a mapping")
    fields = {
        name: _undone(f"{what}.{name}", value) for name, value in given.items() if name != _TYPE
    }
    return with_parameters(f"{what} {path!r}", kind, fields)


def _undone(place: str, value: Any) -> Any:
    """Return what a plain value stands for within a described one: JSON knows no tuples."""
    if isinstance(value, Mapping):
        return described(place, value) if _TYPE in value else dict(value)
    if isinstance(value, list | tuple):
        return tuple(_undone(f"{place}[{i}]", part) for i, part in enumerate(value))
    return value


def _plain(place: str, value: Any) -> Any:
    """Return a value as JSON can hold it; `place` is what messages call it."""
    match value:
        case Enum():
            return value.value
        case None | bool() | int() | float() | str():
            return value
        case np.ndarray() | np.generic():
            return value.tolist()
        case PurePath():
            return str(value)
        case World():
            return _room(place, value)
        case Pose():
            return [value.x_m, value.y_m, value.heading_rad]
        case type():
            return _path(place, value)
        case Mapping():
            return {str(name): _plain(f"{place}[{name!r}]", part) for name, part in value.items()}
        case list() | tuple() | set() | frozenset():
            return [_plain(f"{place}[{i}]", part) for i, part in enumerate(in_order(value))]
    if dataclasses.is_dataclass(value):
        return _fields(place, value)
    raise InputError(
        f"{place} cannot be kept in a specification: JSON holds names, numbers and values of "
        f"dataclasses, got {value!r}"
    )


def _room(place: str, world: World) -> str:
    if world.name in worlds.names() and worlds.load(world.name) == world:
        return world.name
    raise InputError(
        f"{place} cannot be kept in a specification: the room {world.name!r} was given as a World "
        "of its own, which JSON cannot hold; give its name or its file"
    )


def _path(place: str, kind: type) -> str:
    path = f"{kind.__module__}:{kind.__qualname__}"
    try:
        found = import_object(place, path)
    except InputError:
        found = None
    if found is not kind:
        raise InputError(
            f"{place} cannot be kept in a specification: {path} cannot be imported by its name"
        )
    return path


def _fields(place: str, value: Any) -> Any:
    """Return a value of a dataclass as its fields; a sonar that ships as its name."""
    for name in PRESETS.shipped:
        if type(preset := PRESETS[name]) is type(value) and preset == value:
            return name
    fields = {
        field.name: _plain(f"{place}.{field.name}", getattr(value, field.name))
        for field in dataclasses.fields(value)
        if field.init
    }
    if place in _OF_ONE_CLASS:
        return fields
    return {_TYPE: _path(place, type(value)), **fields}
