"""`OccupancyMap`: what mapping makes, and its files."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sonarmap.errors import InputError, within
from sonarmap.files import atomic_path, make_folder
from sonarmap.grid import GridSpec
from sonarmap.rosmap import FREE_THRESH, OCCUPIED_THRESH, ros_image, ros_yaml

__all__ = ["FREE_UP_TO", "OCCUPIED_FROM", "P_MIN", "OccupancyMap"]

# A cell counts as known to be occupied or free beyond these, ROS map_server's upper limit and its
# mirror image, unless its map says otherwise.
OCCUPIED_FROM, FREE_UP_TO = 0.65, 0.35
# Probabilities nearer to 0 and 1 have no finite log-odds worth adding.
P_MIN = 1e-6

_NPZ, _PGM, _YAML = "map.npz", "map.pgm", "map.yaml"
_LIMITS = ("occupied_from", "free_up_to")


@dataclass(frozen=True, slots=True, eq=False)
class _Stated:
    """What a map of probabilities says that log-odds do not."""

    probability: NDArray[np.float64]
    observed: NDArray[np.bool_] | None
    occupied_from: float
    free_up_to: float


@dataclass(frozen=True, eq=False)
class OccupancyMap:
    """An occupancy grid: P(occupied) of each cell, held as log-odds or as probabilities.

    A map of evidence, as Bayesian updating makes it, is built from its log-odds. One that states
    probabilities, as any other method does, is built by `from_probability`, keeps them to the
    last bit, and may add which cells were observed and from where on they count as occupied or
    free.

    Parameters
    ----------
    grid : GridSpec
        Where the cells are.
    log_odds : ndarray, shape (rows, cols)
        Natural logarithm of the odds; 0 where nothing is known. Finite.
    """

    grid: GridSpec
    log_odds: NDArray[np.float64]
    _stated: _Stated | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        log_odds = np.array(self.log_odds, dtype=float)
        _check_shape("log_odds", log_odds, self.grid)
        if not np.isfinite(log_odds).all():
            raise InputError("log_odds must be finite in every cell")
        log_odds.flags.writeable = False
        object.__setattr__(self, "log_odds", log_odds)

    @classmethod
    def from_probability(
        cls,
        grid: GridSpec,
        p: ArrayLike,
        observed: ArrayLike | None = None,
        *,
        occupied_from: float = OCCUPIED_FROM,
        free_up_to: float = FREE_UP_TO,
    ) -> OccupancyMap:
        """Return the map that states P(occupied) cell by cell.

        Parameters
        ----------
        grid : GridSpec
            Where the cells are.
        p : array_like, shape (rows, cols)
            P(occupied), in [0, 1]. The log-odds are derived from it, clipped to those of
            [1e-6, 1 - 1e-6].
        observed : array_like of bool, shape (rows, cols), optional
            Which cells the log's sonars told anything about; the others are neither occupied nor
            free, whatever their probability. By default all.
        occupied_from, free_up_to : float
            P(occupied) from which, and up to which, a cell counts as occupied or free;
            0 <= free_up_to < occupied_from <= 1.

        Raises
        ------
        InputError
            If a shape is not the grid's, a probability is NaN or outside of [0, 1], or the
            thresholds break their rule.
        """
        probability = _column("p", p, grid)
        bad = ~((probability >= 0) & (probability <= 1))
        if bad.any():
            row, col = (int(index) for index in np.argwhere(bad)[0])
            raise InputError(f"p[{row}, {col}] must be within [0, 1], got {probability[row, col]}")
        seen = None
        if observed is not None:
            seen = np.array(observed)
            if seen.dtype != bool:
                raise InputError(f"observed must be an array of bool, got {seen.dtype}")
            _check_shape("observed", seen, grid)
            seen.flags.writeable = False
        occupied_from = within("occupied_from", occupied_from, 0, 1)
        free_up_to = within("free_up_to", free_up_to, 0, 1)
        if free_up_to >= occupied_from:
            raise InputError(
                f"free_up_to must be < occupied_from, got {free_up_to!r} and {occupied_from!r}"
            )
        clipped = probability.clip(P_MIN, 1 - P_MIN)
        stated = _Stated(probability, seen, occupied_from, free_up_to)
        return cls(grid, np.log(clipped / (1 - clipped)), stated)

    @classmethod
    def of(cls, m: Any) -> OccupancyMap:
        """Return a map of another make, which has ``.grid`` and ``.probability``, as one of these.

        ``.observed``, ``.occupied_from`` and ``.free_up_to`` are taken over where it has them.

        Raises
        ------
        InputError
            If it has no such attributes, or they break the rules of `from_probability`.
        """
        if isinstance(m, cls):
            return m
        grid, p = getattr(m, "grid", None), getattr(m, "probability", None)
        if not isinstance(grid, GridSpec) or p is None:
            kind = type(m).__name__
            hint = "; see OccupancyMap.from_probability" if isinstance(m, np.ndarray) else ""
            raise InputError(
                f"a map must have a .grid (GridSpec) and .probability, got {kind}{hint}"
            )
        return cls.from_probability(
            grid,
            p,
            getattr(m, "observed", None),
            occupied_from=getattr(m, "occupied_from", OCCUPIED_FROM),
            free_up_to=getattr(m, "free_up_to", FREE_UP_TO),
        )

    @property
    def probability(self) -> NDArray[np.float64]:
        """P(occupied) of each cell, shape (rows, cols); 0.5 where nothing is known."""
        if self._stated is not None:
            return self._stated.probability
        # tanh does not overflow where exp(-log_odds) would.
        p: NDArray[np.float64] = 0.5 * (1 + np.tanh(self.log_odds / 2))
        return p

    @property
    def observed(self) -> NDArray[np.bool_] | None:
        """Which cells were observed, shape (rows, cols); None where the map does not say."""
        return None if self._stated is None else self._stated.observed

    @property
    def occupied_from(self) -> float:
        """P(occupied) from which a cell counts as occupied."""
        return OCCUPIED_FROM if self._stated is None else self._stated.occupied_from

    @property
    def free_up_to(self) -> float:
        """P(occupied) up to which a cell counts as free."""
        return FREE_UP_TO if self._stated is None else self._stated.free_up_to

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Which cells count as occupied: observed, P >= `occupied_from`."""
        return self._observed_among(self.probability >= self.occupied_from)

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which cells count as free: observed, P <= `free_up_to`."""
        return self._observed_among(self.probability <= self.free_up_to)

    def _observed_among(self, cells: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return cells if self.observed is None else cells & self.observed

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
                resolution_m=self.grid.resolution_m,
                origin_xy_m=self.grid.origin_xy_m,
                **self._layers(),
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
                stated = "probability" in data
                values = np.asarray(data["probability" if stated else "log_odds"], float)
                observed = data.get("observed")
                limits = {name: float(data[name]) for name in _LIMITS if name in data}
        except FileNotFoundError:
            raise InputError(f"{file}: no such file") from None
        except Exception as error:  # numpy raises what zip, npy or pickle happen to raise
            raise InputError(f"{file}: is not a sonarbed map ({type(error).__name__})") from None
        try:
            grid = GridSpec(resolution_m, (x_m, y_m), values.shape)
            if stated:
                return cls.from_probability(grid, values, observed, **limits)
            return cls(grid, values)
        except InputError as error:
            raise InputError(f"{file}: {error}") from None

    def _layers(self) -> dict[str, Any]:
        """Return what ``map.npz`` keeps beside the grid."""
        if self._stated is None:
            return {"log_odds": self.log_odds}
        layers = {"probability": self.probability, **{n: getattr(self, n) for n in _LIMITS}}
        return layers if self.observed is None else {**layers, "observed": self.observed}

    def _ros_image(self) -> NDArray[np.uint8]:
        if self._stated is None:
            # Evidence that does not say what it observed: map_server's own, narrower limits.
            p = self.probability
            return ros_image(p > OCCUPIED_THRESH, p < FREE_THRESH)
        return ros_image(self.occupied, self.free)

    def _ros_yaml(self) -> str:
        return ros_yaml(self.grid, _PGM)


def _column(name: str, values: ArrayLike, grid: GridSpec) -> NDArray[np.float64]:
    """Return cells as a read-only array of the grid's shape."""
    try:
        cells = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"{name} must be an array of numbers, got {values!r}") from None
    _check_shape(name, cells, grid)
    cells.flags.writeable = False
    return cells


def _check_shape(name: str, cells: NDArray[Any], grid: GridSpec) -> None:
    if cells.shape != grid.shape:
        raise InputError(f"{name} must have the grid's shape {grid.shape}, got {cells.shape}")
