"""Maps of ROS: the ``map.yaml`` and its image that map_server reads and writes."""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError
from sonarmap.grid import GridSpec
from sonarmap.pixels import Pixels, read_pixels

__all__ = ["FREE_THRESH", "OCCUPIED_THRESH", "RosMap", "read_ros_map", "ros_image", "ros_yaml"]

# map_server's own defaults. 0.196 is what makes its grey 205, (255 - 205) / 255, unknown.
OCCUPIED_THRESH = 0.65
FREE_THRESH = 0.196
_GREY = {"occupied": 0, "unknown": 205, "free": 254}

# What the three states of a trinary map are worth: map_server is sure of them, nobody else is.
_P_OCCUPIED, _P_FREE, _P_UNKNOWN = 0.99, 0.01, 0.5

# Plausible, not possible: a slip of units is found here and not as a map that fits nowhere.
_MAX_RESOLUTION_M, _MAX_ORIGIN_M = 100.0, 1e8
_MAX_YAML_BYTES = 1_000_000

_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_WORDS = {"0": False, "false": False, "no": False, "off": False} | {
    "1": True, "true": True, "yes": True, "on": True,
}  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class RosMap:
    """A map as map_server would publish it, in the form of `sonarmap.OccupancyMap.of`.

    Parameters
    ----------
    grid : GridSpec
        Where the cells are.
    probability : ndarray, shape (rows, cols)
        P(occupied); 0.5 where nothing is known.
    observed : ndarray of bool, shape (rows, cols)
        Which cells are known.
    occupied_from, free_up_to : float
        P(occupied) from which, and up to which, a cell counts as occupied or free.
    notes : tuple of str
        What was changed in reading, in sentences for people.
    """

    grid: GridSpec
    probability: NDArray[np.float64]
    observed: NDArray[np.bool_]
    occupied_from: float
    free_up_to: float
    notes: tuple[str, ...] = ()


def read_ros_map(path: str | Path) -> RosMap:
    """Read a map of map_server or nav2_map_server from its ``map.yaml``.

    Parameters
    ----------
    path : str or Path
        The YAML file. Its image may be a PGM (binary or text, 8 or 16 bit), a PNG or another kind
        that Pillow knows, in any folder.

    Raises
    ------
    InputError
        If a file is missing or damaged, or a key breaks its rule; the message names the file, the
        key and the value.

    Notes
    -----
    A pixel is as dark as it is occupied, or with ``negate`` as light; colours are averaged. The
    modes are those of map_server (wiki.ros.org/map_server, "Value interpretation", and
    nav2_map_server's ``map_io.cpp``):

    * ``trinary``: darker than ``occupied_thresh`` is occupied (P 0.99), lighter than
      ``free_thresh`` free (0.01), anything else unknown. Alpha is averaged with the colours.
    * ``scale``: P is 0 at ``free_thresh``, 1 at ``occupied_thresh``, linear between them. A pixel
      that is not wholly opaque is unknown.
    * ``raw``: the grey, of 255, is P in per cent; above 100 is unknown. ``negate`` and alpha do
      not count.

    The two thresholds are also those of the map, from and up to which P counts as occupied or
    free. A map that is turned (``origin[2]``) is resampled: each cell of a grid along the axes,
    of the same resolution, takes the value of the cell that its centre lies in.
    """
    path = Path(path)
    try:
        about = _About.of(_fields(path), path.parent)
        pixels = _pixels(about.image)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    probability, observed = _MODES[about.mode](pixels, about)
    # An image's first row is the top one, a grid's is the bottom one.
    probability, observed = probability[::-1], observed[::-1]
    grid = GridSpec(about.resolution_m, about.origin_xy_m, probability.shape)
    found = RosMap(grid, probability, observed, *about.limits)
    return found if about.yaw_rad == 0 else _along_axes(found, about.yaw_rad, path)


