"""What all figures share: colours, panels, and how they are written."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sonarmap.files import atomic_path

__all__ = ["COLOURS", "figure_with", "save"]

_DPI = 110
# Okabe and Ito's palette: distinct for colour-blind people too.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")


def figure_with(
    rows: int = 1, cols: int = 1, *, width: float = 5.5, height: float = 4.2, **arguments: Any
) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes row by row, each of the given size in inches."""
    figure = Figure(figsize=(width * cols, height * rows), layout="constrained")
    axes = figure.subplots(rows, cols, squeeze=False, **arguments)
    return figure, list(axes.flat)


def save(figure: Figure, path: Path) -> None:
    """Write a figure as PNG; an older file is replaced only when all is written."""
    with atomic_path(path) as beside:
        figure.savefig(beside, dpi=_DPI, format="png")
