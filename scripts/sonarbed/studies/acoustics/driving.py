"""Drives of so many seconds with any sonar, for the parts that count readings."""

from __future__ import annotations

from sim import Driver, Sonar, StatusPackets
from sonarbed.reporting.drives import DriveSpec, usual_driver

__all__ = ["timed_drive"]


def timed_drive(
    room: str,
    sonar: Sonar,
    seconds: float,
    *,
    seed: int = 0,
    driver: Driver | None = None,
    packets: StatusPackets | None = None,
) -> DriveSpec:
    """Return a drive of so many seconds, rounded to whole scans of the sonar.

    The other parameters are those of `DriveSpec`; by default the room's usual driver drives.
    """
    return DriveSpec(
        room,
        scans=max(round(seconds / sonar.firing.period_s), 1),
        seed=seed,
        driver=usual_driver(room) if driver is None else driver,
        sonar=sonar,
        packets=packets,
    )
