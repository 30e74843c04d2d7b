"""`simulate`: a robot drives in a known room and writes a log with the truth beside it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from sim.robot.drivers import Driver
from sim.robot.odometry import OdometryModel
from sim.runs.arguments import DriveArguments
from sim.runs.compiled.drive import compiled_log, runs_compiled
from sim.runs.packets import StatusPackets
from sim.runs.plain import plain_log
from sim.sonar.protocol import Sonar
from sonarmap import SonarLog, SonarRing
from worlds import World

__all__ = ["simulate"]


def simulate(
    world: World,
    *,
    scans: int,
    seed: int,
    driver: str | Driver = "auto",
    sonar: str | Sonar = "physical",
    ring: str | Path | SonarRing | None = None,
    engine: str = "bullet",
    odometry: OdometryModel | None = None,
    packets: StatusPackets | None = None,
    gui: bool = False,
    on_scan: Callable[[int], None] | None = None,
) -> SonarLog:
    """Drive a robot through a world and return the log of its sonars.

    Parameters
    ----------
    world : World
        The room, see `worlds.load`.
    scans : int
        How many scans to take, 1 to `MOST_SCANS`. The first is taken at the start, at rest.
    seed : int
        Seed of all that is random, >= 0. The same world, arguments and seed give the same log,
        bit for bit, on one machine.
    driver : str or Driver
        Who drives: a name that `sim.robot.drivers.driver` knows, or a driver. "auto" follows
        the world's route, if it has one, and wanders otherwise.
    sonar : str or Sonar
        The sonars: a name that `sim.sonar.presets.preset` knows, or a sonar. By default those
        that behave like sonars; "thesis" is the simple cone, quicker and easier to reason about.
    ring : str, Path or SonarRing, optional
        Another ring for the sonars: a name or a TOML file, see `sonarmap.ring`, or a ring. Places,
        cones and ranges are its; the acoustics stay.
    engine : str
        What moves the robot and casts the rays: "bullet", PyBullet with its dynamics;
        "segments", exact faces and plain kinematics, many times faster; or another that
        `sim.engines.opening.open_engine` knows.
    odometry : OdometryModel, optional
        Errors of the odometry, by default the AmigoBot's.
    packets : StatusPackets, optional
        Log what the robot's status packets report, stale values repeated; by default each reading
        once, with the time and the pose of its own firing.
    gui : bool
        Show the engine's window.
    on_scan : callable, optional
        Called with the number of each scan taken, for a progress bar; of a compiled drive after
        some hundred scans for each of them. What it raises ends the drive.

    Returns
    -------
    SonarLog
        With truth; its provenance records how it was made.

    Raises
    ------
    InputError
        If a name is unknown, an argument is of a wrong type or breaks its rule, or the robot does
        not fit at the start.

    Notes
    -----
    On "segments" a drive runs compiled where it can, many times faster: see
    `sim.runs.compiled.drive.runs_compiled`. The log is the same.
    """
    asked = DriveArguments.of(
        world,
        scans=scans,
        seed=seed,
        driver=driver,
        sonar=sonar,
        ring=ring,
        engine=engine,
        odometry=odometry,
        packets=packets,
        gui=gui,
    )
    if runs_compiled(asked):
        return compiled_log(asked, on_scan=on_scan)
    return plain_log(asked, on_scan=on_scan)
