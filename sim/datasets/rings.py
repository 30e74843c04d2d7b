"""The ring that a spec names: a preset, one of one's own, or a TOML file."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

import sonarmap as sm
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import InputError, SonarRing
from sonarmap.errors import did_you_mean, finite
from sonarmap.files import read_text

__all__ = ["find_ring"]

_KEYS = ("name", "half_angle_deg", "range_min_m", "range_max_m", "sonar")
_SONAR_KEYS = ("x_m", "y_m", "heading_deg")


def find_ring(name: str, folder: Path) -> SonarRing:
    """Return a ring by its name, or from a TOML file; paths begin at `folder`.

    Raises
    ------
    InputError
        If there is none, or it is larger than the robot that shall carry it.
    """
    ring = _of_toml(folder / name) if name.lower().endswith(".toml") else sm.ring(name)
    out_m = np.hypot(ring.x_m, ring.y_m)
    if out_m.max() > BODY_RADIUS_M:
        sonar = int(out_m.argmax())
        raise InputError(
            f"ring {ring.name!r} is larger than the robot: sonar {sonar} sits {out_m[sonar]:.3g} m "
            f"from its centre, its body has a radius of {BODY_RADIUS_M:g} m"
        )
    return ring


def _of_toml(path: Path) -> SonarRing:
    text = read_text(path)
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: is not TOML: {error}") from None
    try:
        return _ring(table, path.stem)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _ring(table: dict[str, Any], stem: str) -> SonarRing:
    _check_keys("", table, _KEYS, optional=("name",))
    sonars = table["sonar"]
    if not isinstance(sonars, list) or not sonars:
        raise InputError("sonar: must be tables [[sonar]], at least one")
    places = []
    for i, sonar in enumerate(sonars):
        if not isinstance(sonar, dict):
            raise InputError(f"sonar[{i}]: must be a table")
        _check_keys(f"sonar[{i}].", sonar, _SONAR_KEYS)
        places.append([finite(f"sonar[{i}].{key}", sonar[key]) for key in _SONAR_KEYS])
    x_m, y_m, heading_deg = np.array(places).T
    return SonarRing(
        str(table.get("name", stem)),
        x_m,
        y_m,
        np.deg2rad(heading_deg),
        math.radians(finite("half_angle_deg", table["half_angle_deg"])),
        table["range_min_m"],
        table["range_max_m"],
    )


def _check_keys(
    place: str, table: dict[str, Any], keys: tuple[str, ...], optional: tuple[str, ...] = ()
) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"{place}{key}: unknown key{did_you_mean(key, keys)}")
    for key in keys:
        if key not in table and key not in optional:
            raise InputError(f"{place}{key}: is missing")
