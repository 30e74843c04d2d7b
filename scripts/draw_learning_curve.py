"""Measure and draw how the learned mapper gains by rooms and by parameters.

    python scripts/draw_learning_curve.py mapper --out docs/learned/learning-curve.png

`mapper` is the folder that `scripts/train_mapper.py` has filled; needs the extra `train`. Each
point is a network of its own, fitted with fewer steps than the one that ships. Stopped at any
moment, the same command goes on.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from mapper_training.examples import load_split
from mapper_training.fitting import Fitting
from mapper_training.learning_curve import Point, learning_curve
from sonarbed.console import say
from sonarbed.reporting.drawing import COLOURS, figure_with, save
from sonarmap import InputError
from sonarmap.errors import positive


def main(
    folder: Annotated[Path, typer.Argument(help="Of the training: has `examples`.")],
    out: Annotated[Path, typer.Option(help="The PNG.")] = Path("docs/learned/learning-curve.png"),
    steps: Annotated[int, typer.Option(help="Steps of the fitting of each network.")] = 500,
    seed: Annotated[int, typer.Option(help="Of crops and first weights.")] = 0,
    threads: Annotated[int, typer.Option(help="Threads of the training library.")] = 1,
) -> None:
    """Measure and draw how the learned mapper gains by rooms and by parameters."""
    for name in ("steps", "threads"):
        positive(f"--{name}", locals()[name])
    train, held_out = load_split(sorted((folder / "examples").glob("*.npz")))
    if not train or not held_out:
        raise InputError(f"{folder}: no examples; make them by scripts/train_mapper.py --out")
    points = learning_curve(
        train,
        held_out,
        Fitting(steps=steps, seed=seed, threads=threads),
        folder / f"learning-curve-{steps}-{seed}.jsonl",
        on_point=_tell,
    )
    _draw(points, steps, len(held_out), out)


def _tell(point: Point) -> None:
    say(
        f"{point.rooms} rooms, {point.parameters:,} parameters: "
        f"{point.held_out_bits:.4f} bits a cell"
    )


def _draw(points: list[Point], steps: int, held_out: int, out: Path) -> None:
    most = max(point.rooms for point in points)
    shipped = Fitting().widths
    curves = {
        "rooms to train on": [(p.rooms, p.held_out_bits) for p in points if p.widths == shipped],
        "parameters": [(p.parameters, p.held_out_bits) for p in points if p.rooms == most],
    }
    figure, axes = figure_with(1, 2, width=4.2, height=3.2, sharey=True)
    for place, (label, curve) in zip(axes, curves.items(), strict=True):
        x, bits = zip(*sorted(curve), strict=True)
        place.plot(x, bits, "o-", color=COLOURS[0])
        place.set_xscale("log")
        place.minorticks_off()
        place.set_xticks(x, [f"{each:,}" for each in x])
        place.set_xlabel(label)
        place.grid(alpha=0.3)
    axes[0].set_ylabel(f"bits a cell, {held_out} held-out drives")
    figure.suptitle(f"networks of {steps} steps each")
    save(figure, out)


if __name__ == "__main__":
    try:
        typer.run(main)
    except InputError as error:
        sys.exit(f"draw_learning_curve: {error}")
