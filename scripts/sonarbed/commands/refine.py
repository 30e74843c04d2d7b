"""`sonarbed refine`: the poses of a log, moved so that its echoes agree on walls."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sonarbed.commands.filtering import check_output
from sonarbed.options import Json

if TYPE_CHECKING:
    from sonarmap import SonarLog

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
    facts = _moved(before, after)
    errors = None if before.truth is None else [_errors(each) for each in (before, after)]
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


def _moved(before: SonarLog, after: SonarLog) -> dict[str, float]:
    place_m, heading_deg = _differences(before, after)
    return {"readings": len(before), "moved_m": place_m, "turned_deg": heading_deg}


def _errors(log: SonarLog) -> dict[str, float]:
    place_m, heading_deg = _differences(log, log.at_true_poses())
    return {"place_m": place_m, "heading_deg": heading_deg}


def _differences(log: SonarLog, other: SonarLog) -> tuple[float, float]:
    """Return root mean squares of the distances of places, metres, and of headings, degrees."""
    import numpy as np

    if not len(log):
        return 0.0, 0.0
    away_m = np.hypot(log.x_m - other.x_m, log.y_m - other.y_m)
    turned_rad = (log.heading_rad - other.heading_rad + np.pi) % (2 * np.pi) - np.pi
    return (
        float(np.sqrt(np.mean(away_m**2))),
        float(np.rad2deg(np.sqrt(np.mean(turned_rad**2)))),
    )
