"""One log mapped by many sensor models, with how each disagrees with itself about a cell."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import one_of, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.bayes.models import (
    THESIS_UNIT_M,
    ParameterizedModel,
    Regions,
    SensorModel,
)
from sonarmap.methods.bayes.updating import NoEcho, evidence_of, reading_limit_m
from sonarmap.occupancy import OccupancyMap

if TYPE_CHECKING:  # numba is heavy: loaded when mapping
    from sonarmap.kernels.fusion import ConeLists

__all__ = ["Spread", "map_and_spread", "thesis_parameter_sets"]

# Equal values need not be bit-equal when they were computed at different places of a vector.
_ZERO_DEVIATION = 1e-9
# Cells of cones that are kept at a time: 16 bytes each, 256 MB. The thesis's search needs a tenth.
_MOST_CELLS = 16_000_000


@dataclass(frozen=True, eq=False)
class Spread:
    """How the probabilities that readings gave each cell spread; every array (rows, cols).

    Parameters
    ----------
    grid : GridSpec
        Where the cells are.
    readings : ndarray of int
        Number of readings that spoke of the cell: N.
    mean : ndarray
        Mean of the P(occupied) that they gave it; 0 where none spoke.
    squared_deviation : ndarray
        Sum of the squared deviations from that mean.
    """

    grid: GridSpec
    readings: NDArray[np.int64]
    mean: NDArray[np.float64]
    squared_deviation: NDArray[np.float64]

    @property
    def updated(self) -> NDArray[np.bool_]:
        """Which cells any reading spoke of."""
        return self.readings > 0

    @property
    def standard_deviation(self) -> NDArray[np.float64]:
        """Standard deviation (N - 1) of each cell; 0 where fewer than two readings spoke."""
        deviation: NDArray[np.float64] = np.sqrt(
            self.squared_deviation / np.maximum(self.readings - 1, 1)
        )
        return deviation

    @property
    def vsdns(self) -> float:
        """Mean of the non-zero standard deviations; lower is better. NaN if all are zero."""
        deviation = self.standard_deviation
        nonzero = deviation[deviation > _ZERO_DEVIATION]
        return float(nonzero.mean()) if nonzero.size else math.nan


def thesis_parameter_sets() -> tuple[ParameterizedModel, ...]:
    """Return the 1440 sets of the thesis's search (table 5.1), in the order of P5, 2 P3, P4, P2."""
    return tuple(
        ParameterizedModel(
            p1=round(1 - p4, 2),
            p2=p2,
            p3_m=twice_p3 / 2 * THESIS_UNIT_M,
            p4=p4,
            p5_rad=math.radians(p5),
        )
        for p5 in (*range(6, 16), 20, 25, 30, 35, 40)
        for twice_p3 in (0.5, 1, 1.5, 2, 2.5, 3)
        for p4 in (0.95, 0.96, 0.97, 0.98)
        for p2 in (0.05, 0.10, 0.15, 0.20)
    )


def map_and_spread(
    log: SonarLog,
    models: Iterable[SensorModel],
    grid: GridSpec,
    *,
    max_range_m: float | None = None,
    no_echo: NoEcho = "ignore",
    poses: Literal["odometry", "true"] = "odometry",
) -> Iterator[tuple[OccupancyMap, Spread]]:
    """Map one log by many models, with the spread of what each says of every cell.

    The map is `sonarmap.build_map`'s. The cells of the cones, their ranges and bearings are
    listed once for models that follow one another and have the same half-angle, as those of
    `thesis_parameter_sets` do.

    Parameters
    ----------
    log, grid, max_range_m, no_echo, poses
        As for `sonarmap.build_map`.
    models : iterable of SensorModel
        The models.

    Yields
    ------
    map : OccupancyMap
    spread : Spread
        In the order of the models. The spread is of the probabilities that enter the map,
        clipped to [1e-6, 1 - 1e-6].

    Raises
    ------
    InputError
        If an argument breaks its rule.
    """
    one_of("no_echo", no_echo, get_args(NoEcho))
    one_of("poses", poses, ("odometry", "true"))
    if max_range_m is not None:
        positive("max_range_m", max_range_m)
    if poses == "true":
        log = log.at_true_poses()
    # The checks above are made at the call; a generator would make them at its first value.
    return _map_and_spread(log, models, grid, max_range_m, no_echo)


