"""`sonarbed refine`: the poses of a log, moved so that its echoes agree on walls."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from sonarbed.commands.filtering import check_output
from sonarbed.options import Json

__all__ = ["refine"]


def refine(
    log: Annotated[Path, typer.Argument(help="The log (Parquet).")],
    out: Annotated[Path, typer.Option(help="The log with refined poses to write (Parquet).")],
    knot_m: Annotated[
        float,
        typer.Option(metavar="METRES", help="Way between two knots of the drift of the heading."),
    ] = 1.0,
    as_json: Json = False,
) -> None:
    """Refine the poses of odometry: move them so that the echoes agree on walls.

    It mends a drift of centimetres and degrees. It is no SLAM: places are not recognised.

    Example, after `sonarbed simulate office --out drive.parquet`:

      sonarbed refine drive.parquet --out refined.parquet
    """
    import sonarmap as sm
    from sonarbed.console import print_json, print_table, say, working

    check_output(log, out)
    before = sm.read_log(log)
    with working("refining"):
        after = sm.refine_poses(before, knot_m=knot_m)
        after.write(out)
    moved = sm.pose_error(after, before)
    facts = {
        "readings": len(before),
        "moved_m": moved.place_m,
        "turned_deg": math.degrees(moved.heading_rad),
    }
    errors = None
    if before.truth is not None:
        errors = [
            {"place_m": error.place_m, "heading_deg": math.degrees(error.heading_rad)}
            for error in (sm.pose_error(each, each.at_true_poses()) for each in (before, after))
        ]
    if as_json:
        told = None if errors is None else dict(zip(("before", "after"), errors, strict=True))
        print_json({"file": str(out), **facts, "pose_errors": told})
        return
    print_table(
        f"Poses: {log}",
        ["moved", "root mean square"],
        [
            ["place", f"{100 * facts['moved_m']:.1f} cm"],
            ["heading", f"{facts['turned_deg']:.2f} degrees"],
        ],
    )
    if errors is not None:
        old, new = errors
        print_table(
            "Errors of the poses by truth, root mean square",
            ["error", "by odometry", "refined"],
            [
                ["place, cm", f"{100 * old['place_m']:.1f}", f"{100 * new['place_m']:.1f}"],
                ["heading, degrees", f"{old['heading_deg']:.2f}", f"{new['heading_deg']:.2f}"],
            ],
        )
    say(f"Written: {out}")
