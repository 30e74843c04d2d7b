"""`sonarbed rings`: the sonars of robots."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sonarbed.options import Json, Png

if TYPE_CHECKING:
    from sonarmap import SonarRing

__all__ = ["rings"]


def rings(
    name: Annotated[
        str | None,
        typer.Argument(help="A ring or a TOML file of one; module:Name of your own."),
    ] = None,
    png: Png = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE.toml", help="Write it as a file to start from.")
    ] = None,
    as_json: Json = False,
) -> None:
    """List the rings of sonars, or show one and where it looks.

    Example:

      sonarbed rings hc-sr04-3 --png ring.png --out ring.toml
    """
    import sonarmap as sm
    from sonarbed.console import print_json, print_table
    from sonarbed.options import check_writable

    if name is None:
        if png is not None or out is not None:
            raise sm.InputError("--png and --out need the name of a ring")
        known = {each: sm.ring(each) for each in sm.rings()}
        if as_json:
            print_json([ring.to_dict() for ring in known.values()])
            return
        print_table(
            "Rings",
            ["name", "sonars", "cone", "range"],
            [[each, str(len(ring)), _cone(ring), _range(ring)] for each, ring in known.items()],
        )
        return
    check_writable(png, ".png")
    check_writable(out, ".toml")
    _show(sm.ring(name), png, out, as_json)


def _show(ring: SonarRing, png: Path | None, out: Path | None, as_json: bool) -> None:
    import numpy as np

    from sonarbed.console import print_json, print_table, say

    if png is not None:
        from sonarbed.reporting.pictures import draw_ring

        draw_ring(ring, png)
    if out is not None:
        ring.write(out, source=f"sonarbed rings {ring.name}")
    if as_json:
        print_json(ring.to_dict())
        return
    places = zip(ring.x_m, ring.y_m, np.degrees(ring.heading_rad), strict=True)
    print_table(
        f"{ring.name}: {len(ring)} sonars, cone {_cone(ring)}, {_range(ring)}",
        ["sonar", "ahead", "left", "looks at"],
        [
            [str(i), f"{x:.3f} m", f"{y:.3f} m", f"{deg:.4g}°"]
            for i, (x, y, deg) in enumerate(places)
        ],
    )
    for what, path in (("Drawn", png), ("Written", out)):
        if path is not None:
            say(f"{what}: {path}")


def _cone(ring: SonarRing) -> str:
    import math

    return f"{2 * math.degrees(ring.half_angle_rad):.4g}°"


def _range(ring: SonarRing) -> str:
    return f"{ring.range_min_m:g} to {ring.range_max_m:g} m"
