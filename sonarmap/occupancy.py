"""`OccupancyMap`: what mapping makes, and its files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError
from sonarmap.files import atomic_path, make_folder
from sonarmap.grid import GridSpec

__all__ = ["OccupancyMap"]

# ROS map_server's own defaults. 0.196 is what makes its grey 205, (255 - 205) / 255, unknown.
ROS_OCCUPIED_THRESH = 0.65
ROS_FREE_THRESH = 0.196
_ROS_GREY = {"occupied": 0, "unknown": 205, "free": 254}

_NPZ, _PGM, _YAML = "map.npz", "map.pgm", "map.yaml"


@dataclass(frozen=True, eq=False)
class OccupancyMap:
    """An occupancy grid: the log-odds of each cell being occupied.

    Parameters
    ----------
    grid : GridSpec
        Where the cells are.
    log_odds : ndarray, shape (rows, cols)
        Natural logarithm of the odds; 0 where nothing is known. Finite.
    """

    grid: GridSpec
    log_odds: NDArray[np.float64]

    def __post_init__(self) -> None:
        log_odds = np.array(self.log_odds, dtype=float)
        if log_odds.shape != self.grid.shape:
            raise InputError(
                f"log_odds must have the grid's shape {self.grid.shape}, got {log_odds.shape}"
            )
        if not np.isfinite(log_odds).all():
            raise InputError("log_odds must be finite in every cell")
        log_odds.flags.writeable = False
        object.__setattr__(self, "log_odds", log_odds)

    @property
    def probability(self) -> NDArray[np.float64]:
        """P(occupied) of each cell, shape (rows, cols); 0.5 where nothing is known."""
        # tanh does not overflow where exp(-log_odds) would.
        p: NDArray[np.float64] = 0.5 * (1 + np.tanh(self.log_odds / 2))
        return p

    def save(self, folder: str | Path) -> None:
        """Save ``map.npz`` (exact) and the ROS map_server pair ``map.yaml``, ``map.pgm``.

        Parameters
        ----------
        folder : str or Path
            Made if it does not exist; older maps in it are replaced.
        """
        folder = make_folder(folder)
        rows, cols = self.grid.shape
        # All are written before the first is renamed: no mixture of an old map and a new one.
        with (
            atomic_path(folder / _NPZ) as npz,
            atomic_path(folder / _PGM) as pgm,
            atomic_path(folder / _YAML) as yaml,
        ):
            np.savez_compressed(
                npz,
                log_odds=self.log_odds,
                resolution_m=self.grid.resolution_m,
                origin_xy_m=self.grid.origin_xy_m,
            )
            pgm.write_bytes(f"P5\n{cols} {rows}\n255\n".encode() + self._ros_image().tobytes())
            yaml.write_text(self._ros_yaml(), encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> OccupancyMap:
        """Load the map that `save` wrote, from its folder or its ``map.npz``.

        Raises
        ------
        InputError
            If there is no such file or it is not a map.
        """
        path = Path(path)
        file = path / _NPZ if path.is_dir() else path
        try:
            # Opened here, because numpy leaves a damaged file open.
            with file.open("rb") as stream, np.load(stream, allow_pickle=False) as data:
                resolution_m = float(data["resolution_m"])
                x_m, y_m = data["origin_xy_m"].tolist()
                log_odds = np.asarray(data["log_odds"], float)
        except FileNotFoundError:
            raise InputError(f"{file}: no such file") from None
        except Exception as error:  # numpy raises what zip, npy or pickle happen to raise
            raise InputError(f"{file}: is not a sonarbed map ({type(error).__name__})") from None
        try:
            return cls(GridSpec(resolution_m, (x_m, y_m), log_odds.shape), log_odds)
        except InputError as error:
            raise InputError(f"{file}: {error}") from None

    def _ros_image(self) -> NDArray[np.uint8]:
        p = self.probability
        image = np.full(self.grid.shape, _ROS_GREY["unknown"], np.uint8)
        image[p > ROS_OCCUPIED_THRESH] = _ROS_GREY["occupied"]
        image[p < ROS_FREE_THRESH] = _ROS_GREY["free"]
        # An image's first row is the top one, a grid's is the bottom one.
        return image[::-1]

    def _ros_yaml(self) -> str:
        x_m, y_m = self.grid.origin_xy_m
        return (
            f"image: {_PGM}\n"
            "mode: trinary\n"
            f"resolution: {self.grid.resolution_m!r}\n"
            f"origin: [{x_m!r}, {y_m!r}, 0.0]\n"
            "negate: 0\n"
            f"occupied_thresh: {ROS_OCCUPIED_THRESH}\n"
            f"free_thresh: {ROS_FREE_THRESH}\n"
        )
