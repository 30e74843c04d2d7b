"""Draw a real robot's log by three methods: the thesis's map, HSR's, and the learned one.

    python scripts/draw_real_log.py FOLDER --out docs/learned/real-log.png

FOLDER has `measurement.txt` and `poses.txt` of the log of eight sonars in a hallway from
https://github.com/udacity/RoboND-OccupancyGridMappingAlgorithm (MIT), folder `Data`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

import sonarmap as sm
from sonarbed.reporting.drawing import figure_with, save
from sonarbed.reporting.pictures import plan
from sonarmap import InputError
from worlds.colours import PATH_COLOUR

_THESIS = sm.method("bayes-parameterized")
_METHODS = {
    "thesis's model": _THESIS,
    "HSR, then thesis's model": sm.Pipeline([sm.filter("hsr")], _THESIS),
    "learned": sm.method("learned"),
}

_CLASSES = {"free": "#FFFFFF", "occupied": "#000000", "neither": "#D9D9D9", "unknown": "#A9B4C0"}


def main(
    folder: Annotated[Path, typer.Argument(help="Where the two files of the log are.")],
    out: Annotated[Path, typer.Option(help="The PNG.")] = Path("docs/learned/real-log.png"),
) -> None:
    """Draw the log of a real robot as three methods map it."""
    log = sm.mark_stale(sm.read_udacity(folder / "measurement.txt", folder / "poses.txt"))
    grid = sm.grid_over(log, max_range_m=3.0)
    left, right, bottom, top = grid.extent_m
    width = 4.6
    figure, axes = figure_with(
        1, 3, width=width, height=width * (top - bottom) / (right - left) + 1.2, sharey=True
    )
    for place, (name, method) in zip(axes, _METHODS.items(), strict=True):
        _show(place, method.map(log, grid))
        place.plot(log.x_m, log.y_m, color=PATH_COLOUR, lw=1.0)
        place.set_title(name)
        place.label_outer()
    figure.legend(
        [Patch(facecolor=colour, edgecolor="#9A9A9A") for colour in _CLASSES.values()],
        _CLASSES,
        loc="outside lower center",
        ncols=len(_CLASSES),
        frameon=False,
    )
    save(figure, out)


def _show(axes: Axes, m: sm.OccupancyMap) -> None:
    """Show what a map calls its cells, by its own thresholds."""
    unknown = np.zeros(m.grid.shape, bool) if m.observed is None else ~m.observed
    # A map of log-odds says nothing by a half.
    unknown |= m.probability == 0.5
    states = np.select([m.free, m.occupied, unknown], [0, 1, 3], 2)
    axes.imshow(
        states,
        cmap=ListedColormap(list(_CLASSES.values())),
        vmin=-0.5,
        vmax=3.5,
        origin="lower",
        extent=m.grid.extent_m,
        interpolation="nearest",
    )
    plan(axes)


if __name__ == "__main__":
    try:
        typer.run(main)
    except InputError as error:
        sys.exit(f"draw_real_log: {error}")
