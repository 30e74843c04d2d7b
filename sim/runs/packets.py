"""Status packets: a robot that logs all its sonars at once while they fire one after another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sonarmap import InputError, SonarLog
from sonarmap.errors import non_negative, positive
from worlds import Pose

__all__ = ["StatusPackets", "in_packets"]


@dataclass(frozen=True)
class StatusPackets:
    """The packets in which a robot reports the latest value of each sonar.

    Parameters
    ----------
    period_s : float
        Time from one packet to the next, seconds, > 0. 100 ms: AMRISim's EmulatePioneer.
    delay_s : float
        A reading is in the packets this long after its firing, seconds, >= 0. Assumed: one
        slot of the sonar board, when its listening is over.
    """

    period_s: float = 0.100
    delay_s: float = 0.040

    def __post_init__(self) -> None:
        positive("period_s", self.period_s)
        non_negative("delay_s", self.delay_s)


def in_packets(log: SonarLog, packets: Sequence[tuple[float, Pose]], delay_s: float) -> SonarLog:
    """Return a log of firings as it looks through packets.

    Parameters
    ----------
    log : SonarLog
        One row a firing.
    packets : sequence of (time, pose)
        Time of each packet in seconds and the pose by odometry then.
    delay_s : float
        A reading is known this long after its firing.

    Returns
    -------
    SonarLog
        A scan a packet, a row for each sonar that was read before, in the order of the ring.
        Time and odometry are the packet's, which is all that a robot logs; ``stale`` marks what
        an earlier packet had already; the truth stays that of the firing.

    Raises
    ------
    InputError
        If no reading is known at any packet.
    """
    known_s = log.time_s + delay_s
    times = np.array([time_s for time_s, _ in packets])
    newest = np.full((times.size, len(log.ring)), -1)
    for sonar in range(len(log.ring)):
        rows = np.flatnonzero(log.sonar == sonar)
        # A microsecond forgives the rounding of sums of times.
        last = np.searchsorted(known_s[rows], times + 1e-6, side="right") - 1
        newest[last >= 0, sonar] = rows[last[last >= 0]]
    stale = np.zeros(newest.shape, bool)
    stale[1:] = newest[1:] == newest[:-1]
    is_known = newest >= 0
    if not is_known.any():
        raise InputError("scans must be enough for a packet with a reading: take more")
    packet, row = np.nonzero(is_known)[0], newest[is_known]
    x_m, y_m, heading_rad = (
        np.array([getattr(pose, name) for _, pose in packets])[packet]
        for name in ("x_m", "y_m", "heading_rad")
    )
    # All at once: between two of the columns a log would break its own rules.
    return log.replace(
        **{name: getattr(log, name)[row] for name in log.DTYPES}
        | {
            "scan": packet,
            "time_s": times[packet],
            "x_m": x_m,
            "y_m": y_m,
            "heading_rad": heading_rad,
            "stale": stale[is_known],
        },
        truth=None if log.truth is None else log.truth.select(row),
    )
