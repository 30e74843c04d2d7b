"""The recorder: firings and their echoes come in one by one, a `SonarLog` goes out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.runs.packets import StatusPackets, in_packets
from sim.sonar.protocol import Echoes
from sonarmap import LogTruth, SonarLog, SonarRing
from worlds import Pose, World

__all__ = ["Recorder"]


class Recorder:
    """Collects the readings of a drive.

    Parameters
    ----------
    ring : SonarRing
        The sonars.
    world : World
        Whose surfaces the echoes name by number.
    packets : StatusPackets, optional
        How the robot reports its readings. None: each reading once, as it was fired.
    """

    def __init__(self, ring: SonarRing, world: World, packets: StatusPackets | None = None) -> None:
        self._ring, self._packets = ring, packets
        # One name more: -1, no surface, is the last.
        self._surfaces = np.array([solid.name for solid in world.solids] + [""])
        self._firings: list[tuple[int, int, float, Pose, Pose]] = []
        self._echoes: list[Echoes] = []
        self._touched: list[bool] = []
        self._sent: list[tuple[float, Pose]] = []

    def fired(
        self, scan: int, time_s: float, sonars: tuple[int, ...], believed: Pose, true: Pose
    ) -> None:
        """Record that sonars fired: in which scan, when, the pose by odometry, the true one."""
        self._firings += [(scan, sonar, time_s, believed, true) for sonar in sonars]

    def detected(self, echoes: Echoes, *, touched: bool) -> None:
        """Record what the firings since the last call detected, and whether the robot touched."""
        self._echoes.append(echoes)
        self._touched += [touched] * len(echoes.range_m)

    def packet(self, time_s: float, believed: Pose) -> None:
        """Record the time of a packet and the pose by odometry in it."""
        self._sent.append((time_s, believed))

    def log(self, provenance: Mapping[str, Any]) -> SonarLog:
        """Return the log of all readings so far."""
        scan, sonar, time_s, believed, true = zip(*self._firings, strict=True)

        def detected(name: str) -> Any:
            return np.concatenate([getattr(echoes, name) for echoes in self._echoes])

        truth = LogTruth(
            **_columns(true),
            axis_range_m=detected("axis_range_m"),
            cone_range_m=detected("cone_range_m"),
            cause=detected("cause"),
            surface=self._surfaces[detected("surface")],
            incidence_rad=detected("incidence_rad"),
            bounces=detected("bounces"),
            collision=np.array(self._touched),
            source=detected("source"),
            level_db=detected("level_db"),
        )
        log = SonarLog(
            ring=self._ring,
            scan=np.array(scan),
            sonar=np.array(sonar),
            time_s=np.array(time_s),
            **_columns(believed),
            range_m=detected("range_m"),
            truth=truth,
            provenance=provenance,
        )
        if self._packets is not None:
            log = in_packets(log, self._sent, self._packets.delay_s)
        return log


def _columns(poses: tuple[Pose, ...]) -> dict[str, Any]:
    names = ("x_m", "y_m", "heading_rad")
    return {name: np.array([getattr(pose, name) for pose in poses]) for name in names}
