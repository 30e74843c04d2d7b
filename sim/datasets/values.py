"""What a key of a spec stands for: one value, each of a list in turn, or draws of a distribution.

In TOML::

    scans = 200                                     # this
    driver = ["wander", "follow-left"]              # each of them, with all else
    temperature_c = { uniform = [10, 30] }          # drawn for each log
    dynamic_range_db = { normal = [48, 3], within = [40, 56] }
    noise_std_m = { log_uniform = [0.001, 0.02] }
    ring = { choice = ["amigobot", "mine.toml"], weights = [3, 1] }
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any, Protocol

import numpy as np

from sonarmap.errors import InputError, did_you_mean

__all__ = ["Drawn", "Each", "Fixed", "Kind", "Value", "parse_value"]

Plain = float | int | str | bool
_MOST_VALUES = 10_000


@dataclass(frozen=True)
class Kind:
    """What a value must be.

    Parameters
    ----------
    name : {"number", "whole", "text", "flag"}
        A whole number is also drawn from a continuous distribution, and rounded.
    """

    name: str

    def checked(self, value: Any) -> Plain:
        """Return a value of this kind, or raise `InputError`: ``must be a number, got 'x'``."""
        is_number = isinstance(value, Real) and not isinstance(value, bool)
        if self.name == "number" and is_number and math.isfinite(value):
            return value  # type: ignore[no-any-return]
        if self.name == "whole" and is_number and float(value).is_integer():
            return int(value)
        if self.name == "text" and isinstance(value, str) and value:
            return value
        if self.name == "flag" and isinstance(value, bool):
            return value
        what = {"number": "a finite number", "whole": "a whole number", "text": "a text"}
        raise InputError(f"must be {what.get(self.name, 'true or false')}, got {value!r}")

    def of_draw(self, value: float) -> Plain:
        """Return a drawn number as this kind."""
        return round(value) if self.name == "whole" else float(value)


class Value(Protocol):
    """What a key stands for."""

    @property
    def examples(self) -> tuple[Plain, ...]:
        """Values that it may take, its extremes among them."""


@dataclass(frozen=True)
class Fixed:
    """One value."""

    value: Plain

    @property
    def examples(self) -> tuple[Plain, ...]:
        """The value."""
        return (self.value,)


@dataclass(frozen=True)
class Each:
    """Each of some values, in every combination with all others of the kind."""

    values: tuple[Plain, ...]

    @property
    def examples(self) -> tuple[Plain, ...]:
        """The values."""
        return self.values


@dataclass(frozen=True)
class Drawn:
    """Draws of a distribution, one a log.

    Parameters
    ----------
    distribution : {"uniform", "normal", "log_uniform", "choice"}
        Which.
    parameters : tuple
        Ends of the range; mean and standard deviation; or the values.
    kind : Kind
        What is drawn.
    within : (low, high), optional
        Draws beyond are drawn again.
    weights : tuple of float, optional
        Of a choice.
    """

    distribution: str
    parameters: tuple[Plain, ...]
    kind: Kind
    within: tuple[float, float] | None = None
    weights: tuple[float, ...] | None = None

    @property
    def examples(self) -> tuple[Plain, ...]:
        """Ends of a range, values of a choice, mean of a normal distribution."""
        if self.distribution == "choice":
            return self.parameters
        ends: tuple[Any, ...] = self.parameters
        if self.distribution == "normal":
            ends = self.parameters[:1] if self.within is None else self.within
        return tuple(self.kind.of_draw(end) for end in ends)

    def draw(self, rng: np.random.Generator) -> Plain:
        """Return a value."""
        if self.distribution == "choice":
            weights = None
            if self.weights is not None:
                weights = np.array(self.weights) / sum(self.weights)
            return self.parameters[int(rng.choice(len(self.parameters), p=weights))]
        low, high = (float(each) for each in self.parameters)
        if self.distribution == "uniform":
            if self.kind.name == "whole":
                return int(rng.integers(round(low), round(high), endpoint=True))
            return self.kind.of_draw(rng.uniform(low, high))
        if self.distribution == "log_uniform":
            value = math.exp(rng.uniform(math.log(low), math.log(high)))
            return self.kind.of_draw(min(max(value, low), high))
        return self.kind.of_draw(self._normal(low, high, rng))

    def _normal(self, mean: float, std: float, rng: np.random.Generator) -> float:
        if self.within is None:
            return float(rng.normal(mean, std))
        low, high = self.within
        draws = rng.normal(mean, std, 64)
        kept = draws[(draws >= low) & (draws <= high)]
        # So rare that the range hardly knows of the distribution: its nearest end.
        return float(kept[0] if kept.size else min(max(float(draws[0]), low), high))


def parse_value(given: Any, kind: Kind) -> Value:
    """Return what a key stands for.

    Raises
    ------
    InputError
        ``must be ..., got ...``, without the key.
    """
    if isinstance(given, list):
        values = _values(given, kind)
        if len(set(values)) != len(values):
            raise InputError(f"must name no value twice, got {given!r}")
        return Each(values)
    if isinstance(given, Mapping):
        return _drawn(given, kind)
    return Fixed(kind.checked(given))


def _drawn(given: Mapping[str, Any], kind: Kind) -> Drawn:
    known = ("uniform", "normal", "log_uniform", "choice")
    for key in given:
        if key not in (*known, "within", "weights"):
            raise InputError(f"unknown distribution {key!r}{did_you_mean(str(key), known)}")
    named = [key for key in given if key in known]
    if len(named) != 1:
        raise InputError(f"must be one distribution of {', '.join(known)}, got {dict(given)!r}")
    distribution = named[0]
    if "within" in given and distribution != "normal":
        raise InputError("within is for a normal distribution only")
    if "weights" in given and distribution != "choice":
        raise InputError("weights are for a choice only")
    if distribution == "choice":
        values = _values(given[distribution], kind)
        weights = None
        if "weights" in given:
            weights = tuple(float(w) for w in _values(given["weights"], Kind("number")))
            if len(weights) != len(values) or min(weights) < 0 or sum(weights) <= 0:
                raise InputError(
                    f"weights must be a number >= 0 for each of {len(values)} values, not all 0, "
                    f"got {given['weights']!r}"
                )
        return Drawn(distribution, values, kind, weights=weights)
    if kind.name not in ("number", "whole"):
        raise InputError(f"{distribution} is for numbers only: use choice")
    pair = _pair(distribution, given[distribution])
    if distribution == "normal":
        if pair[1] <= 0:
            raise InputError(f"normal must be [mean, standard deviation > 0], got {list(pair)}")
        within = None
        if "within" in given:
            within = _ordered("within", _pair("within", given["within"]))
        return Drawn(distribution, pair, kind, within=within)
    _ordered(distribution, pair)
    if distribution == "log_uniform" and pair[0] <= 0:
        raise InputError(f"log_uniform must be [low > 0, high], got {list(pair)}")
    return Drawn(distribution, pair, kind)


def _values(given: Any, kind: Kind) -> tuple[Plain, ...]:
    if not isinstance(given, list) or not 1 <= len(given) <= _MOST_VALUES:
        raise InputError(f"must be a list of values, got {given!r}")
    return tuple(kind.checked(each) for each in given)


def _pair(name: str, given: Any) -> tuple[float, float]:
    if not isinstance(given, list) or len(given) != 2:
        raise InputError(f"{name} must be a list of two numbers, got {given!r}")
    number = Kind("number")
    try:
        first, second = (float(number.checked(each)) for each in given)
    except InputError:
        raise InputError(f"{name} must be a list of two numbers, got {given!r}") from None
    return first, second


def _ordered(name: str, pair: tuple[float, float]) -> tuple[float, float]:
    if pair[0] >= pair[1]:
        raise InputError(f"{name} must be [low, high] with low < high, got {list(pair)}")
    return pair
