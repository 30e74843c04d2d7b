"""`sonarbed map`: from a log to a map."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from sonarbed.choices import listed
from sonarbed.options import Json, Param, Png, check_writable, make_part
from sonarmap.catalogue import FILTERS, METHODS

if TYPE_CHECKING:
    from sonarmap import MappingMethod
    from sonarmap.mapping import Poses

__all__ = ["map_"]

# The thesis's gap at the border, figure 5.8 b; here so that help can name it.
P2 = 0.15
_OWN = "or package.module:Name."


class ModelName(StrEnum):
    """Sensor models by name."""

    PARAMETERIZED = "parameterized"
    STANDARD = "standard"


def map_(
    log: Annotated[Path, typer.Argument(help="The log (Parquet).")],
    out: Annotated[Path, typer.Option(help="The folder for map.yaml, map.pgm and map.npz.")],
    method: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help=f"The mapping method: {listed(METHODS)}, {_OWN} [default: bayes-parameterized]",
        ),
    ] = None,
    param: Param = None,
    filter_: Annotated[
        list[str] | None,
        typer.Option(
            "--filter",
            metavar="NAME",
            help=f"A reading filter before it, repeatable: {listed(FILTERS)}, {_OWN}",
        ),
    ] = None,
    model: Annotated[
        ModelName | None,
        typer.Option(help="Short for --method bayes-...: the sensor model."),
    ] = None,
    resolution: Annotated[float, typer.Option(help="Side of a cell, metres.")] = 0.05,
    beta_deg: Annotated[
        float | None,
        typer.Option(help="Half-angle of the cone (P5), degrees; default the ring's."),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(help="Half of the thickness of region 1 (P3), metres; default 0.1."),
    ] = None,
    max_occupied: Annotated[
        float | None, typer.Option(help="Highest P(occupied) (P4); default 0.98.")
    ] = None,
    p1: Annotated[
        float | None,
        typer.Option(help="Lowest P(occupied), for parameterized; default 1 - P4."),
    ] = None,
    p2: Annotated[
        float | None,
        typer.Option(help=f"Gap to 0.5 at the border, for parameterized; default {P2}."),
    ] = None,
    max_range: Annotated[
        float | None, typer.Option(help="Longer readings are no echo, metres; default the ring's.")
    ] = None,
    no_echo: Annotated[
        str | None,
        typer.Option(
            metavar="ignore|clear",
            help="What no echo means: nothing (the default), or that the cone is free.",
        ),
    ] = None,
    poses: Annotated[
        str,
        typer.Option(metavar="odometry|true", help="Whose poses; true needs a simulated log."),
    ] = "odometry",
    png: Png = None,
    as_json: Json = False,
) -> None:
    """Build the occupancy map of a log: a ROS map_server pair and an exact npz.

    Options from --beta-deg to --no-echo belong to the Bayes methods; others take --param.

    Example, after `sonarbed simulate thesis-exp1 --out drive.parquet`:

      sonarbed map drive.parquet --out map --png map.png
    """
    import sonarmap as sm
    from sonarbed.console import print_json, say, working
    from sonarmap.account import account_by, contacts_of
    from sonarmap.mapping import grid_for

    check_writable(png, ".png")
    readings = sm.read_log(log)
    short = {
        "beta_deg": beta_deg,
        "tolerance": tolerance,
        "max_occupied": max_occupied,
        "p1": p1,
        "p2": p2,
        "max_range": max_range,
        "no_echo": no_echo,
    }
    chosen = _method(method, model, param, short)
    pipeline = sm.Pipeline([make_part("filter", name, None) for name in filter_ or []], chosen)
    grid = grid_for(readings, chosen, resolution_m=resolution)
    with working("mapping"):
        filtered = pipeline.apply(readings)
        # Which words there are for poses, `build_map` knows.
        built = sm.build_map(filtered.log, chosen, grid, poses=cast("Poses", poses))
        built.save(out)
        if png is not None:
            from sonarbed.reporting.pictures import draw_map

            draw_map(built, filtered.log, png)
    contacts = contacts_of(readings)
    account = account_by(filtered.log, chosen)
    sensor_model = getattr(chosen, "sensor_model", None)
    if as_json:
        print_json(
            {
                "folder": str(out),
                "rows": grid.rows,
                "cols": grid.cols,
                "resolution_m": grid.resolution_m,
                "account": account.to_dict(),
                **({} if contacts is None else contacts.to_dict()),
                "method": repr(chosen),
                "filters": [repr(each) for each in pipeline.filters],
                "model": None if sensor_model is None else repr(sensor_model(readings.ring)),
            }
        )
        return
    name = pipeline.name if sensor_model is None else type(sensor_model(readings.ring)).__name__
    say(f"{len(readings)} readings, {name}, {grid.rows} x {grid.cols} cells")
    say(f"{account}")
    if contacts is not None and contacts.touched:
        say(str(contacts))
    say(f"Map: {out}/map.yaml, map.pgm (ROS map_server), map.npz")
    if png is not None:
        say(f"Drawn: {png}")


def _method(
    name: str | None, model: ModelName | None, param: list[str] | None, short: dict[str, Any]
) -> MappingMethod:
    """Return the method that the options describe."""
    from sonarmap.errors import InputError

    if name is not None and model is not None:
        raise InputError(f"--model is short for a --method, give one of them: got {name!r}, too")
    if name is None:
        name = f"bayes-{model or ModelName.PARAMETERIZED}"
    parameters = {}
    if name in ("bayes-parameterized", "bayes-standard"):
        parameters = _bayes_parameters(name, **short)
    else:
        given = [option for option, value in short.items() if value is not None]
        if given:
            option = given[0].replace("_", "-")
            raise InputError(f"--{option} belongs to the Bayes methods, got --method {name}")
    made: MappingMethod = make_part("method", name, param, **parameters)
    return made


def _bayes_parameters(
    name: str,
    *,
    beta_deg: float | None,
    tolerance: float | None,
    max_occupied: float | None,
    p1: float | None,
    p2: float | None,
    max_range: float | None,
    no_echo: str | None,
) -> dict[str, Any]:
    """Return parameters of a Bayes method, checked in the words of the options."""
    from sonarmap.errors import InputError, positive

    if beta_deg is not None and not 0 < beta_deg <= 60:
        raise InputError(f"--beta-deg must be > 0 and <= 60, got {beta_deg:g}")
    if max_occupied is not None and not 0.5 < max_occupied <= 1:
        raise InputError(f"--max-occupied must be > 0.5 and <= 1, got {max_occupied:g}")
    if tolerance is not None:
        positive("--tolerance", tolerance)
    beta_rad = None if beta_deg is None else math.radians(beta_deg)
    common = {"max_range_m": max_range, "no_echo": no_echo}
    if name == "bayes-standard":
        if p1 is not None or p2 is not None:
            raise InputError("--p1 and --p2 belong to --model parameterized, got standard")
        return {
            "beta_rad": beta_rad,
            "tolerance_m": tolerance,
            "max_occupied": max_occupied,
            **common,
        }
    return {"p1": p1, "p2": p2, "p3_m": tolerance, "p4": max_occupied, "p5_rad": beta_rad, **common}
