"""`robot_dtype`: the state of robots as one structured array, a row a robot."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["new_states", "robot_dtype"]


def robot_dtype(sonars: int) -> np.dtype[np.void]:
    """Return the type of a robot's state.

    Fields
    ------
    time_s : float
        Time since the episode began.
    true_pose, believed_pose : float, shape (3,)
        x, y in metres and heading in radians: where it is, and where it is by odometry.
    wheel_mps : float, shape (2,)
        Mean speed of the left and right wheel over the last control step.
    touched : bool
        Whether it touched something in the last control step.
    fresh : uint8, shape (sonars,)
        1 for sonars that fired in the last control step. (Compiled code knows no array of bool
        within a record.)
    range_m, cause, axis_range_m, cone_range_m, surface, incidence_rad, bounces, source, level_db
        The newest reading of each sonar, as `sim.Echoes`; no echo before the first firing.
    fired_s, fired_true_pose, fired_pose
        When and where each of these was fired, the pose true and by odometry.
    """
    each = (sonars,)
    return np.dtype(
        [
            ("time_s", float),
            ("true_pose", float, (3,)),
            ("believed_pose", float, (3,)),
            ("wheel_mps", float, (2,)),
            ("touched", np.bool_),
            ("fresh", np.uint8, each),
            ("range_m", float, each),
            ("axis_range_m", float, each),
            ("cone_range_m", float, each),
            ("incidence_rad", float, each),
            ("level_db", float, each),
            ("fired_s", float, each),
            ("fired_true_pose", float, (sonars, 3)),
            ("fired_pose", float, (sonars, 3)),
            ("surface", np.int32, each),
            ("bounces", np.int16, each),
            ("source", np.int16, each),
            ("cause", np.int8, each),
        ],
        align=True,
    )


def new_states(robots: int, sonars: int) -> NDArray[np.void]:
    """Return the states of robots whose sonars have not fired yet."""
    states = np.zeros(robots, robot_dtype(sonars))
    for name in ("range_m", "axis_range_m", "cone_range_m"):
        states[name] = np.inf
    states["surface"] = -1
    return states
