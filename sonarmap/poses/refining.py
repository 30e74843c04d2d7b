"""`refine_poses`: the poses of odometry, moved so that echoes agree on walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sonarmap.errors import positive
from sonarmap.log import SonarLog
from sonarmap.poses.path import CorrectedPath, OdometryErrors
from sonarmap.poses.walls import Echoes, Walls, attributed, find_walls

__all__ = ["refine_poses"]

# How far echoes may lie off a wall, round by round: first walls are blurred by the drift that is
# looked for, at last they are as sharp as the sonar (metres; chosen on generated rooms).
_SIGMAS_M = (0.12, 0.08, 0.05, 0.03, 0.02, 0.02)
_FITS, _STEPS = 3, 5
# An echo counts as half of one: neighbours err alike (chosen on generated rooms).
_TEMPER = 0.5
# Farther echoes come by way of mirrors more often, and mislead more if they do (assumed).
_FARTHEST_M = 4.0
# A robot that stands hears the same again: this way of the wheels between two echoes of a sonar.
_APART_M = 0.05
_LEAST_WEIGHT = 0.02
# More echoes take time and memory, and say little more.
_MOST_ECHOES = 20_000
_LEAST_ECHOES = 20


def refine_poses(
    log: SonarLog, errors: OdometryErrors | None = None, *, knot_m: float = 1.0
) -> SonarLog:
    """Return the log with poses at which its echoes agree better on walls.

    The errors of odometry (of distances, of turns, and a drift of the heading, linear between
    knots) and the walls are estimated together, as nonlinear least squares with a robust loss; what
    the echoes do not tell stays as odometry has it. The first pose stays where it is. It mends a
    drift of centimetres and degrees; it is no SLAM: a place that is visited again is not
    recognised, and a path that is off by more than walls are apart is not found back.

    Parameters
    ----------
    log : SonarLog
        A drive with poses by odometry. Stale and rejected readings are not used, but their poses
        are refined, too. It needs no truth, and does not look at it.
    errors : OdometryErrors, optional
        How wrong the odometry may be. By default that of a small robot like the AmigoBot.
    knot_m : float
        Way of the wheels between two knots of the drift, metres. On ways beyond a hundred of these
        the knots lie farther apart.

    Returns
    -------
    SonarLog
        With `x_m`, `y_m` and `heading_rad` replaced. The same log if it has fewer than 20 echoes.

    Raises
    ------
    InputError
        If `knot_m` is not positive.

    Notes
    -----
    Time and memory grow with the readings; of more than 20,000 echoes some are left out.

    Examples
    --------
    >>> refined = sm.refine_poses(log)
    >>> m = sm.method("learned").map(refined, grid)
    """
    positive("knot_m", knot_m)
    if len(log) == 0:
        return log
    path = CorrectedPath(log, OdometryErrors() if errors is None else errors, knot_m)
    told = _told(log, path)
    if len(told.rows) < _LEAST_ECHOES:
        return log
    parameters = np.zeros(path.parameters)
    for sigma_m in _SIGMAS_M:
        walls = find_walls(told.seen(path, parameters), sigma_m)
        for _ in range(_FITS):
            if not len(walls):
                break
            parameters, walls = _fitted(told, path, parameters, walls, sigma_m)
    xy_m, heading_rad = path.poses(parameters)
    return log.replace(x_m=xy_m[:, 0], y_m=xy_m[:, 1], heading_rad=heading_rad)


@dataclass(frozen=True, eq=False)
class _Told:
    """The echoes that are used: their rows in the log, and what does not depend on poses."""

    log: SonarLog
    rows: NDArray[np.intp]
    weight: NDArray[np.float64]

    def seen(self, path: CorrectedPath, parameters: NDArray[np.float64]) -> Echoes:
        """Return the echoes as seen from the poses of some parameters."""
        log, rows = self.log, self.rows
        xy_m, heading_rad = (poses[rows] for poses in path.poses(parameters))
        sonar = log.sonar[rows]
        return Echoes(
            log.ring.sensor_xy_m(sonar, xy_m[:, 0], xy_m[:, 1], heading_rad),
            heading_rad + log.ring.heading_rad[sonar],
            log.range_m[rows],
            self.weight,
            log.ring.half_angle_rad,
        )


def _told(log: SonarLog, path: CorrectedPath) -> _Told:
    """Choose echoes, and weigh those that repeat others less."""
    heard = log.usable & np.isfinite(log.range_m) & (log.range_m <= _FARTHEST_M)
    rows = np.flatnonzero(heard)
    order = rows[np.lexsort((rows, log.sonar[rows]))]
    apart_m = np.diff(path.way_m[order], prepend=-np.inf)
    apart_m[np.diff(log.sonar[order], prepend=-1) != 0] = np.inf
    weight = np.minimum(apart_m / _APART_M, 1.0)
    kept = np.flatnonzero(weight > _LEAST_WEIGHT)
    kept = kept[np.argsort(order[kept])]
    kept = kept[:: max(1, -(-len(kept) // _MOST_ECHOES))]
    return _Told(log, order[kept], weight[kept])


def _fitted(
    told: _Told,
    path: CorrectedPath,
    parameters: NDArray[np.float64],
    walls: Walls,
    sigma_m: float,
) -> tuple[NDArray[np.float64], Walls]:
    """Return parameters and those of the walls that have echoes, moved to agree."""
    from scipy.optimize import least_squares  # heavy: loaded when poses are refined

    echo, wall = attributed(told.seen(path, parameters), walls, sigma_m)
    if not len(echo):
        return parameters, walls[:0]
    used, wall = np.unique(wall, return_inverse=True)
    own = _Told(told.log, told.rows[echo], told.weight[echo])
    m, n, each = path.parameters, len(echo), np.arange(len(echo))
    weight = _TEMPER * own.weight

    def residuals(x: NDArray[np.float64]) -> NDArray[np.float64]:
        seen, normal_rad = own.seen(path, x[:m]), x[m::2][wall]
        x_m, y_m = seen.place_m.T
        off_m = np.cos(normal_rad) * x_m + np.sin(normal_rad) * y_m + seen.range_m
        off_m -= x[m + 1 :: 2][wall]
        return np.concatenate([off_m / sigma_m, path.prior @ x[:m]])

    def jacobian(x: NDArray[np.float64]) -> NDArray[np.float64]:
        seen, normal_rad = own.seen(path, x[:m]), x[m::2][wall]
        moves, turns = path.derivatives(x[:m], own.rows)
        centre_m = path.poses(x[:m])[0][own.rows]
        arm_x_m, arm_y_m = (seen.place_m - centre_m).T
        cos, sin = np.cos(normal_rad), np.sin(normal_rad)
        rates = np.zeros((n + m, len(x)))
        rates[:n, :m] = cos[:, None] * moves[:, 0] + sin[:, None] * moves[:, 1]
        rates[:n, :m] += (sin * arm_x_m - cos * arm_y_m)[:, None] * turns
        rates[each, m + 2 * wall] = cos * seen.place_m[:, 1] - sin * seen.place_m[:, 0]
        rates[each, m + 2 * wall + 1] = -1.0
        rates[:n] /= sigma_m
        rates[n:, :m] = path.prior
        return rates

    def loss(squared: NDArray[np.float64]) -> NDArray[np.float64]:
        """Cauchy's for echoes, of which some are no wall's; the prior as it is."""
        told_of = np.zeros((3, n + m))
        told_of[0, n:], told_of[1, n:] = squared[n:], 1.0
        one_more = 1 + squared[:n]
        told_of[:, :n] = weight * np.array([np.log(one_more), 1 / one_more, -1 / one_more**2])
        return told_of

    start = np.concatenate([parameters, walls[used].ravel()])
    found = least_squares(
        residuals,
        start,
        jacobian,
        loss=loss,  # type: ignore[arg-type]  # the stubs know but one shape
        max_nfev=_STEPS,
        x_scale="jac",
    )
    return found.x[:m], found.x[m:].reshape(-1, 2)
