"""`read_spec`: a spec from a TOML file, with the path of the key in every complaint."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from sim.datasets.spec import DatasetSpec
from sonarmap.errors import InputError, did_you_mean
from sonarmap.files import read_text

__all__ = ["parse_spec", "read_spec"]


def read_spec(path: str | Path) -> DatasetSpec:
    """Return the spec of a TOML file.

    Raises
    ------
    InputError
        If it cannot be read, is not TOML, or a key breaks its rule: ``FILE: key: rule``. What
        needs the simulator to be known (parameters of sonars and drivers) is checked when the
        data set is planned.
    """
    text = read_text(path)
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: is not TOML: {error}") from None
    try:
        return parse_spec(tables)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def parse_spec(tables: Mapping[str, Any]) -> DatasetSpec:
    """Return the spec of tables as a TOML file has them."""
    try:
        return DatasetSpec.model_validate(dict(tables))
    except ValidationError as error:
        raise InputError(_line(error.errors()[0])) from None


def _line(details: ErrorDetails) -> str:
    place = _place(details["loc"])
    got = details.get("input")
    match details["type"]:
        case "extra_forbidden":
            *above, unknown = details["loc"]
            return f"{place}: unknown key{did_you_mean(str(unknown), _known_keys(above))}"
        case "missing":
            return f"{place}: is missing"
        case "value_error":
            return f"{place}: {details['ctx']['error']}" if place else str(details["ctx"]["error"])
        case _:
            rule = details["msg"].removeprefix("Input ").replace("should", "must")
            return f"{place}: {rule}, got {_short(got)}"


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _place(loc: Sequence[str | int]) -> str:
    place = ""
    for part in loc:
        place += f"[{part}]" if isinstance(part, int) else f".{part}" if place else str(part)
    return place


def _known_keys(above: Sequence[str | int]) -> list[str]:
    """Return the keys of the table that a path leads to."""
    model: type[BaseModel] = DatasetSpec
    for part in above:
        if isinstance(part, int):
            continue
        found: Any = model.model_fields[part].annotation
        inner = [a for a in getattr(found, "__args__", ()) if isinstance(a, type)]
        model = next((a for a in [found, *inner] if _is_model(a)), model)
    return list(model.model_fields)


def _is_model(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)
