"""What a log would be if sonars heard nothing from off their axes."""

from __future__ import annotations

import numpy as np

import sonarmap as sm

__all__ = ["heard_on_axis"]


def heard_on_axis(log: sm.SonarLog) -> sm.SonarLog:
    """Return the log as if no echo came from off the axis: such readings take no part.

    What a filter does to this log shows what the width of the cone has to do with it. The
    positions of robot and sonar stay.
    """
    off_axis = log.require_truth("a log without off-axis echoes").cause == sm.Cause.OFF_AXIS
    return log.replace(range_m=np.where(off_axis, -np.inf, log.range_m))
