"""`refine_poses`: the poses of odometry, moved so that echoes agree on walls."""

from __future__ import annotations

import numpy as np

from sonarmap.errors import positive
from sonarmap.log import SonarLog
from sonarmap.poses.echoes import used_echoes
from sonarmap.poses.fitting import fitted
from sonarmap.poses.path import CorrectedPath, OdometryErrors
from sonarmap.poses.walls import find_walls

__all__ = ["refine_poses"]

# How far echoes may lie off a wall, round by round: first walls are blurred by the drift that is
# looked for, at last they are as sharp as the sonar (metres; chosen on generated rooms).
_SIGMAS_M = (0.12, 0.08, 0.05, 0.03, 0.02, 0.01)
_FITS = 2
_LEAST_ECHOES = 20


def refine_poses(
    log: SonarLog, errors: OdometryErrors | None = None, *, knot_m: float = 1.0
) -> SonarLog:
    """Return the log with poses at which its echoes agree better on walls.

    The errors of odometry (of distances, of turns, and a drift of the heading, linear between
    knots) and the walls are estimated together, as nonlinear least squares with a robust loss.
    Walls that are nearly square to most others are taken to be so. What the echoes do not tell
    stays as odometry has it. The first pose stays where it is. It mends a drift of centimetres and
    degrees; it is no SLAM: a place that is visited again is not recognised, and a path that is off
    by more than walls are apart is not found back.

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
    echoes = used_echoes(log, path)
    if len(echoes.rows) < _LEAST_ECHOES:
        return log
    parameters = np.zeros(path.parameters)
    for sigma_m in _SIGMAS_M:
        walls = find_walls(echoes.seen(path, parameters), sigma_m)
        for _ in range(_FITS):
            if not len(walls):
                break
            parameters, walls = fitted(echoes, path, parameters, walls, sigma_m)
    xy_m, heading_rad = path.poses(parameters)
    return log.replace(x_m=xy_m[:, 0], y_m=xy_m[:, 1], heading_rad=heading_rad)
