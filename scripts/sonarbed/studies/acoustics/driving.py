"""Short drives in the shipped rooms with any sonar, for the parts that count causes."""

from __future__ import annotations

from dataclasses import dataclass

import sim
import worlds
from sim.robot.drivers import Driver
from sim.runs.packets import StatusPackets
from sim.sonar.protocol import Sonar
from sonarbed.reporting.drives import usual_driver
from sonarmap import Cause, SonarLog

__all__ = ["Drive", "cause_name", "drive"]


@dataclass(frozen=True)
class Drive:
    """A drive, by default along the room's usual way.

    Parameters
    ----------
    room : str
        A shipped room, or the path of a room's file.
    sonar : Sonar
        The sonars.
    seconds : float
        How long; whole scans of the sonar.
    seed : int
        Of all that is random.
    packets : StatusPackets, optional
        Log what packets tell, see `sim.simulate`.
    driver : Driver, optional
        Who drives; by default the room's usual driver.
    """

    room: str
    sonar: Sonar
    seconds: float
    seed: int = 0
    packets: StatusPackets | None = None
    driver: Driver | None = None


def drive(task: Drive) -> SonarLog:
    """Return the log of a drive."""
    return sim.simulate(
        worlds.load(task.room),
        scans=max(round(task.seconds / task.sonar.firing.period_s), 1),
        seed=task.seed,
        driver=usual_driver(task.room) if task.driver is None else task.driver,
        sonar=task.sonar,
        packets=task.packets,
    )


def cause_name(cause: Cause) -> str:
    """Return a cause's name for people."""
    return cause.name.lower().replace("_", " ")
