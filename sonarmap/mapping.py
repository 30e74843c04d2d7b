"""From a log to a map: Bayesian updating of an occupancy grid (Rashid 2006, section 4.4)."""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import InputError, did_you_mean, positive
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.bayes.models import Regions, SensorModel
from sonarmap.occupancy import OccupancyMap

__all__ = ["NoEcho", "Poses", "build_map", "grid_over"]

NoEcho = Literal["ignore", "clear"]
Poses = Literal["odometry", "true"]

DEFAULT_RESOLUTION_M = 0.05


def build_map(
    log: SonarLog,
    model: SensorModel,
    grid: GridSpec | None = None,
    *,
    max_range_m: float | None = None,
    no_echo: NoEcho = "ignore",
    poses: Poses = "odometry",
    log_odds_limit: float = math.inf,
) -> OccupancyMap:
    """Build the occupancy map of a log.

    A cell is updated by a reading when its centre lies within the model's half-angle of the
    acoustic axis and within its reach of the sonar. Probabilities are clipped to
    [1e-6, 1 - 1e-6] and added as log-odds: equation 4.14, whose printed denominator has an index
    slip (both of its factors belong to reading n). The order of the readings does not matter.

    Parameters
    ----------
    log : SonarLog
        The readings. Stale repeats and too-close readings (``-inf``) are never used.
    model : SensorModel
        `StandardModel` or `ParameterizedModel`.
    grid : GridSpec, optional
        Where to map; by default `grid_over` the log at 5 cm.
    max_range_m : float, optional
        Readings above it are taken as no echo. By default the ring's maximum range, or the
        model's if that is less.
    no_echo : {"ignore", "clear"}
        What no echo means: nothing, or that the cone is free up to `max_range_m` (less the
        model's tolerance).
    poses : {"odometry", "true"}
        Whose poses to use; "true" needs a simulated log.
    log_odds_limit : float, optional
        Bound on the absolute log-odds of a cell, > 0. Off by default; with it the order of the
        readings matters.

    Returns
    -------
    OccupancyMap

    Raises
    ------
    InputError
        If an argument breaks its rule.
    """
    one_of("no_echo", no_echo, get_args(NoEcho))
    one_of("poses", poses, get_args(Poses))
    if not log_odds_limit > 0:
        raise InputError(f"log_odds_limit must be > 0, got {log_odds_limit!r}")
    if poses == "true":
        log = log.at_true_poses()
    limit_m = reading_limit_m(log, model, max_range_m)
    if grid is None:
        grid = grid_over(log, max_range_m=limit_m)

    used, regions = evidence_of(log, model, limit_m, no_echo)
    log_odds = np.zeros(grid.shape)
    _fuse(log_odds, grid, log.sensor_xy_m[used], log.axis_rad[used], model, regions, log_odds_limit)
    return OccupancyMap(grid, log_odds)


def grid_over(
    log: SonarLog,
    *,
    resolution_m: float = DEFAULT_RESOLUTION_M,
    max_range_m: float | None = None,
    margin_m: float = 0.5,
) -> GridSpec:
    """Return the grid over a log's sonar positions and data points, with a margin around.

    Parameters
    ----------
    log : SonarLog
        The log.
    resolution_m : float
        Side of a cell, metres, > 0.
    max_range_m : float, optional
        Data points of longer readings do not count; by default the ring's maximum range.
    margin_m : float
        Margin on each side, metres.
    """
    limit_m = log.ring.range_max_m if max_range_m is None else max_range_m
    points = np.concatenate([log.sensor_xy_m, log.point_xy_m[log.range_m <= limit_m]])
    points = points[np.isfinite(points).all(axis=1)]
    if points.size == 0:
        raise InputError("the log is empty: there is nothing to map")
    x_min, y_min = points.min(axis=0) - margin_m
    x_max, y_max = points.max(axis=0) + margin_m
    return GridSpec.covering(float(x_min), float(y_min), float(x_max), float(y_max), resolution_m)


def reading_limit_m(log: SonarLog, model: SensorModel, max_range_m: float | None) -> float:
    """Return the range above which a reading is taken as no echo, metres."""
    limit_m = log.ring.range_max_m if max_range_m is None else positive("max_range_m", max_range_m)
    return min(limit_m, model.range_limit_m)


def evidence_of(
    log: SonarLog, model: SensorModel, limit_m: float, no_echo: NoEcho
) -> tuple[NDArray[np.bool_], Regions]:
    """Return which readings say something (a mask), and the regions of those.

    Readings above `limit_m` are taken as no echo.
    """
    echo = ~log.stale & (log.range_m <= limit_m) & (log.range_m >= 0)
    if no_echo == "ignore":
        return echo, model.regions(log.range_m[echo])
    used = ~log.stale & (log.range_m >= 0)
    regions = model.free_regions(np.full(int(used.sum()), limit_m))
    heard = echo[used]
    measured = model.regions(log.range_m[echo])
    regions.border_m[heard] = measured.border_m
    regions.axis[heard] = measured.axis
    regions.edge[heard] = measured.edge
    return used, regions


def _fuse(
    log_odds: NDArray[np.float64],
    grid: GridSpec,
    sensor_xy_m: NDArray[np.float64],
    axis_rad: NDArray[np.float64],
    model: SensorModel,
    regions: Regions,
    limit: float,
) -> None:
    from sonarmap.kernels.fusion import (  # numba: loaded when mapping
        add_readings,
        bearing_polynomial,
    )

    add_readings(
        log_odds,
        *grid.origin_xy_m,
        grid.resolution_m,
        sensor_xy_m,
        axis_rad,
        model.half_angle_rad,
        regions.border_m,
        regions.axis,
        regions.edge,
        bearing_polynomial(model.half_angle_rad),
        limit,
    )


def one_of(name: str, value: str, known: tuple[str, ...]) -> None:
    """Raise `InputError` if `value` is none of the known words."""
    if value not in known:
        raise InputError(f"{name} {value!r} is unknown{did_you_mean(str(value), known)}")
