"""The picture of a search: how its score grew, and where in their ranges good values lie."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sonarbed.reporting.drawing import COLOURS, save
from sonarbed.studies.tuning.search import Search, Trial

__all__ = ["draw_search"]

_TRIAL, _BEST = COLOURS[5], COLOURS[1]
_OTHERS = (COLOURS[0], COLOURS[2])
_COLUMNS = 4
# The worst trials lie so far below that they would press all others into a line.
_SHOWN_SHARE = 0.1


def draw_search(
    search: Search,
    trials: tuple[Trial, ...],
    best: Trial,
    training: Mapping[str, float],
    path: Path,
) -> None:
    """Draw the score of every trial in its order, and against each parameter that was searched.

    Parameters
    ----------
    search : Search
        The search.
    trials : tuple of Trial
        Its finished trials.
    best : Trial
        The best of them.
    training : mapping of str to float
        Training scores of what the best is held against, by name.
    path : Path
        The file to write.
    """
    scores = np.array([trial.score for trial in trials])
    values = [trial.candidate.to_dict() for trial in trials]
    # P1 is 1 - P4 and says nothing new.
    searched = [
        name for name in values[0] if name != "p1" and len({each[name] for each in values}) > 1
    ]
    rows = -(-len(searched) // _COLUMNS)
    figure = Figure(figsize=(13, 4.2 + 3 * rows), layout="constrained")
    grid = figure.add_gridspec(1 + rows, _COLUMNS, height_ratios=[1.3, *[1] * rows])
    settings = search.settings
    figure.suptitle(
        f"{len(trials)} trials by {settings.sampler} on {', '.join(settings.train)}", fontsize=13
    )

    history = figure.add_subplot(grid[0, :])
    order = np.arange(1, len(scores) + 1)
    history.plot(order, scores, ".", ms=4, color=_TRIAL, label="trial")
    so_far = np.maximum if settings.higher_is_better else np.minimum
    history.step(order, so_far.accumulate(scores), where="post", color=_BEST, label="best so far")
    for (name, score), colour in zip(training.items(), _OTHERS, strict=False):
        history.axhline(score, color=colour, ls="--", lw=1.2, label=f"{name}: {score:.3f}")
    history.set_xlabel("trial")
    _score_axis(history, settings.score, scores, training, higher=settings.higher_is_better)
    history.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)

    for index, name in enumerate(searched):
        axes = figure.add_subplot(grid[1 + index // _COLUMNS, index % _COLUMNS], sharey=history)
        axes.plot([each[name] for each in values], scores, ".", ms=4, color=_TRIAL)
        axes.plot(best.candidate.to_dict()[name], best.score, "o", ms=8, color=_BEST)
        axes.set_xlabel(name)
        if index % _COLUMNS:
            axes.tick_params(labelleft=False)
        else:
            axes.set_ylabel(settings.score)
    save(figure, path)


def _score_axis(
    axes: Axes,
    label: str,
    scores: np.ndarray,
    training: Mapping[str, float],
    *,
    higher: bool,
) -> None:
    axes.set_ylabel(label)
    worst = np.quantile(scores, _SHOWN_SHARE if higher else 1 - _SHOWN_SHARE)
    shown = [worst, scores.max() if higher else scores.min(), *training.values()]
    margin = 0.08 * (max(shown) - min(shown)) or 0.01
    axes.set_ylim(min(shown) - margin, max(shown) + margin)
