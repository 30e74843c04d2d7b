"""Options that several commands share, and what they turn into."""

from __future__ import annotations

import math
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sonarmap import SensorModel, SonarRing
    from worlds import World

__all__ = [
    "Json",
    "ModelName",
    "Png",
    "Setting",
    "check_writable",
    "load_world",
    "make_model",
]

Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs instead of a table.")]
Setting = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=NUMBER", help="A parameter of the room; repeatable."),
]
Png = Annotated[Path | None, typer.Option("--png", help="Draw a picture into this .png file.")]


# The thesis's gap at the border, figure 5.8 b; here so that help can name it.
P2 = 0.15


class ModelName(StrEnum):
    """Sensor models by name."""

    PARAMETERIZED = "parameterized"
    STANDARD = "standard"


def make_model(
    name: ModelName,
    ring: SonarRing,
    *,
    beta_deg: float | None,
    tolerance_m: float,
    max_occupied: float,
    p1: float | None,
    p2: float | None,
    max_range_m: float,
) -> SensorModel:
    """Return the sensor model that the options of a command describe, for a robot's sonars."""
    from sonarmap import InputError, ParameterizedModel, StandardModel
    from sonarmap.errors import positive

    # Told in the words of the options; the models know the same numbers by other names.
    if beta_deg is not None and not 0 < beta_deg <= 60:
        raise InputError(f"--beta-deg must be > 0 and <= 60, got {beta_deg:g}")
    if not 0.5 < max_occupied <= 1:
        raise InputError(f"--max-occupied must be > 0.5 and <= 1, got {max_occupied:g}")
    positive("--tolerance", tolerance_m)
    beta_rad = ring.half_angle_rad if beta_deg is None else math.radians(beta_deg)
    if name is ModelName.STANDARD:
        if p1 is not None or p2 is not None:
            raise InputError("--p1 and --p2 belong to --model parameterized, got standard")
        return StandardModel(beta_rad, max_range_m, max_occupied, tolerance_m)
    # P1 = 1 - P4 is the thesis's own rule; rounded, or 1 - 0.98 is not its 0.02.
    p1 = round(1 - max_occupied, 12) if p1 is None else p1
    p2 = P2 if p2 is None else p2
    return ParameterizedModel(p1=p1, p2=p2, p3_m=tolerance_m, p4=max_occupied, p5_rad=beta_rad)


def load_world(name: str, settings: list[str] | None) -> World:
    """Return the world of a name or file with parameters given as NAME=NUMBER."""
    import worlds
    from sonarmap import InputError

    parameters = {}
    for setting in settings or []:
        key, _, number = setting.partition("=")
        try:
            parameters[key] = float(number)
        except ValueError:
            raise InputError(f"--set must be NAME=NUMBER, got {setting!r}") from None
    return worlds.load(name, **parameters)


def check_writable(path: Path | None, suffix: str = "") -> None:
    """Raise `InputError` if no file could be written to `path`: before the work, not after it.

    Parameters
    ----------
    path : Path or None
        The file to be written; None is fine.
    suffix : str
        What its name must end with.
    """
    from sonarmap import InputError
    from sonarmap.files import atomic_path

    if path is None:
        return
    if not path.name.endswith(suffix):
        raise InputError(f"{path}: the file's name must end with {suffix}")

    class _Tried(Exception):  # noqa: N818 - no error: it makes `atomic_path` leave all as it was
        pass

    with suppress(_Tried), atomic_path(path):
        raise _Tried
