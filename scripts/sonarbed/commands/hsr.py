"""`sonarbed hsr`: specular readings repaired."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sonarbed.commands.filtering import check_output, damage, judged_rows, unused_rows
from sonarbed.options import Json, Png, check_writable

if TYPE_CHECKING:
    from sonarmap import HsrResult, SonarLog

__all__ = ["hsr"]


def hsr(
    log: Annotated[Path, typer.Argument(help="The log (Parquet).")],
    out: Annotated[Path, typer.Option(help="The updated log to write (Parquet).")],
    min_wall: Annotated[
        float, typer.Option(help="Estimated wall of the nearest reading, metres.")
    ] = 0.01,
    max_wall: Annotated[
        float, typer.Option(help="Estimated wall of the farthest reading, metres.")
    ] = 0.08,
    threshold: Annotated[
        float | None,
        typer.Option(help="Readings up to it vouch for a wall, metres; default 0.8."),
    ] = None,
    target_distance: Annotated[
        float, typer.Option(help="A mark this near to a data point changes nothing, metres.")
    ] = 0.06,
    cell: Annotated[float, typer.Option(help="Side of a cell of the grid ES, metres.")] = 0.01,
    max_passes: Annotated[int, typer.Option(help="Number of passes at most.")] = 20,
    png: Png = None,
    as_json: Json = False,
) -> None:
    """Repair the specular readings of a log with HSR, the thesis's chapter 6.

    A short reading vouches for a piece of wall; a longer one that would have to pass through it is
    cut to it. The log stays as it is. The defaults are the thesis's for rooms with openings; those
    of its closed room, --min-wall 0.02 --max-wall 0.15 --threshold 3, close doors elsewhere.

    Example, after `sonarbed simulate thesis-exp1 --out drive.parquet`:

      sonarbed hsr drive.parquet --out hsr.parquet --png hsr.png
    """
    import sonarmap as sm
    from sonarbed.console import print_json, print_table, say, working
    from sonarmap.filters.hsr import Hsr

    check_output(log, out)
    check_writable(png, ".png")
    before = sm.read_log(log)
    params = Hsr(min_wall, max_wall, threshold, target_distance, cell, max_passes).params(
        before.ring
    )
    with working("HSR"):
        result = sm.hsr(before, params)
        score = None if before.truth is None else sm.score_readings(before, result.log)
        result.log.write(out)
        if png is not None:
            from sonarbed.reporting.hsr_picture import draw_hsr

            draw_hsr(before, result, params, png)
    facts = _facts(before, result)
    if as_json:
        about = {"file": str(out), **facts, "score": None if score is None else score.to_dict()}
        print_json(about)
        return
    print_table(f"HSR: {log}", ["what changed", "value"], _changes(facts))
    if score is not None:
        print_table("Readings by truth", ["readings", "wrong", "right"], judged_rows(score))
        say(damage(score))
    say(f"Written: {out}")
    if png is not None:
        say(f"Drawn: {png}")


def _facts(before: SonarLog, result: HsrResult) -> dict[str, Any]:
    import numpy as np

    from sonarmap.account import account_of

    had_echo = result.updated & np.isfinite(before.range_m)
    shortened_m = before.range_m[had_echo] - result.log.range_m[had_echo]
    return {
        "parameters": result.log.provenance["hsr"][-1],
        # Stale and rejected readings are not HSR's business; its picture shows the same ones.
        "readings": int(before.usable.sum()),
        "account": account_of(before).to_dict(),
        "updated": int(result.updated.sum()),
        "updated_without_echo": int((result.updated & ~had_echo).sum()),
        "updates_per_pass": list(result.updates_per_pass),
        "rejected_updates": result.rejected_updates,
        "stopped": str(result.stopped),
        "median_shortening_m": float(np.median(shortened_m)) if shortened_m.size else None,
    }


def _changes(facts: dict[str, Any]) -> list[list[str]]:
    passes = facts["updates_per_pass"]
    shortening_m = facts["median_shortening_m"]
    updated, readings = facts["updated"], facts["readings"]
    rows = [
        *unused_rows(facts["account"]),
        ["readings", str(readings)],
        ["updated", f"{updated} ({updated / readings:.1%})" if readings else str(updated)],
        ["  of these without echo before", str(facts["updated_without_echo"])],
        ["median shortening, of echoes", "-" if shortening_m is None else f"{shortening_m:.3f} m"],
        *([f"updated in pass {n}", str(count)] for n, count in enumerate(passes, 1)),
    ]
    if facts["rejected_updates"] is not None:
        rows.append(
            [f"not kept: pass {len(passes) + 1} would update", str(facts["rejected_updates"])]
        )
    return [*rows, ["stopped", facts["stopped"]]]
