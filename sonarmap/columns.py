"""Columns of readings, checked for what they are where they enter.

Nothing is converted that loses its meaning: text is no number, and 2 is neither true nor false.
"""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, first_row

__all__ = ["column"]


def column(name: str, values: Any, dtype: Any, size: int) -> NDArray[Any]:
    """Return values as a new read-only vector, or raise `InputError` that names column and row.

    Parameters
    ----------
    name : str
        What messages call it.
    values : array_like
        Numbers for a dtype of numbers, whole ones that fit for integers; true and false, or 1 and
        0, for bool; texts for str. Nothing masked.
    dtype : dtype
        What the column shall be of.
    size : int
        Its length.
    """
    if isinstance(values, np.ma.MaskedArray):
        first_row(name, np.ma.getmaskarray(values), values.data, "known, not masked")
        values = values.data
    wanted = np.dtype(dtype)
    wrong_kind = InputError(f"{name} must be a column of {wanted.name}")
    try:
        given = np.asarray(values)
        # A cast of NaN warns; what it became is found to be changed.
        with np.errstate(invalid="ignore"):
            checked: NDArray[Any] = np.array(values, dtype=dtype)
    except (TypeError, ValueError, OverflowError):
        raise wrong_kind from None
    if given.shape != (size,):
        raise InputError(f"{name} must have shape ({size},), got {given.shape}")
    if given.dtype == object:
        given = _plain(name, given, wanted)
    kinds = {"U": "U", "f": "iuf", "i": "iuf", "b": "iufb"}[wanted.kind]
    if size and given.dtype.kind not in kinds:
        raise wrong_kind
    if wanted.kind == "b" and given.dtype.kind != "b":
        first_row(name, (given != 0) & (given != 1), given, "true or false")
    if wanted.kind == "i":
        first_row(name, checked != given, given, f"a whole number that fits {wanted}")
    checked.flags.writeable = False
    return checked


def _plain(name: str, given: NDArray[Any], wanted: np.dtype[Any]) -> NDArray[Any]:
    """Return a column of Python objects as one of numbers or texts, if all of them are."""
    kind = str if wanted.kind == "U" else Real
    bad = np.array([not isinstance(each, kind | np.bool_) for each in given], dtype=bool)
    first_row(name, bad, given, "a text" if kind is str else "a number")
    plain: NDArray[Any] = np.array(given.tolist())
    # Fractions and their like stay objects.
    return plain.astype(np.float64) if plain.dtype == object else plain
