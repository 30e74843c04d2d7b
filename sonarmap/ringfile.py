"""Rings as TOML files, in degrees and metres, to and from the fields of a `SonarRing`.

`sonarmap.ring` reads them, `SonarRing.write` writes them.

::

    name = "my robot"
    source = "measured with a ruler"
    half_angle_deg = 15
    range_min_m = 0.02
    range_max_m = 4.0

    [[sonar]]
    x_m = 0.1
    y_m = 0.05
    heading_deg = 45
"""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sonarmap.errors import InputError, did_you_mean, finite
from sonarmap.files import atomic_path, read_text

__all__ = ["read_fields", "write_fields"]

_TEXTS = ("name", "source")
_NUMBERS = ("half_angle_deg", "range_min_m", "range_max_m")
_OF_A_SONAR = ("x_m", "y_m", "heading_deg")
# Millimetres taken for metres: no robot's sonar is farther from its middle. Assumed.
_FARTHEST_M = 10.0


def read_fields(path: str | Path) -> dict[str, Any]:
    """Return the fields of the ring that a TOML file describes, as `SonarRing.to_dict` has them.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or a key breaks its rule; the message names the
        file, the key and the rule.
    """
    text = read_text(path)
    try:
        return _fields(text, name=Path(path).stem)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def write_fields(fields: Mapping[str, Any], path: str | Path, *, source: str = "") -> None:
    """Write the fields of a ring as a TOML file; `source` says where it is from.

    Notes
    -----
    Angles are written in degrees: those of a ring that was made from degrees come back exactly,
    any other within rounding, 1e-15 of their value.
    """
    lines = [f"name = {_text(fields['name'])}"]
    if source:
        lines.append(f"source = {_text(source)}")
    lines += [
        f"half_angle_deg = {_degrees(fields['half_angle_rad'])}",
        f"range_min_m = {fields['range_min_m']!r}",
        f"range_max_m = {fields['range_max_m']!r}",
    ]
    places = zip(fields["x_m"], fields["y_m"], fields["heading_rad"], strict=True)
    for x_m, y_m, heading_rad in places:
        lines += ["", "[[sonar]]", f"x_m = {x_m!r}", f"y_m = {y_m!r}"]
        lines.append(f"heading_deg = {_degrees(heading_rad)}")
    with atomic_path(path) as beside:
        beside.write_bytes(("\n".join(lines) + "\n").encode())


def _fields(text: str, *, name: str) -> dict[str, Any]:
    try:
        data = tomllib.loads(text)
    except RecursionError:
        raise InputError("is not TOML: nested too deeply") from None
    except ValueError as error:  # what it says itself, or Python of a number of 5000 digits
        raise InputError(f"is not TOML: {error}") from None
    _check_keys("", data, needed=(*_NUMBERS, "sonar"), known=(*_TEXTS, *_NUMBERS, "sonar"))
    for key in _TEXTS:
        if not isinstance(data.get(key, ""), str):
            raise InputError(f"{key}: must be a text, got {data[key]!r}")
    half_angle_deg, range_min_m, range_max_m = (_number("", data, key) for key in _NUMBERS)
    if not 0 < half_angle_deg < 90:
        raise InputError(f"half_angle_deg: must be within (0, 90), got {half_angle_deg:g}")
    if not 0 <= range_min_m < range_max_m:
        raise InputError(
            f"range_min_m: must be >= 0 and < range_max_m, got {range_min_m:g} and {range_max_m:g}"
        )
    sonars = data["sonar"]
    if not isinstance(sonars, list) or not sonars:
        raise InputError(f"sonar: must be one [[sonar]] table or more, got {sonars!r}")
    places = [_sonar(f"sonar[{i}]", table) for i, table in enumerate(sonars)]
    x_m, y_m, heading_deg = zip(*places, strict=True)
    return {
        "name": data.get("name", name),
        "x_m": list(x_m),
        "y_m": list(y_m),
        "heading_rad": [math.radians(deg) for deg in heading_deg],
        "half_angle_rad": math.radians(half_angle_deg),
        "range_min_m": range_min_m,
        "range_max_m": range_max_m,
    }


def _sonar(place: str, table: Any) -> tuple[float, float, float]:
    if not isinstance(table, dict):
        raise InputError(f"{place}: must be a table, got {table!r}")
    _check_keys(f"{place}.", table, needed=_OF_A_SONAR, known=_OF_A_SONAR)
    x_m, y_m, heading_deg = (_number(f"{place}.", table, key) for key in _OF_A_SONAR)
    for key, value in (("x_m", x_m), ("y_m", y_m)):
        if abs(value) > _FARTHEST_M:
            raise InputError(
                f"{place}.{key}: must be metres, at most {_FARTHEST_M:g}, got {value:g}"
            )
    if abs(heading_deg) > 360:
        raise InputError(f"{place}.heading_deg: must be within [-360, 360], got {heading_deg:g}")
    return x_m, y_m, heading_deg


def _check_keys(
    prefix: str, table: Mapping[str, Any], *, needed: Iterable[str], known: Iterable[str]
) -> None:
    for key in table:
        if key not in known:
            raise InputError(f"{prefix}{key}: unknown key{did_you_mean(key, known)}")
    for key in needed:
        if key not in table:
            raise InputError(f"{prefix}{key}: this key is missing")


def _number(prefix: str, table: Mapping[str, Any], key: str) -> float:
    try:
        return finite(f"{prefix}{key}", table[key])
    except (InputError, OverflowError):
        raise InputError(f"{prefix}{key}: must be a finite number, got {table[key]!r}") from None


def _degrees(angle_rad: float) -> str:
    """Return degrees as text: the shortest that stand for the angle, if there are such."""
    exact = math.degrees(angle_rad)
    for digits in range(1, 17):
        short = float(f"{exact:.{digits}g}")
        if math.radians(short) == angle_rad:
            return repr(short)
    return repr(exact)


def _text(text: str) -> str:
    # A text of JSON is one of TOML, but for this one character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
