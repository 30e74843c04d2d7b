"""`DriveArguments`: what is asked of a drive, checked and with every name looked up."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.engines.opening import ENGINES
from sim.robot import drivers
from sim.robot.clock import check_steps
from sim.robot.drivers import Driver
from sim.robot.odometry import OdometryModel
from sim.runs.packets import StatusPackets
from sim.sonar import presets as sonars
from sim.sonar.carried import with_ring
from sim.sonar.firing import Firing, check_firing, fitted
from sim.sonar.protocol import Sonar
from sonarmap import InputError, SonarRing
from sonarmap.errors import flag, instance, whole
from worlds import World

__all__ = ["MOST_SCANS", "DriveArguments"]

MOST_SCANS = 10_000_000
"""Longest drive in scans: the log of a longer one, 80 million readings, would fill the memory."""


@dataclass(frozen=True)
class DriveArguments:
    """What `sim.simulate` is asked for, checked and with every name looked up; see there."""

    world: World
    scans: int
    seed: int
    driver: Driver
    sonar: Sonar
    firing: Firing
    engine: str
    odometry: OdometryModel
    packets: StatusPackets | None
    gui: bool

    @classmethod
    def of(
        cls,
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
    ) -> DriveArguments:
        """Return the arguments, or raise `InputError` with the first that breaks its rule."""
        instance("world", world, World, "worlds.load(name) returns one")
        scans, seed = whole("scans", scans, least=1), whole("seed", seed, least=0)
        if scans > MOST_SCANS:
            raise InputError(
                f"scans must be <= {MOST_SCANS}, for the log of more would not fit into the "
                f"memory, got {scans}"
            )
        sonar_used = with_ring(sonars.of(sonar), ring)
        firing = fitted(sonar_used.firing, len(sonar_used.ring))
        check_firing(firing, len(sonar_used.ring))
        if packets is not None:
            instance("packets", packets, StatusPackets, "StatusPackets() are a Pioneer's")
            check_steps("packets.period_s", packets.period_s)
        ENGINES.find(engine)
        return cls(
            world,
            scans,
            seed,
            drivers.of(driver, world),
            sonar_used,
            firing,
            engine,
            OdometryModel() if odometry is None else instance("odometry", odometry, OdometryModel),
            packets,
            flag("gui", gui),
        )

    @property
    def provenance(self) -> dict[str, Any]:
        """What a log records of how it was made."""
        return {
            "world": self.world.name,
            "world_parameters": dict(self.world.parameters),
            "seed": self.seed,
            "scans": self.scans,
            "driver": _described(self.driver),
            "sonar": _described(self.sonar),
            "engine": self.engine,
            "odometry": _described(self.odometry),
            **({} if self.packets is None else {"packets": _described(self.packets)}),
        }


def _described(part: object) -> dict[str, Any]:
    """Return a configuration as JSON-able values, for the provenance."""
    described: dict[str, Any] = {"kind": type(part).__name__}
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            # The log carries its ring itself.
            if field.name != "ring":
                is_part = dataclasses.is_dataclass(value)
                described[field.name] = _described(value) if is_part else value
    return described
