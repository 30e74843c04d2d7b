"""The one error that bad input raises, and the checks that raise it.

Every check names the value, the rule and what it got, so that a command can print the message
as it stands: ``resolution_m must be > 0, got -0.1``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from difflib import get_close_matches
from numbers import Real
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:  # a message needs no numpy, and the command line's help none either
    import numpy as np
    from numpy.typing import NDArray

Instance = TypeVar("Instance")

__all__ = [
    "InputError",
    "did_you_mean",
    "finite",
    "first_row",
    "flag",
    "instance",
    "non_negative",
    "one_of",
    "positive",
    "resolves",
    "whole",
    "within",
]


class InputError(ValueError):
    """Input that breaks a rule; the message names the value, the rule and the place."""


def finite(name: str, value: float) -> float:
    """Return `value` as a float if it is a finite number, else raise `InputError`."""
    number = _number(name, value)
    if not math.isfinite(number):
        raise InputError(f"{name} must be a finite number, got {value!r}")
    return number


def positive(name: str, value: float) -> float:
    """Return `value` as a float if it is finite and > 0, else raise `InputError`."""
    number = _number(name, value)
    if not (math.isfinite(number) and number > 0):
        raise InputError(f"{name} must be > 0, got {value!r}")
    return number


def non_negative(name: str, value: float) -> float:
    """Return `value` as a float if it is finite and >= 0, else raise `InputError`."""
    number = _number(name, value)
    if not (math.isfinite(number) and number >= 0):
        raise InputError(f"{name} must be >= 0, got {value!r}")
    return number


def within(name: str, value: float, low: float, high: float) -> float:
    """Return `value` as a float if ``low <= value <= high``, else raise `InputError`."""
    number = _number(name, value)
    if not low <= number <= high:
        raise InputError(f"{name} must be within [{low:g}, {high:g}], got {value!r}")
    return number


def first_row(name: str, bad: NDArray[np.bool_], values: NDArray[np.generic], rule: str) -> None:
    """Raise `InputError` for the first row marked in `bad`, naming the row and its value."""
    if bad.any():
        row = int(bad.argmax())
        raise InputError(f"{name}[{row}] must be {rule}, got {values[row]}")


def one_of(name: str, value: str, known: Iterable[str]) -> str:
    """Return `value` if it is one of the known words, else raise `InputError`."""
    words = tuple(known)
    if value not in words:
        raise InputError(f"{name} {value!r} is unknown{did_you_mean(str(value), words)}")
    return value


def resolves(resolution_m: float, width_m: float, height_m: float) -> float:
    """Return a cell size that makes more than one cell of an area, else raise `InputError`."""
    size_m, widest_m = positive("resolution_m", resolution_m), max(width_m, height_m)
    if size_m >= widest_m:
        raise InputError(
            f"resolution_m must be less than the {widest_m:g} m that the grid shall cover, "
            f"got {resolution_m!r}"
        )
    return size_m


def did_you_mean(unknown: str, known: Iterable[str]) -> str:
    """Return ``; did you mean 'X'?`` for the nearest known name, else the list of names."""
    names = sorted(known)
    near = get_close_matches(unknown, names, n=1)
    return f"; did you mean {near[0]!r}?" if near else f"; known: {', '.join(names)}"


def whole(name: str, value: float, *, least: int | None = None, most: int | None = None) -> int:
    """Return `value` as an int if it is whole, `least` to `most`, else raise `InputError`."""
    number = _number(name, value)
    if not number.is_integer():
        raise InputError(f"{name} must be a whole number, got {value!r}")
    if least is not None and number < least:
        raise InputError(f"{name} must be >= {least}, got {value!r}")
    if most is not None and number > most:
        raise InputError(f"{name} must be <= {most}, got {value!r}")
    return int(value)


def flag(name: str, value: object) -> bool:
    """Return `value` if it is true or false, numpy's included, else raise `InputError`."""
    plain = value.item() if getattr(value, "shape", None) == () else value  # type: ignore[attr-defined]
    # "no" would count as true, and so would an empty room.
    if not isinstance(plain, bool):
        raise InputError(f"{name} must be True or False, got {value!r}")
    return plain


def instance(name: str, value: Instance, kind: type[Instance], how: str = "") -> Instance:
    """Return `value` if it is of a class, else raise `InputError`; `how` says how to get one."""
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        hint = f": {how}" if how else ""
        raise InputError(f"{name} must be {article} {kind.__name__}, got {value!r}{hint}")
    return value


def _number(name: str, value: object) -> float:
    # A vector of one number, as numpy and its kind have them, counts as that number.
    plain = value.item() if getattr(value, "shape", None) == () else value  # type: ignore[attr-defined]
    # "3" is text, and True is no length: what they would become is not what was meant.
    if type(plain) is bool or not isinstance(plain, Real):
        raise InputError(f"{name} must be a number, got {value!r}")
    try:
        return float(plain)
    except OverflowError:  # a whole number of more than 300 digits
        raise InputError(f"{name} must be a number that fits 64 bits, got a larger one") from None