def ros_image(occupied: NDArray[np.bool_], free: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return the greys of map_server for cells that are occupied, free, or neither."""
    image = np.full(occupied.shape, _GREY["unknown"], np.uint8)
    image[occupied] = _GREY["occupied"]
    image[free] = _GREY["free"]
    # An image's first row is the top one, a grid's is the bottom one.
    return image[::-1]


def ros_yaml(grid: GridSpec, image: str) -> str:
    """Return the text of the ``map.yaml`` of an image that `ros_image` made."""
    x_m, y_m = grid.origin_xy_m
    return (
        f"image: {image}\n"
        "mode: trinary\n"
        f"resolution: {grid.resolution_m!r}\n"
        f"origin: [{x_m!r}, {y_m!r}, 0.0]\n"
        "negate: 0\n"
        f"occupied_thresh: {OCCUPIED_THRESH}\n"
        f"free_thresh: {FREE_THRESH}\n"
    )


def _pixels(path: Path) -> Pixels:
    try:
        return read_pixels(path)
    except InputError as error:
        raise InputError(f"image: {error}") from None


@dataclass(frozen=True, slots=True)
class _About:
    """What a ``map.yaml`` says, checked."""

    image: Path
    resolution_m: float
    origin_xy_m: tuple[float, float]
    yaw_rad: float
    negate: bool
    occupied_thresh: float
    free_thresh: float
    mode: str

    @classmethod
    def of(cls, fields: Mapping[str, Any], folder: Path) -> _About:
        x_m, y_m, yaw_rad = _origin(fields)
        resolution_m = _number(fields, "resolution")
        if not 0 < resolution_m <= _MAX_RESOLUTION_M:
            raise _fault(fields, "resolution", f"must be > 0 and <= {_MAX_RESOLUTION_M:g} m")
        free, occupied = (_share(fields, key) for key in ("free_thresh", "occupied_thresh"))
        if free >= occupied:
            raise InputError(
                f"free_thresh must be < occupied_thresh, got {free:g} and {occupied:g}"
            )
        return cls(
            image=folder / _text(fields, "image"),
            resolution_m=resolution_m,
            origin_xy_m=(x_m, y_m),
            yaw_rad=math.remainder(yaw_rad, math.tau),
            negate=_flag(fields, "negate"),
            occupied_thresh=occupied,
            free_thresh=free,
            mode=_mode(fields),
        )

    @property
    def limits(self) -> tuple[float, float]:
        """P(occupied) from which, and up to which, a cell of the map is occupied or free."""
        limits = self.occupied_thresh, self.free_thresh
        if self.mode == "trinary":
            # The states are decided; extreme thresholds must not undo them.
            limits = min(limits[0], _P_OCCUPIED), max(limits[1], _P_FREE)
            if limits[1] >= limits[0]:
                return _P_OCCUPIED, _P_FREE
        return limits

    def occupied_share(self, grey: NDArray[np.float64], white: int) -> NDArray[np.float64]:
        """Return how occupied greys are, from 0 to 1."""
        return (grey if self.negate else white - grey) / white


# --- what the pixels mean ------------------------------------------------------------------------


_Layers = tuple[NDArray[np.float64], NDArray[np.bool_]]


def _trinary(pixels: Pixels, about: _About) -> _Layers:
    grey = pixels.grey
    if pixels.alpha is not None:
        grey = (3 * grey + pixels.alpha) / 4
    share = about.occupied_share(grey, pixels.white)
    occupied, free = share > about.occupied_thresh, share < about.free_thresh
    probability = np.full(share.shape, _P_UNKNOWN)
    probability[occupied] = _P_OCCUPIED
    probability[free] = _P_FREE
    return probability, occupied | free


def _scale(pixels: Pixels, about: _About) -> _Layers:
    share = about.occupied_share(pixels.grey, pixels.white)
    span = about.occupied_thresh - about.free_thresh
    probability = np.clip((share - about.free_thresh) / span, 0, 1)
    if pixels.alpha is None:
        return probability, np.ones(share.shape, bool)
    opaque = pixels.alpha == pixels.white
    probability[~opaque] = _P_UNKNOWN
    return probability, opaque


def _raw(pixels: Pixels, about: _About) -> _Layers:
    per_cent = np.rint(pixels.grey / pixels.white * 255)
    known = per_cent <= 100
    return np.where(known, per_cent / 100, _P_UNKNOWN), known


_MODES = {"trinary": _trinary, "scale": _scale, "raw": _raw}


# --- maps that are turned ------------------------------------------------------------------------


def _along_axes(found: RosMap, yaw_rad: float, path: Path) -> RosMap:
    """Return a map that is turned about its lower-left corner, resampled, with a note of it."""
    grid, row, col = _turned(found.grid, yaw_rad)
    inside = row >= 0
    note = (
        f"{path}: the map is turned by {math.degrees(yaw_rad):.6g} degrees; its "
        f"{found.grid.rows} x {found.grid.cols} cells were resampled, to the nearest cell, to "
        f"{grid.rows} x {grid.cols} along the axes"
    )
    return replace(
        found,
        grid=grid,
        probability=np.where(inside, found.probability[row, col], _P_UNKNOWN),
        observed=inside & found.observed[row, col],
        notes=(*found.notes, note),
    )


def _turned(grid: GridSpec, yaw_rad: float) -> tuple[GridSpec, NDArray[Any], NDArray[Any]]:
    """Return the grid along the axes that covers a turned one, and where its cells come from.

    That is the row and the column of the turned cell in which each one's centre lies, -1 outside.
    """
    size, (x_m, y_m) = grid.resolution_m, grid.origin_xy_m
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    own = GridSpec(size, (0.0, 0.0), grid.shape)
    corners = np.array([(0, 0), (grid.cols, 0), (0, grid.rows), (grid.cols, grid.rows)]) * size
    corners = corners @ np.array([[cos, sin], [-sin, cos]])
    left, bottom = corners.min(axis=0).tolist()
    # The slack keeps a quarter turn from adding a row for a rounding error.
    cols, rows = (math.ceil(cells - 1e-6) for cells in np.ptp(corners, axis=0) / size)
    along = GridSpec(size, (left, bottom), (max(rows, 1), max(cols, 1)))
    dx, dy = along.centre_of(np.arange(along.rows)[:, None], np.arange(along.cols))
    row, col = own.cell_of(cos * dx + sin * dy, cos * dy - sin * dx)
    inside = own.contains(row, col)
    placed = replace(along, origin_xy_m=(x_m + left, y_m + bottom))
    return placed, np.where(inside, row, -1), np.where(inside, col, -1)


# --- the keys of the YAML file -------------------------------------------------------------------


def _fields(path: Path) -> dict[str, Any]:
    """Return the keys of a YAML file, every scalar as its text."""
    import yaml  # loaded when a map is read

    if not path.is_file():
        raise InputError("is not a file" if path.exists() else "no such file")
    try:
        if path.stat().st_size > _MAX_YAML_BYTES:
            raise InputError(f"is not a map.yaml: it is larger than {_MAX_YAML_BYTES} bytes")
        # All scalars stay text: YAML 1.1, which PyYAML reads, takes 1e-05 for text, 010 for eight
        # and 1:30 for ninety, and map_server takes none of them so.
        fields = yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.BaseLoader)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError("is not a map.yaml: not UTF-8 text") from None
    except (yaml.YAMLError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" at line {mark.line + 1}" if mark else ""
        problem = getattr(error, "problem", None) or type(error).__name__
        raise InputError(f"is not YAML: {problem}{where}") from None
    if not isinstance(fields, dict):
        raise InputError("is not a map.yaml: it must have keys with values")
    return fields


def _value(fields: Mapping[str, Any], key: str) -> Any:
    if key not in fields:
        near = get_close_matches(key, [name for name in fields if isinstance(name, str)], n=1)
        hint = f"; is {near[0]!r} meant for it?" if near else ""
        raise InputError(f"{key}: this key is missing{hint}")
    return fields[key]


def _fault(fields: Mapping[str, Any], key: str, rule: str) -> InputError:
    return InputError(f"{key} {rule}, got {reprlib.repr(fields[key])}")


def _text(fields: Mapping[str, Any], key: str) -> str:
    value = _value(fields, key)
    if not isinstance(value, str) or not value or "\0" in value:
        raise _fault(fields, key, "must be the path of an image")
    return value


def _number(fields: Mapping[str, Any], key: str) -> float:
    number = _parsed(_value(fields, key))
    if number is None:
        raise _fault(fields, key, "must be a finite number")
    return number


def _share(fields: Mapping[str, Any], key: str) -> float:
    number = _number(fields, key)
    if not 0 <= number <= 1:
        raise _fault(fields, key, "must be within [0, 1]")
    return number


def _origin(fields: Mapping[str, Any]) -> tuple[float, float, float]:
    values = _value(fields, "origin")
    numbers = [_parsed(value) for value in values] if isinstance(values, list) else []
    match numbers:
        case [float(x_m), float(y_m), float(yaw_rad)]:
            if max(abs(x_m), abs(y_m)) <= _MAX_ORIGIN_M:
                return x_m, y_m, yaw_rad
            raise _fault(fields, "origin", f"must lie within {_MAX_ORIGIN_M:g} m")
    raise _fault(fields, "origin", "must be [x, y, yaw], finite numbers")


def _flag(fields: Mapping[str, Any], key: str) -> bool:
    value = _value(fields, key)
    if not isinstance(value, str) or value.lower() not in _WORDS:
        raise _fault(fields, key, "must be 0 or 1, false or true")
    return _WORDS[value.lower()]


def _mode(fields: Mapping[str, Any]) -> str:
    mode = fields.get("mode", "trinary")
    if not isinstance(mode, str) or mode not in _MODES:
        raise _fault(fields, "mode", "must be trinary, scale or raw")
    return mode


def _parsed(value: Any) -> float | None:
    """Return the finite number that a scalar's text is, or None."""
    if not isinstance(value, str) or not _NUMBER.fullmatch(value):
        return None
    number = float(value)
    return number if math.isfinite(number) else None
