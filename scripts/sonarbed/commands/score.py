"""`sonarbed score`: a map judged by the truth."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sonarbed.options import Json, Setting

__all__ = ["score"]


def score(
    map_: Annotated[Path, typer.Argument(metavar="MAP", help="A map's folder or its map.npz.")],
    world: Annotated[str, typer.Option(help="The room that was mapped, or its file.")],
    log: Annotated[
        Path | None,
        typer.Option(help="The log: only cells that its sonars could have observed are scored."),
    ] = None,
    setting: Setting = None,
    as_json: Json = False,
) -> None:
    """Score a map against the truth of its room.

    Example: sonarbed score map --world thesis-exp1 --log drive.parquet --json
    """
    import sonarmap as sm
    import worlds
    from sonarbed.console import print_json, print_table, score_rows
    from sonarbed.options import load_world

    built = sm.OccupancyMap.load(map_)
    truth = worlds.truth(load_world(world, setting), built.grid)
    observable = None if log is None else truth.observable(sm.read_log(log))
    scores = sm.score_map(built, truth, observable=observable).to_dict()
    if as_json:
        print_json(scores)
        return
    cells = "observable" if log is not None else "not hidden"
    print_table(
        f"{scores['counts']['cells']} cells ({cells})",
        ["score", str(map_)],
        score_rows({"map": scores}),
    )
