"""`pose_error`: how far the poses of a log are from those of another, or from the true ones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from sonarmap.errors import InputError
from sonarmap.log import SonarLog

__all__ = ["PoseError", "pose_error"]


class PoseError(NamedTuple):
    """Root mean squares over the readings of a log.

    Parameters
    ----------
    place_m : float
        Of the distances between places, metres.
    heading_rad : float
        Of the angles between headings, radians, at most half a turn.
    """

    place_m: float
    heading_rad: float


def pose_error(log: SonarLog, reference: SonarLog) -> PoseError:
    """Return how far the poses of a log are from those of the same readings in another.

    Parameters
    ----------
    log : SonarLog
        Say with the poses of odometry.
    reference : SonarLog
        Say ``log.at_true_poses()``; the same readings in the same order. Nothing is aligned.

    Raises
    ------
    InputError
        If the logs do not have as many readings.
    """
    if len(log) != len(reference):
        raise InputError(f"reference must have the log's {len(log)} readings, got {len(reference)}")
    if not len(log):
        return PoseError(0.0, 0.0)
    away_m = np.hypot(log.x_m - reference.x_m, log.y_m - reference.y_m)
    turned_rad = np.angle(np.exp(1j * (log.heading_rad - reference.heading_rad)))
    return PoseError(float(np.sqrt(np.mean(away_m**2))), float(np.sqrt(np.mean(turned_rad**2))))
