"""`read_map`: maps from files, of this package and of ROS."""

from __future__ import annotations

from pathlib import Path

from sonarmap.errors import InputError
from sonarmap.occupancy import OccupancyMap
from sonarmap.rosmap import read_ros_map

__all__ = ["read_map", "read_map_and_notes"]

_YAML = (".yaml", ".yml")
_IMAGES = (".pgm", ".png", ".bmp")


def read_map(path: str | Path) -> OccupancyMap:
    """Read a map.

    Parameters
    ----------
    path : str or Path
        A folder or ``map.npz`` that `OccupancyMap.save` wrote, or the ``map.yaml`` of any pair of
        ROS's map_server or nav2_map_server; of a folder without ``map.npz`` its ``map.yaml``.

    Returns
    -------
    OccupancyMap
        What a pair of ROS means is said by `sonarmap.rosmap.read_ros_map`; one that is turned is
        resampled to a grid along the axes.

    Raises
    ------
    InputError
        If a file is missing, damaged or breaks a rule; the message names the file, and the key
        and its value.
    """
    return read_map_and_notes(path)[0]


def read_map_and_notes(path: str | Path) -> tuple[OccupancyMap, tuple[str, ...]]:
    """Return the map of `read_map`, and what was changed in reading as sentences for people."""
    path = Path(path)
    if path.is_dir() and not (path / "map.npz").exists() and (path / "map.yaml").exists():
        path = path / "map.yaml"
    if path.suffix.lower() in _YAML:
        found = read_ros_map(path)
        return OccupancyMap.of(found), found.notes
    if path.suffix.lower() in _IMAGES:
        raise InputError(f"{path}: is an image: give the map.yaml that it belongs to")
    return OccupancyMap.load(path), ()
