"""Parameters that were tuned on generated rooms: what ``tuned=True`` stands for."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any, Literal

from sonarmap.errors import InputError, did_you_mean

__all__ = ["Tuning", "logistic_of", "tuned_names", "tuned_point"]

Tuning = bool | Literal["logistic"]
"""False: the paper's parameters. True: tuned ones. "logistic": with a logistic fitted after it."""
_FILE = "tuned.json"


def tuned_point(kind: Literal["method", "filter"], name: str) -> Mapping[str, Any]:
    """Return the point of a part's ``space()`` that did best in the tuning that ships.

    Parameters
    ----------
    kind : {"method", "filter"}
        What it is.
    name : str
        Its name.

    Raises
    ------
    InputError
        If it was not tuned.
    """
    known = _shipped()[f"{kind}s"]
    if name not in known:
        raise InputError(f"{kind} {name!r} has no tuned parameters{did_you_mean(name, known)}")
    point: Mapping[str, Any] = known[name]["point"]
    return point


def tuned_names(kind: Literal["method", "filter"]) -> tuple[str, ...]:
    """Return the names of the methods or filters that were tuned."""
    return tuple(sorted(_shipped()[f"{kind}s"]))


def logistic_of(name: str) -> tuple[float, float]:
    """Return (slope, intercept) of the logistic fitted to a tuned method on the training rooms.

    Raises
    ------
    InputError
        If it was not tuned.
    """
    tuned_point("method", name)
    slope, intercept = _shipped()["methods"][name]["logistic"]
    return float(slope), float(intercept)


@lru_cache(maxsize=1)
def _shipped() -> Mapping[str, Any]:
    text = (files("sonarmap") / _FILE).read_text(encoding="utf-8")
    return MappingProxyType(json.loads(text))