def _map_and_spread(
    log: SonarLog,
    models: Iterable[SensorModel],
    grid: GridSpec,
    max_range_m: float | None,
    no_echo: NoEcho,
) -> Iterator[tuple[OccupancyMap, Spread]]:
    def shared(model: SensorModel) -> tuple[float, float]:
        return model.half_angle_rad, reading_limit_m(log.ring, model, max_range_m)

    sensor_xy_m, axis_rad = log.sensor_xy_m, log.axis_rad
    for (half_angle_rad, limit_m), group in itertools.groupby(models, shared):
        alike = tuple(group)
        used, _ = evidence_of(log, alike[0], limit_m, no_echo)
        # Cones are listed as far as any of these models reaches.
        reach_m = np.zeros(int(used.sum()))
        for model in alike:
            np.maximum(reach_m, evidence_of(log, model, limit_m, no_echo)[1].reach_m, out=reach_m)
        cones = _Cones(grid, sensor_xy_m[used], axis_rad[used], half_angle_rad, reach_m)
        for model in alike:
            yield _fuse(grid, cones, evidence_of(log, model, limit_m, no_echo)[1])


def _fuse(grid: GridSpec, cones: _Cones, regions: Regions) -> tuple[OccupancyMap, Spread]:
    from sonarmap.kernels.fusion import add_listed

    cells = grid.rows * grid.cols
    log_odds, seen, mean, deviation = (np.zeros(cells) for _ in range(4))
    for rows, lists in cones:
        add_listed(
            log_odds,
            seen,
            mean,
            deviation,
            *lists,
            regions.border_m[rows],
            regions.axis[rows],
            regions.edge[rows],
        )
    return OccupancyMap(grid, log_odds.reshape(grid.shape)), Spread(
        grid,
        seen.astype(np.int64).reshape(grid.shape),
        mean.reshape(grid.shape),
        deviation.reshape(grid.shape),
    )


class _Cones:
    """The cells of readings' cones, as (slice of readings, lists of `list_cones`).

    All are kept when they fit in `_MOST_CELLS`. Otherwise they are listed part by part, each time
    anew: slower, but the memory stays bounded.
    """

    def __init__(
        self,
        grid: GridSpec,
        sensor_xy_m: NDArray[np.float64],
        axis_rad: NDArray[np.float64],
        half_angle_rad: float,
        reach_m: NDArray[np.float64],
    ) -> None:
        from sonarmap.kernels import fusion  # numba: loaded when mapping

        self._cells = fusion.GridCells(*grid.shape, *grid.origin_xy_m, grid.resolution_m)
        self._sensors = fusion.Sensors(sensor_xy_m, axis_rad)
        self._cone = fusion.Cone(half_angle_rad, fusion.bearing_polynomial(half_angle_rad))
        self._reach_m = reach_m
        self._bounds = fusion.count_cells(self._cells, self._sensors, half_angle_rad, reach_m)
        parts = self._bounds[:, 0].cumsum() // _MOST_CELLS
        begins = [0, *(np.flatnonzero(np.diff(parts)) + 1).tolist(), reach_m.size]
        self._slices = [slice(a, b) for a, b in itertools.pairwise(begins)]
        self._kept = self._list(self._slices[0]) if len(self._slices) == 1 else None

    def __iter__(self) -> Iterator[tuple[slice, ConeLists]]:
        for rows in self._slices:
            yield rows, self._list(rows) if self._kept is None else self._kept

    def _list(self, rows: slice) -> ConeLists:
        from sonarmap.kernels.fusion import Sensors, list_cones

        lists: ConeLists = list_cones(
            self._cells,
            Sensors(self._sensors.xy[rows], self._sensors.axis_rad[rows]),
            self._cone,
            self._reach_m[rows],
            self._bounds[rows],
        )
        return lists
