"""Options that several commands share, and what they turn into."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

from sonarmap.errors import InputError

if TYPE_CHECKING:
    from sonarmap import SensorModel
    from worlds import World

__all__ = ["Json", "ModelName", "Setting", "load_world", "make_model"]

Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs instead of a table.")]
Setting = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=NUMBER", help="A parameter of the room; repeatable."),
]


class ModelName(StrEnum):
    """Sensor models by name."""

    PARAMETERIZED = "parameterized"
    STANDARD = "standard"


def make_model(
    name: ModelName,
    *,
    beta_deg: float,
    tolerance_m: float,
    max_occupied: float,
    p1: float | None,
    p2: float,
    max_range_m: float,
) -> SensorModel:
    """Return the sensor model that the options of a command describe."""
    from sonarmap import ParameterizedModel, StandardModel

    beta_rad = math.radians(beta_deg)
    if name is ModelName.STANDARD:
        return StandardModel(beta_rad, max_range_m, max_occupied, tolerance_m)
    # P1 = 1 - P4 is the thesis's own rule.
    p1 = round(1 - max_occupied, 12) if p1 is None else p1
    return ParameterizedModel(p1=p1, p2=p2, p3_m=tolerance_m, p4=max_occupied, p5_rad=beta_rad)


def load_world(name: str, settings: list[str] | None) -> World:
    """Return the world of a name or file with parameters given as NAME=NUMBER."""
    import worlds

    parameters = {}
    for setting in settings or []:
        key, _, number = setting.partition("=")
        try:
            parameters[key] = float(number)
        except ValueError:
            raise InputError(f"--set must be NAME=NUMBER, got {setting!r}") from None
    return worlds.load(name, **parameters)
