"""`sonarbed demo`: the whole idea in one folder."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sonarbed.choices import listed, simulator

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sonarmap import OccupancyMap
    from worlds import TruthGrid

__all__ = ["demo"]

# What stands beside the thesis's maps: the first by skill in the arena (docs/arena.md).
_BEST = "learned"


def demo(
    out: Annotated[Path, typer.Option(help="The folder to write.")] = Path("demo"),
    world: Annotated[str, typer.Option(help="The room to drive in, or its file.")] = "office",
    scans: Annotated[int, typer.Option(help="How many scans to take.")] = 500,
    seed: Annotated[int, typer.Option(help="Seed of all that is random.")] = 0,
    sonar: Annotated[str, typer.Option(help=f"{listed(simulator('sonar_presets'))}.")] = "physical",
    driver: Annotated[
        str,
        typer.Option(
            help=f"{listed(simulator('drivers'))}. Auto is the room's route, else wander."
        ),
    ] = "auto",
) -> None:
    """Drive in a room, map as the thesis did and by the best method, score and picture the maps.

    Writes the log before and after HSR, the truth, the maps of the thesis's model before and after
    it and of the best method, scores.json and demo.png into one folder.

    Example:

      sonarbed demo --out demo
    """
    import sim
    import sonarmap as sm
    import worlds
    from sim.runs.arguments import DriveArguments
    from sonarbed.console import as_json, print_table, progress, say, score_rows
    from sonarbed.reporting.pictures import draw_demo
    from sonarmap.account import account_by, contacts_of
    from sonarmap.files import atomic_path, make_folder

    room = worlds.load(world)
    DriveArguments.of(room, scans=scans, seed=seed, driver=driver, sonar=sonar)
    folder = make_folder(out)
    with progress() as bars:
        driving = bars.add_task("driving, scans", total=scans)
        log = sim.simulate(
            room,
            scans=scans,
            seed=seed,
            driver=driver,
            sonar=sonar,
            on_scan=lambda scan: bars.advance(driving),
        )
        bars.add_task("mapping, scoring, drawing", total=None)
        repaired = sm.filter("hsr").apply(log)
        mended = repaired.log
        truth = worlds.truth(room)
        observable = truth.observable(log)
        method = sm.method("bayes-parameterized")
        maps = {
            "parameterized": method.map(log, truth.grid),
            "parameterized + HSR": method.map(mended, truth.grid),
            _BEST: sm.method(_BEST).map(log, truth.grid),
        }
        scores = {
            name: sm.score_map(built, truth, observable=observable).to_dict()
            for name, built in {**maps, "blank sheet": _sheet(truth, observable)}.items()
        }
        rows = score_rows(scores)
        account, after = (account_by(each, method) for each in (log, mended))
        contacts = contacts_of(log)
        assert contacts is not None, "a simulated log"
        notes = [
            f"{account}; after HSR, which updated {int(repaired.changed.sum())}: {after}",
            *([str(contacts)] if contacts.touched else []),
        ]

        # Written when all is computed: an interrupted demo does not mix with an older one.
        log.write(folder / "log.parquet")
        mended.write(folder / "log-hsr.parquet")
        truth.save(folder)
        for name, built in maps.items():
            built.save(folder / f"map-{name.lower().replace(' + ', '-')}")
        with atomic_path(folder / "scores.json") as path:
            path.write_text(as_json(scores), encoding="utf-8")
        table = (list(scores), rows)
        draw_demo(room, log, truth, observable, maps, table, folder / "demo.png", notes)
    print_table(f"{room.name}, {scans} scans: maps against the truth", ["score", *scores], rows)
    for note in notes:
        say(note)
    say(
        f"Written to {folder}/: log.parquet, log-hsr.parquet, truth.npz, map-*/, scores.json, "
        "demo.png"
    )


def _sheet(truth: TruthGrid, observable: NDArray[np.bool_]) -> OccupancyMap:
    """Return the blank sheet: a constant map that knows only the room's share of walls."""
    import numpy as np

    import sonarmap as sm
    import worlds

    share = float((truth.state[observable] == worlds.OCCUPIED).mean())
    return sm.OccupancyMap.from_probability(truth.grid, np.full(truth.grid.shape, share))
