"""From the fitted network to weights that ship: calibrations, thresholds, the judge, figures."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from mapper_training.calibrating import (
    Drive,
    MapFigures,
    calibrated,
    map_figures,
    with_thresholds,
)
from mapper_training.examples import Example, readings_of
from mapper_training.judging import Judged, fit_judge, judged, reading_figures
from sonarmap.learned.weights import Weights
from sonarmap.methods.learned import Learned

__all__ = ["Finished", "finish"]

_THRESHOLD_DRIVES = 80
# Of the drives that were held out a quarter is for figures, a quarter for thresholds of doubt, and
# the others are for calibration and, beside drives in training rooms, for the judge of readings:
# there the map is as sure as it will be in rooms that it has not seen.
_QUARTERS = 4


@dataclass(frozen=True)
class Finished:
    """Weights that are complete, and how good they are on drives that nothing was chosen on."""

    weights: Weights
    figures: MapFigures
    reading: Mapping[str, float]


def finish(
    weights: Weights,
    held_out: Sequence[Example],
    files: Sequence[Path],
    *,
    judge_drives: int,
    seed: int,
    say: Callable[[str], None],
) -> Finished:
    """Return complete weights.

    Parameters
    ----------
    weights : Weights
        Of the fitted network.
    held_out : sequence of Example
        Of rooms that were held out.
    files : sequence of Path
        All logs, in the order of their numbers.
    judge_drives : int
        Drives in training rooms that the judge of readings is fitted to, beside held-out ones.
    seed : int
        Of the training.
    say : callable
        Told how far it is.
    """
    train, held = [], []
    for number, file in enumerate(files):
        (train if "split=train" in file.parts else held).append((file, number))

    def drives(chosen: Sequence[tuple[Path, int]]) -> list[Drive]:
        return [Drive(*readings_of(file, number, seed)[:2]) for file, number in chosen]

    def spread(count: int) -> Sequence[tuple[Path, int]]:
        return train[:: max(len(train) // count, 1)][:count]

    for_figures, for_doubt, *others = (drives(held[k::_QUARTERS]) for k in range(_QUARTERS))
    to_choose = [drive for some in others for drive in some]
    weights = calibrated(weights, to_choose, held_out)
    say(f"calibrations {dict(weights.calibrations)}, unseen walls {weights.share:.3f}")
    weights = with_thresholds(weights, drives(spread(_THRESHOLD_DRIVES)))
    say(f"occupied from {weights.occupied_from}, free up to {weights.free_up_to}")
    figures = map_figures(weights, for_figures)
    say(f"maps: {figures}")
    with tempfile.TemporaryDirectory() as folder:
        # The filter reads its map by the file that a person gives: so does its training.
        file = Path(folder) / "mapper.npz"
        weights.save(file)
        method = Learned(weights=str(file))

        def readings(of: Sequence[Drive]) -> list[Judged]:
            return [judged(method, drive.log) for drive in of if drive.log.usable.any()]

        fitted_to = Judged.joined(readings(drives(spread(judge_drives)) + to_choose))
        judge = fit_judge(fitted_to, Judged.joined(readings(for_doubt)), seed=seed)
        reading = reading_figures(judge, Judged.joined(readings(for_figures)))
    say(f"readings: {reading}")
    return Finished(replace(weights, reading=judge), figures, reading)
