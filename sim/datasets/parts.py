"""From the settings of a log to the parts of the simulator that take it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from sim.datasets.values import Kind
from sim.robot import drivers
from sim.robot.drivers import Driver
from sim.robot.odometry import OdometryModel
from sim.runs.packets import StatusPackets
from sim.sonar import presets
from sim.sonar.air import Air
from sim.sonar.carried import with_ring
from sim.sonar.physical.piston import Piston
from sim.sonar.physical.receiver import Receiver
from sim.sonar.physical.spread import TransducerSpread
from sim.sonar.protocol import Sonar
from sonarmap import InputError, SonarRing
from worlds import World

__all__ = [
    "FIXED_PARTS",
    "SONAR_FIELDS",
    "make_driver",
    "make_sonar",
    "odometry_of",
    "packets_of",
    "settable",
]

FIXED_PARTS: Mapping[str, type] = {
    "receiver": Receiver,
    "transducer": Piston,
    "spread": TransducerSpread,
    "air": Air,
    "odometry": OdometryModel,
    "status_packets": StatusPackets,
}
"""Tables of [logs] that are parameters of one class, whatever is driven and fired."""

SONAR_FIELDS: Mapping[str, str] = {
    "receiver": "receiver",
    "transducer": "piston",
    "spread": "spread",
}
"""Those of them that are fields of a physical sonar, and which."""

Settings = Mapping[str, Any]
"""Values by key; of a table as ``table.key``."""


def settable(part: object) -> dict[str, Kind]:
    """Return the parameters of a dataclass, or of one of it, that a plain value can stand for."""
    kind = part if isinstance(part, type) else type(part)
    if not dataclasses.is_dataclass(kind):
        return {}
    hints = get_type_hints(kind)
    found = {}
    for each in dataclasses.fields(kind):
        hint = hints[each.name]
        types = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
        for plain, name in ((bool, "flag"), (float, "number"), (int, "whole"), (str, "text")):
            if plain in types and each.init and each.name != "name":
                found[each.name] = Kind(name)
                break
    return found


def make_sonar(settings: Settings, ring: SonarRing | None) -> Sonar:
    """Return the sonar of a log: a preset with its ring, its parameters and its air."""
    sonar: Any = presets.preset(settings["sonar"])
    sonar = with_ring(sonar, ring)
    changes: dict[str, Any] = _table(settings, "sonar_parameters", only=settable(sonar))
    for table, field in SONAR_FIELDS.items():
        values = _table(settings, table)
        if values and hasattr(sonar, field):
            changes[field] = dataclasses.replace(getattr(sonar, field), **values)
    if changes:
        sonar = dataclasses.replace(sonar, **changes)
    air = _table(settings, "air")
    if air:
        sonar = sonar.randomised(1.0, Air(**air))
    return sonar  # type: ignore[no-any-return]


def make_driver(settings: Settings, world: World) -> Driver:
    """Return the driver of a log with its parameters."""
    made: Any = drivers.driver(settings["driver"], world)
    changes = _table(settings, "driver_parameters", only=settable(made))
    return dataclasses.replace(made, **changes) if changes else made  # type: ignore[no-any-return]


def odometry_of(settings: Settings) -> OdometryModel:
    """Return the errors of the odometry of a log."""
    return OdometryModel(**_table(settings, "odometry"))


def packets_of(settings: Settings) -> StatusPackets | None:
    """Return the status packets of a log, None for firings."""
    return StatusPackets(**_table(settings, "status_packets")) if settings["packets"] else None


def check_frozen(kind: str, part: object) -> None:
    """Raise `InputError` if a part has parameters to set but is no dataclass."""
    if not dataclasses.is_dataclass(part):
        raise InputError(f"{kind} is no dataclass: it has no parameters to set")


def _table(
    settings: Settings, table: str, only: Mapping[str, Kind] | None = None
) -> dict[str, Any]:
    """Return the values of a table by the parameters' names."""
    prefix = f"{table}."
    values = {
        key.removeprefix(prefix): value for key, value in settings.items() if key.startswith(prefix)
    }
    return values if only is None else {k: v for k, v in values.items() if k in only}
