"""`sonarbed demo`: the whole idea in one folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sonarbed.choices import listed, simulator

__all__ = ["demo"]


def demo(
    out: Annotated[Path, typer.Option(help="The folder to write.")] = Path("demo"),
    world: Annotated[str, typer.Option(help="The room to drive in, or its file.")] = "thesis-exp1",
    scans: Annotated[int, typer.Option(help="How many scans to take.")] = 500,
    seed: Annotated[int, typer.Option(help="Seed of all that is random.")] = 0,
    sonar: Annotated[str, typer.Option(help=f"{listed(simulator('sonar_presets'))}.")] = "thesis",
    driver: Annotated[
        str,
        typer.Option(
            help=f"{listed(simulator('drivers'))}. Auto is the room's route, else wander."
        ),
    ] = "auto",
) -> None:
    """Drive in a room, run HSR, map with both sensor models, score and picture the maps.

    Writes the log before and after HSR, the truth, the maps of both models and of the log after
    HSR, scores.json and demo.png into one folder.

    Example:

      sonarbed demo --out demo
    """
    import sim
    import sonarmap as sm
    import worlds
    from sim.runs.simulation import DriveArguments
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
        repaired = sm.hsr(log, sm.HsrParams.thesis(log.ring))
        mended = repaired.log
        truth = worlds.truth(room)
        observable = truth.observable(log)
        maps = {
            "standard": sm.build_map(log, sm.StandardModel.thesis(), truth.grid),
            "parameterized": sm.build_map(log, sm.ParameterizedModel.thesis(), truth.grid),
            "parameterized + HSR": sm.build_map(mended, sm.ParameterizedModel.thesis(), truth.grid),
        }
        scores = {
            name: sm.score_map(built, truth, observable=observable).to_dict()
            for name, built in maps.items()
        }
        rows = score_rows(scores)
        # Both models use the same readings of a log.
        method = sm.method("bayes-parameterized")
        account, after = (account_by(each, method) for each in (log, mended))
        contacts = contacts_of(log)
        assert contacts is not None, "a simulated log"
        notes = [
            f"{account}; after HSR, which updated {int(repaired.updated.sum())}: {after}",
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
        draw_demo(room, log, truth, observable, maps, rows, folder / "demo.png", notes)
    print_table(f"{room.name}, {scans} scans: maps against the truth", ["score", *maps], rows)
    for note in notes:
        say(note)
    say(
        f"Written to {folder}/: log.parquet, log-hsr.parquet, truth.npz, map-*/, scores.json, "
        "demo.png"
    )
