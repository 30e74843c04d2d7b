"""Writes the model card that ships beside the weights."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from mapper_training.calibrating import MapFigures
from sonarmap.files import atomic_path
from sonarmap.learned.channels import CHANNELS
from sonarmap.learned.weights import Weights

__all__ = ["Made", "write_card"]

_CARD = """\
# The learned mapper: model card

Weights `mapper.npz`, SHA-256 of their content
`{digest}`, {size_kb:.0f} kB.

**What it is.** A U-Net of {parameters:,} numbers ({widths} channels) over {channels} maps of
evidence of a whole log (`sonarmap/learned/channels.py` says what each is and why), which states for
each cell of 5 cm the probability that it is occupied and whether it was observed; and a network of
two small layers that judges each reading by what that map says along its cone.

**How it was made.** `{command}`

**Data.** {drives} drives of 150 to 500 scans, simulated, each in a generated room of its own, in
ten styles ({train} for training, {held_out} held out as rooms). In groups: {groups}. Of all,
a fifth was thinned to 25 to 60 % of its readings; a fifth has true poses, three tenths have refined
ones. The eight rooms that ship were not seen. No real robot's log was used.

**Calibration** of P on held-out rooms, two numbers each: {calibrations}. A cell counts as
occupied from P = {occupied_from:g} and as free up to {free_up_to:g}, chosen on training rooms. Of
the cells that nothing looked at {share:.1%} are walls.

**On {figure_drives} held-out drives** that nothing was chosen on:

| figure | value |
|---|---|
| bits a cell, mean of drives | {bits:.3f} |
| skill: pooled, mean, worst drive | {skill_pooled:.2f}, {skill_mean:.2f}, {skill_worst:.2f} |
| F1 within 10 cm | {f1_10_cm:.3f} |
| calibration error | {calibration_error:.4f} |
| wrong readings: area under ROC | {roc_auc:.4f} |
| caught while 1 % of right ones are lost | {caught:.3f} |
| of those caught, predicted to within 10 cm | {mended:.3f} |

**Limits.** Trained on simulated sound in two dimensions: furniture has no height, nobody walks
through. Walls are as blurred as the poses are wrong. Mirrors that
were never met head-on are missing or half a wall. Legs of chairs merge. Convex corners are rounded.
Rings of wider cones than 25 degrees to a side, and ranges beyond 5.5 m, were not trained on; of no
echo only the first 3 m count. P is a cell's own: two neighbours are not independent.
"""


@dataclass(frozen=True)
class Made:
    """What a training made, for the card.

    Parameters
    ----------
    command : str
        How it was called.
    parameters, train, held_out : int
        Numbers of the network; drives.
    groups : mapping
        Drives by group.
    figures : MapFigures
        Of maps of held-out drives.
    reading : mapping
        ``roc_auc``, ``caught`` and ``mended`` of the judge.
    """

    command: str
    parameters: int
    train: int
    held_out: int
    groups: Mapping[str, int]
    figures: MapFigures
    reading: Mapping[str, float]


def write_card(path: Path, weights_file: Path, weights: Weights, made: Made) -> None:
    """Write the card of a file of weights."""
    figures = made.figures
    text = _CARD.format(
        digest=weights.digest,
        size_kb=weights_file.stat().st_size / 1000,
        parameters=made.parameters,
        widths=", ".join(map(str, weights.widths)),
        channels=len(CHANNELS),
        command=made.command,
        drives=made.train + made.held_out,
        train=made.train,
        held_out=made.held_out,
        groups=", ".join(f"{name} {count}" for name, count in made.groups.items()),
        calibrations=", ".join(
            f"{5 * ratio:g} cm {each.scale:.3f} and {each.offset:+.3f}"
            for ratio, each in weights.calibrations.items()
        ),
        occupied_from=weights.occupied_from,
        free_up_to=weights.free_up_to,
        share=weights.share,
        figure_drives=figures.drives,
        bits=figures.bits,
        skill_pooled=figures.skill_pooled,
        skill_mean=figures.skill_mean,
        skill_worst=figures.skill_worst,
        f1_10_cm=figures.f1_10_cm,
        calibration_error=figures.calibration_error,
        **made.reading,
    )
    with atomic_path(path) as beside:
        beside.write_text(text, encoding="utf-8")
