"""`sonarbed map`: from a log to a map."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sonarbed.options import P2, Json, ModelName, Png, check_writable, make_model

__all__ = ["map_"]


def map_(
    log: Annotated[Path, typer.Argument(help="The log (Parquet).")],
    out: Annotated[Path, typer.Option(help="The folder for map.yaml, map.pgm and map.npz.")],
    model: Annotated[ModelName, typer.Option(help="The sensor model.")] = ModelName.PARAMETERIZED,
    resolution: Annotated[float, typer.Option(help="Side of a cell, metres.")] = 0.05,
    beta_deg: Annotated[
        float | None,
        typer.Option(help="Half-angle of the cone (P5), degrees; default the ring's."),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(help="Half of the thickness of region 1 (P3), metres.")
    ] = 0.1,
    max_occupied: Annotated[float, typer.Option(help="Highest P(occupied) (P4).")] = 0.98,
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
        str,
        typer.Option(
            metavar="ignore|clear", help="What no echo means: nothing, or that the cone is free."
        ),
    ] = "ignore",
    poses: Annotated[
        str,
        typer.Option(metavar="odometry|true", help="Whose poses; true needs a simulated log."),
    ] = "odometry",
    png: Png = None,
    as_json: Json = False,
) -> None:
    """Build the occupancy map of a log: a ROS map_server pair and an exact npz.

    Example, after `sonarbed simulate thesis-exp1 --out drive.parquet`:

      sonarbed map drive.parquet --out map --png map.png
    """
    import sonarmap as sm
    from sonarbed.console import print_json, say, working

    check_writable(png, ".png")
    readings = sm.read_log(log)
    limit_m = readings.ring.range_max_m if max_range is None else max_range
    sensor_model = make_model(
        model,
        readings.ring,
        beta_deg=beta_deg,
        tolerance_m=tolerance,
        max_occupied=max_occupied,
        p1=p1,
        p2=p2,
        max_range_m=limit_m,
    )
    grid = sm.grid_over(readings, resolution_m=resolution, max_range_m=limit_m)
    with working("mapping"):
        built = sm.build_map(
            readings, sensor_model, grid, max_range_m=limit_m, no_echo=no_echo, poses=poses
        )
        built.save(out)
        if png is not None:
            from sonarbed.reporting.pictures import draw_map

            draw_map(built, readings, png)
    if as_json:
        print_json(
            {
                "folder": str(out),
                "rows": grid.rows,
                "cols": grid.cols,
                "resolution_m": grid.resolution_m,
                "model": repr(sensor_model),
            }
        )
        return
    say(f"{len(readings)} readings, {type(sensor_model).__name__}, {grid.rows} x {grid.cols} cells")
    say(f"Map: {out}/map.yaml, map.pgm (ROS map_server), map.npz")
    if png is not None:
        say(f"Drawn: {png}")
