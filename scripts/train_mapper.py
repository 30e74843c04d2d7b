"""Train the learned mapper and the filter by its map, from nothing: data, network, weights, card.

    pip install -e '.[train]'
    python scripts/train_mapper.py --out mapper

Rooms are generated and driven in, logs become channels, a network is fitted to them, calibrated on
rooms that were held out, and a second, small one learns to judge readings by the first one's maps.
In the folder are then `mapper.npz` and `mapper.md`, the weights and their card, which ship in
`sonarmap/learned`. Stopped at any moment, the same command goes on where it was. The same seed
makes the same weights on one machine. A GPU is used if the training library finds one.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Annotated

import typer

from mapper_training.card import Made, write_card
from mapper_training.examples import load_split, logs_of, make_examples
from mapper_training.exporting import weights_of
from mapper_training.finishing import finish
from mapper_training.fitting import Fitting, Progress, fit
from mapper_training.rooms_and_logs import make_logs
from sonarbed.console import say
from sonarmap import InputError
from sonarmap.errors import positive
from sonarmap.files import make_folder
from sonarmap.learned.weights import Weights


def main(
    out: Annotated[
        Path, typer.Option(help="The folder for logs, examples, weights and card.")
    ] = Path("mapper"),
    rooms: Annotated[int, typer.Option(help="How many rooms, about; a drive each.")] = 1100,
    steps: Annotated[int, typer.Option(help="Steps of the fitting.")] = 3000,
    judge_drives: Annotated[
        int, typer.Option(help="Drives in training rooms for the judge of readings.")
    ] = 150,
    seed: Annotated[int, typer.Option(help="Of rooms, drives, crops and first weights.")] = 0,
    workers: Annotated[int, typer.Option(help="Processes that simulate.")] = 2,
    threads: Annotated[int, typer.Option(help="Threads of the training library.")] = 1,
) -> None:
    """Train the learned mapper and its filter of readings."""
    for name in ("rooms", "steps", "judge_drives", "workers", "threads"):
        positive(f"--{name.replace('_', '-')}", locals()[name])
    make_folder(out)
    data_sets = make_logs(out / "logs", rooms=rooms, seed=seed, workers=workers)
    files = make_examples(data_sets, out / "examples", seed=seed, workers=workers)
    train, held_out = load_split(files)
    say(f"{len(train)} drives to train on, {len(held_out)} in rooms held out")
    net = fit(
        train,
        held_out[::4],
        Fitting(steps=steps, seed=seed, threads=threads),
        checkpoint=out / "checkpoint.pt",
        on_progress=_tell,
    )
    logs = [file for folder in data_sets for file in logs_of(folder)]
    done = finish(weights_of(net), held_out, logs, judge_drives=judge_drives, seed=seed, say=say)
    file = out / "mapper.npz"
    done.weights.save(file)
    made = Made(
        command=(
            f"python scripts/train_mapper.py --rooms {rooms} --steps {steps} "
            f"--judge-drives {judge_drives} --seed {seed} --threads {threads}"
        ),
        parameters=sum(each.numel() for each in net.parameters()),
        train=len(train),
        held_out=len(held_out),
        groups=Counter(each.group for each in train + held_out),
        figures=done.figures,
        reading=done.reading,
    )
    write_card(out / "mapper.md", file, Weights.load(file), made)


def _tell(progress: Progress) -> None:
    say(
        f"step {progress.step}: loss {progress.loss:.4f}, held-out {progress.held_out_bits:.4f} "
        f"bits a cell, {progress.seconds:.0f} s"
    )


if __name__ == "__main__":
    try:
        typer.run(main)
    except InputError as error:
        sys.exit(f"train_mapper: {error}")
