"""`build_map`: from a log to a map, by a sensor model or any mapping method."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from sonarmap.errors import InputError, one_of, resolves
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.bayes.models import SensorModel
from sonarmap.methods.bayes.updating import Bayes, NoEcho
from sonarmap.methods.choosing import as_method
from sonarmap.methods.protocol import MappingMethod
from sonarmap.occupancy import OccupancyMap

__all__ = ["Poses", "build_map", "grid_for", "grid_over"]

Poses = Literal["odometry", "true"]

DEFAULT_RESOLUTION_M = 0.05


def build_map(
    log: SonarLog,
    model: SensorModel | MappingMethod | Callable[[SonarLog, GridSpec], ArrayLike],
    grid: GridSpec | None = None,
    *,
    max_range_m: float | None = None,
    no_echo: NoEcho = "ignore",
    poses: Poses = "odometry",
    log_odds_limit: float = math.inf,
) -> OccupancyMap:
    """Build the occupancy map of a log.

    Parameters
    ----------
    log : SonarLog
        The readings. Stale, rejected and too close ones (``-inf``) are never used.
    model : SensorModel, MappingMethod or callable
        `StandardModel` or `ParameterizedModel`, whose readings are fused by Bayesian updating
        (`sonarmap.methods.bayes.updating`); a method of `sonarmap.method`; or a function of a log
        and a grid that returns P(occupied), shape (rows, cols).
    grid : GridSpec, optional
        Where to map; by default `grid_over` the log at 5 cm.
    max_range_m, no_echo, log_odds_limit
        Of Bayesian updating with a sensor model, see `BayesUpdating`. A method has parameters of
        its own.
    poses : {"odometry", "true"}
        Whose poses to use; "true" needs a simulated log.

    Returns
    -------
    OccupancyMap

    Raises
    ------
    InputError
        If an argument breaks its rule, or belongs to a sensor model and a method is given.
    """
    one_of("poses", poses, get_args(Poses))
    updating: dict[str, Any] = {
        "max_range_m": max_range_m,
        "no_echo": no_echo,
        "log_odds_limit": log_odds_limit,
    }
    method: MappingMethod
    if isinstance(model, SensorModel):
        method = Bayes(model, **updating)
    else:
        method = as_method(model)
        for name, value in updating.items():
            if value != getattr(Bayes, name):
                raise InputError(
                    f"{name} belongs to a sensor model, got {value!r} with method "
                    f"{method.name!r}: give it to the method"
                )
    if poses == "true":
        log = log.at_true_poses()
    return method.map(log, grid_for(log, method) if grid is None else grid)


def grid_for(
    log: SonarLog, method: MappingMethod, *, resolution_m: float = DEFAULT_RESOLUTION_M
) -> GridSpec:
    """Return the grid over what a method makes of a log.

    A method that has ``longest_reading_m(ring)`` says by it up to which range it uses readings;
    data points beyond do not count. See `grid_over`.
    """
    longest_m = getattr(method, "longest_reading_m", None)
    limit_m = None if longest_m is None else longest_m(log.ring)
    return grid_over(log, resolution_m=resolution_m, max_range_m=limit_m)


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
    resolves(resolution_m, float(x_max - x_min), float(y_max - y_min))
    return GridSpec.covering(float(x_min), float(y_min), float(x_max), float(y_max), resolution_m)
