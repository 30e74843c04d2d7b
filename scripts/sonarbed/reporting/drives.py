"""The usual drive of a room: what studies that look at every room have in common."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.reporting.setting import Setting

__all__ = ["usual_drive", "usual_driver"]


def usual_driver(room: str) -> str:
    """Return who drives in a room: along its route if it has one, else on the thesis's circle."""
    return "route" if worlds.load(room).route_m else "thesis"


def usual_drive(
    setting: Setting, room: str, seed: int, *, resolution_m: float = 0.05
) -> tuple[sm.SonarLog, worlds.TruthGrid, NDArray[np.bool_]]:
    """Return the log of a room's usual drive, the truth, and the cells observable from it."""
    (log,) = setting.logs(room, driver=usual_driver(room), seeds=[seed])
    truth = worlds.truth(worlds.load(room), resolution_m=resolution_m)
    return log, truth, truth.observable(log)
