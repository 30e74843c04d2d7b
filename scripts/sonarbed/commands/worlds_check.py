"""`sonarbed worlds check`: what is wrong or doubtful in world files."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from sonarbed.options import Json

__all__ = ["check"]


def check(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="World files, or names of rooms.")
    ],
    robot_radius: Annotated[
        float, typer.Option(metavar="METRES", help="Radius of the robot that shall drive there.")
    ] = 0.18,
    resolution: Annotated[
        float, typer.Option(metavar="METRES", help="Cells of the maps that shall be made of it.")
    ] = 0.05,
    as_json: Json = False,
) -> None:
    """Say what is wrong in a room (exit code 2), and what is doubtful.

    Doubtful are a start or a route that touches something, places that
    the robot cannot come to, materials and heights that make no sense,
    walls thinner than a cell, solids in one another, bounds too large.

    Example:

      sonarbed worlds check office corridor

      sonarbed worlds check office --robot-radius 0.3 --json
    """
    import worlds
    from sonarbed.console import print_json, say
    from sonarmap.errors import InputError, positive

    radius_m = positive("--robot-radius", robot_radius)
    cell_m = positive("--resolution", resolution)
    found: list[dict[str, object]] = []
    errors: list[str] = []
    for file in files:
        try:
            world = worlds.load(file)
            doubts = worlds.doubts(world, robot_radius_m=radius_m, resolution_m=cell_m)
        except InputError as error:
            errors.append(str(error))
            found.append({"file": file, "error": str(error), "doubts": []})
            continue
        found.append({"file": file, "error": None, "doubts": [asdict(each) for each in doubts]})
        if not as_json:
            for doubt in doubts:
                say(f"{file}: doubtful: {doubt}")
            if not doubts:
                say(f"{file}: nothing to say against it")
    if as_json:
        print_json(found)
    if errors:
        more = f" (and {len(errors) - 1} more with errors)" if errors[1:] else ""
        # One line is left for the end, so the others stand among the results.
        for other in errors[1:] if not as_json else ():
            say(f"wrong: {other}")
        raise InputError(f"{errors[0]}{more}")
