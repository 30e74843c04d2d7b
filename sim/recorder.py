"""The recorder: scans come in one by one, a `SonarLog` goes out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.acoustics import Echoes
from sonarmap import LogTruth, SonarLog, SonarRing
from worlds import Pose, World

__all__ = ["Recorder"]


class Recorder:
    """Collects the scans of a drive.

    Parameters
    ----------
    ring : SonarRing
        The sonars; every scan has one reading of each.
    world : World
        Whose surfaces the echoes name by number.
    """

    def __init__(self, ring: SonarRing, world: World) -> None:
        self._ring = ring
        # One name more: -1, no surface, is the last.
        self._surfaces = np.array([solid.name for solid in world.solids] + [""])
        self._times: list[float] = []
        self._believed: list[Pose] = []
        self._true: list[Pose] = []
        self._echoes: list[Echoes] = []
        self._touched: list[bool] = []

    def add(
        self, time_s: float, believed: Pose, true: Pose, echoes: Echoes, *, touched: bool
    ) -> None:
        """Add a scan: its time, the pose by odometry, the true one, what was heard."""
        self._times.append(time_s)
        self._believed.append(believed)
        self._true.append(true)
        self._echoes.append(echoes)
        self._touched.append(touched)

    def log(self, provenance: Mapping[str, Any]) -> SonarLog:
        """Return the log of the scans so far."""
        scans, sonars = len(self._times), len(self._ring)

        def each(values: Any) -> Any:
            return np.repeat(np.array(values), sonars)

        def heard(name: str) -> Any:
            return np.concatenate([getattr(echoes, name) for echoes in self._echoes])

        truth = LogTruth(
            x_m=each([pose.x_m for pose in self._true]),
            y_m=each([pose.y_m for pose in self._true]),
            heading_rad=each([pose.heading_rad for pose in self._true]),
            axis_range_m=heard("axis_range_m"),
            cone_range_m=heard("cone_range_m"),
            cause=heard("cause"),
            surface=self._surfaces[heard("surface")],
            incidence_rad=heard("incidence_rad"),
            bounces=heard("bounces"),
            collision=each(self._touched),
        )
        return SonarLog(
            ring=self._ring,
            scan=each(range(scans)),
            sonar=np.tile(np.arange(sonars), scans),
            time_s=each(self._times),
            x_m=each([pose.x_m for pose in self._believed]),
            y_m=each([pose.y_m for pose in self._believed]),
            heading_rad=each([pose.heading_rad for pose in self._believed]),
            range_m=heard("range_m"),
            truth=truth,
            provenance=provenance,
        )
