"""`sonarbed demo`: the whole idea in one folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

__all__ = ["demo"]


def demo(
    out: Annotated[Path, typer.Option(help="The folder to write.")] = Path("demo"),
    room: Annotated[str, typer.Option(help="The room to drive in.")] = "thesis-exp1",
    scans: Annotated[int, typer.Option(help="How many scans to take.")] = 500,
    seed: Annotated[int, typer.Option(help="Seed of all that is random.")] = 0,
) -> None:
    """Simulate the thesis's first room, map it with both models, score the maps, picture all.

    Writes the log, the truth, both maps, scores.json and demo.png into one folder.
    """
    import sim
    import sonarmap as sm
    import worlds
    from sonarbed.console import print_table, progress, say, score_rows
    from sonarbed.pictures import draw_demo
    from sonarmap.files import atomic_path, make_folder

    folder = make_folder(out)
    world = worlds.load(room)
    with progress() as bars:
        task = bars.add_task("driving, scans", total=scans)
        log = sim.simulate(
            world, scans=scans, seed=seed, on_scan=lambda scan: bars.update(task, advance=1)
        )
    log.write(folder / "log.parquet")
    truth = worlds.truth(world)
    truth.save(folder)
    observable = truth.observable(log)
    maps = {
        "standard": sm.build_map(log, sm.StandardModel.thesis(), truth.grid),
        "parameterized": sm.build_map(log, sm.ParameterizedModel.thesis(), truth.grid),
    }
    scores = {}
    for name, built in maps.items():
        built.save(folder / f"map-{name}")
        scores[name] = sm.score_map(built, truth, observable=observable).to_dict()
    with atomic_path(folder / "scores.json") as path:
        path.write_text(json.dumps(scores, indent=2) + "\n", encoding="utf-8")
    rows = score_rows(scores)
    draw_demo(world, log, truth, observable, maps, rows, folder / "demo.png")
    print_table(f"{room}, {scans} scans: maps against the truth", ["score", *maps], rows)
    say(f"Written to {folder}/: log.parquet, truth.npz, map-*/, scores.json, demo.png")
