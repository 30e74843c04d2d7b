"""Sonar rings: where a robot's sonars sit and what they can measure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sonarmap.catalogue import RINGS
from sonarmap.errors import InputError, non_negative, positive
from sonarmap.ringfile import read_fields, write_fields

__all__ = ["AMIGOBOT", "SonarRing", "ring", "rings"]


@dataclass(frozen=True, eq=False)
class SonarRing:
    """The sonars of a robot, numbered as its maker numbers them, from 0.

    Parameters
    ----------
    name : str
        Name of the ring.
    x_m, y_m : array_like, shape (sonars,)
        Place of each sonar in the robot's frame (x forward, y left), metres.
    heading_rad : array_like, shape (sonars,)
        Acoustic axis of each sonar, counter-clockwise from the robot's x axis, radians.
    half_angle_rad : float
        Half of the cone's full width, radians, in (0, pi/2).
    range_min_m, range_max_m : float
        Nearest and farthest range that the sonar reports, metres.
    """

    name: str
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    heading_rad: NDArray[np.float64]
    half_angle_rad: float
    range_min_m: float
    range_max_m: float

    def __post_init__(self) -> None:
        for field in ("x_m", "y_m", "heading_rad"):
            object.__setattr__(self, field, _frozen_vector(field, getattr(self, field)))
        if not self.x_m.shape == self.y_m.shape == self.heading_rad.shape:
            raise InputError(
                "x_m, y_m and heading_rad must have one value a sonar, got "
                f"{self.x_m.size}, {self.y_m.size} and {self.heading_rad.size}"
            )
        half_angle = positive("half_angle_rad", self.half_angle_rad)
        if half_angle >= math.pi / 2:
            raise InputError(f"half_angle_rad must be < pi/2, got {half_angle!r}")
        object.__setattr__(self, "half_angle_rad", half_angle)
        near, far = (
            non_negative("range_min_m", self.range_min_m),
            positive("range_max_m", self.range_max_m),
        )
        if near >= far:
            raise InputError(f"range_min_m must be < range_max_m, got {near!r} and {far!r}")
        object.__setattr__(self, "range_min_m", near)
        object.__setattr__(self, "range_max_m", far)

    def __len__(self) -> int:
        return int(self.x_m.size)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SonarRing) and self.to_dict() == other.to_dict()

    def __hash__(self) -> int:
        return hash((self.name, len(self), self.half_angle_rad, self.range_max_m))

    def sensor_xy_m(
        self,
        sonar: NDArray[np.integer] | slice,
        x_m: NDArray[np.float64] | float,
        y_m: NDArray[np.float64] | float,
        heading_rad: NDArray[np.float64] | float,
    ) -> NDArray[np.float64]:
        """Return the places of sonars on a robot at the given poses, metres, shape (n, 2).

        Parameters
        ----------
        sonar : ndarray of int, shape (n,), or slice
            Numbers of the sonars.
        x_m, y_m, heading_rad : array_like, shape (n,) or scalars
            Poses of the robot, metres and radians.
        """
        cos, sin = np.cos(heading_rad), np.sin(heading_rad)
        ahead, left = self.x_m[sonar], self.y_m[sonar]
        places = np.empty((ahead.size, 2))
        places[:, 0] = x_m + cos * ahead - sin * left
        places[:, 1] = y_m + sin * ahead + cos * left
        return places

    def to_dict(self) -> dict[str, Any]:
        """Return the ring as plain numbers and lists, as a log file stores it."""
        return {
            "name": self.name,
            "x_m": self.x_m.tolist(),
            "y_m": self.y_m.tolist(),
            "heading_rad": self.heading_rad.tolist(),
            "half_angle_rad": self.half_angle_rad,
            "range_min_m": self.range_min_m,
            "range_max_m": self.range_max_m,
        }

    def write(self, path: str | Path, *, source: str = "") -> None:
        """Write the ring as a TOML file that `ring` reads; `source` says where it is from."""
        write_fields(self.to_dict(), path, source=source)

    @classmethod
    def from_dict(cls, fields: Mapping[str, Any]) -> SonarRing:
        """Return the ring that `to_dict` described."""
        try:
            return cls(**fields)
        except TypeError as error:
            raise InputError(f"ring: {error}") from None


def rings() -> Mapping[str, SonarRing]:
    """Return all presets by name, those of installed packages included."""
    return RINGS


def ring(name: str | Path) -> SonarRing:
    """Return a ring.

    Parameters
    ----------
    name : str or Path
        A name of `rings`, the path of a TOML file (see `sonarmap.ringfile`), or
        ``package.module:Name`` of a ring of one's own. A text is a path if it ends in ``.toml``
        or has a folder in it.

    Raises
    ------
    InputError
        If there is no such ring (with the nearest known name), or its file breaks a rule.
    """
    if _is_path(name):
        return SonarRing.from_dict(read_fields(name))
    found = RINGS.find(name)  # type: ignore[arg-type]  # it says what is no name
    if not isinstance(found, SonarRing):
        raise InputError(f"ring {name!r} must be a SonarRing, got {type(found).__name__}")
    return found


def _is_path(name: object) -> bool:
    if not isinstance(name, str):
        return isinstance(name, Path)
    return name.lower().endswith(".toml") or (":" not in name and ("/" in name or "\\" in name))


def _frozen_vector(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        vector = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be a list of finite numbers, got {values!r}") from None
    if vector.ndim != 1 or vector.size == 0 or not np.isfinite(vector).all():
        raise InputError(f"{name} must be a list of finite numbers, got {values!r}")
    vector.flags.writeable = False
    return vector


def _preset(
    name: str,
    units_mm_deg: Sequence[tuple[float, float, float]],
    *,
    full_width_deg: float,
    range_min_m: float,
    range_max_m: float,
) -> SonarRing:
    x_mm, y_mm, heading_deg = zip(*units_mm_deg, strict=True)
    return SonarRing(
        name=name,
        x_m=np.array(x_mm) / 1000,
        y_m=np.array(y_mm) / 1000,
        heading_rad=np.deg2rad(heading_deg),
        half_angle_rad=math.radians(full_width_deg / 2),
        range_min_m=range_min_m,
        range_max_m=range_max_m,
    )


# Unit: x mm, y mm, heading degrees. AmigoBot-SH from ARIA's params/amigo-sh.p. Every ARIA copy has
# unit 1 at x = 125 where its mirror image, unit 4, has 120: almost certainly a slip of the pen.
# The default ring is symmetric; `amigobot-aria` keeps ARIA's number.
_AMIGOBOT_SH = (
    (70, 100, 90),
    (120, 75, 41),
    (144, 30, 15),
    (144, -30, -15),
    (120, -75, -41),
    (70, -100, -90),
    (-146, -58, -145),
    (-146, 58, 145),
)
_AMIGOBOT_ARIA = (_AMIGOBOT_SH[0], (125, 75, 41), *_AMIGOBOT_SH[2:])
# ARIA's params/amigo.p (the older H8 board).
_AMIGOBOT_H8 = (
    (76, 100, 90),
    (125, 75, 41),
    (150, 30, 15),
    (150, -30, -15),
    (125, -75, -41),
    (76, -100, -90),
    (-140, -58, -145),
    (-140, 58, 145),
)
# ARIA's params/p3dx.p: front array 0 to 7, rear array 8 to 15.
_PIONEER_3DX = (
    (69, 136, 90),
    (114, 119, 50),
    (148, 78, 30),
    (166, 27, 10),
    (166, -27, -10),
    (148, -78, -30),
    (114, -119, -50),
    (69, -136, -90),
    (-157, -136, -90),
    (-203, -119, -130),
    (-237, -78, -150),
    (-255, -27, -170),
    (-255, 27, 170),
    (-237, 78, 150),
    (-203, 119, 130),
    (-157, 136, 90),
)
# RoboND-OccupancyGridMappingAlgorithm: bearings from its main.cpp; the mounting radius is not
# documented and taken as 0. Sensor 0 looks to the right.
_UDACITY_8 = tuple((0.0, 0.0, deg) for deg in (-90, -37.5, -22.5, -7.5, 7.5, 22.5, 37.5, 90))

# Arrays of HC-SR04, the usual sonar of hobby robots. Where they sit is assumed: three at the bow of
# a two-wheeled chassis, and eight evenly around a disc, counter-clockwise from the bow.
_HC_SR04_3 = ((80, 50, 45), (100, 0, 0), (80, -50, -45))
_HC_SR04_8 = tuple(
    (round(100 * math.cos(math.radians(deg)), 1), round(100 * math.sin(math.radians(deg)), 1), deg)
    for deg in (0, 45, 90, 135, 180, -135, -90, -45)
)

# 0.165 to 3.0 m and 30 degrees: Rashid 2006, p. 56 and 58. 0.10 to 5.0 m: ARIA's sonar device.
_ARIA_RANGES = {"range_min_m": 0.10, "range_max_m": 5.0}
AMIGOBOT = _preset("amigobot", _AMIGOBOT_SH, full_width_deg=30, range_min_m=0.165, range_max_m=3.0)
AMIGOBOT_ARIA = _preset("amigobot-aria", _AMIGOBOT_ARIA, full_width_deg=30, **_ARIA_RANGES)
AMIGOBOT_H8 = _preset("amigobot-h8", _AMIGOBOT_H8, full_width_deg=30, **_ARIA_RANGES)
PIONEER_3DX = _preset("pioneer3dx", _PIONEER_3DX, full_width_deg=30, **_ARIA_RANGES)
# The common case: the robot without the rear array.
PIONEER_3DX_FRONT = _preset("pioneer3dx-front", _PIONEER_3DX[:8], full_width_deg=30, **_ARIA_RANGES)
UDACITY_8 = _preset("udacity8", _UDACITY_8, full_width_deg=20, range_min_m=0.17, range_max_m=5.0)
# HC-SR04 data sheet (Elecfreaks): "measuring angle" 15 degrees, 2 cm to 4 m. That the angle is the
# cone's full width is assumed; its test diagram shows echoes of large targets from farther aside.
_HC_SR04 = {"full_width_deg": 15, "range_min_m": 0.02, "range_max_m": 4.0}
HC_SR04_3 = _preset("hc-sr04-3", _HC_SR04_3, **_HC_SR04)
HC_SR04_8 = _preset("hc-sr04-8", _HC_SR04_8, **_HC_SR04)
