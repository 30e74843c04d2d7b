"""Infos: one robot's as plain numbers, those of many as Gymnasium's vector environments do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["gathered", "of_robot"]

# What one number of each kind of array becomes, as `item` makes it plain.
_PLAIN: dict[str, type] = {"b": bool, "i": int, "u": int, "f": float}


def of_robot(info: Mapping[str, Any], row: int) -> dict[str, Any]:
    """Return one robot's part of a batch's info: plain numbers, and arrays of its own.

    Parameters
    ----------
    info : mapping of str to ndarray, shape (robots, ...), or to such a mapping
        What a batch says of its robots.
    row : int
        Which robot.
    """
    told: dict[str, Any] = {}
    for name, rows in info.items():
        # Arrays first: to ask whether something is a mapping takes many times as long.
        if isinstance(rows, np.ndarray):
            told[name] = rows[row].item() if rows.ndim == 1 else rows[row].copy()
        else:
            told[name] = of_robot(rows, row)
    return told


def gathered(info: Mapping[str, Any], rows: NDArray[np.bool_]) -> dict[str, Any]:
    """Return what `gymnasium.vector.VectorEnv` makes of the infos of some robots.

    Parameters
    ----------
    info : mapping
        As for `of_robot`.
    rows : ndarray of bool, shape (robots,)
        The robots whose info says this.

    Returns
    -------
    dict
        New arrays by name, zero (or None) for all other robots, and beside each name its mask
        ``_name``; in the mappings within it likewise. Empty if `rows` has nobody.
    """
    if not rows.any():
        return {}
    told: dict[str, Any] = {}
    for name, values in info.items():
        told[name] = gathered(values, rows) if isinstance(values, Mapping) else _only(values, rows)
        told[f"_{name}"] = rows.copy()
    return told


def _only(values: NDArray[Any], rows: NDArray[np.bool_]) -> NDArray[Any]:
    """Return the values of some rows; those of the others are zero, None where there is none."""
    dtype: Any = values.dtype if values.ndim > 1 else _PLAIN.get(values.dtype.kind, object)
    only = np.full(values.shape, None, object) if dtype is object else np.zeros(values.shape, dtype)
    only[rows] = values[rows]
    return only
