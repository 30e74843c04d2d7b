"""What commands print: results on standard output, progress on standard error."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

__all__ = ["as_json", "print_json", "print_table", "progress", "say", "score_rows", "working"]

# A file or a pipe has no width: tables in it are as wide as they like, up to this.
_PIPE_WIDTH = 200


def say(message: str) -> None:
    """Print a line for people on standard output."""
    print(message)


def as_json(value: Any) -> str:
    """Return a value as JSON text that ends with a new line."""
    return json.dumps(value, indent=2, sort_keys=True, allow_nan=False) + "\n"


def print_json(value: Any) -> None:
    """Print a value as JSON on standard output, for programs."""
    print(as_json(value), end="")


def print_table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; a column of numbers, with or without units, is aligned to the right."""
    table = Table()
    for name, *cells in zip(header, *rows, strict=True):
        numbers = all(cell == "-" or cell.lstrip("-")[:1].isdigit() for cell in cells)
        table.add_column(name, justify="right" if numbers else "left", overflow="fold")
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    console = _Console(highlight=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = _PIPE_WIDTH
    say(title)
    console.print(table)


class _Console(Console):
    """Standard output that leaves its errors to `main`."""

    def on_broken_pipe(self) -> None:
        """Pass on the error that is being handled; Rich would end the program itself."""
        raise


@contextmanager
def progress() -> Iterator[Progress]:
    """Show progress bars on standard error while the block runs, if that is a terminal."""
    console = Console(stderr=True)
    bars = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=console,
        transient=True,
        # Rich takes FORCE_COLOR for a terminal, and a log of CI would show every step.
        disable=not (console.is_terminal and sys.stderr.isatty()) or console.is_dumb_terminal,
    )
    with bars:
        yield bars


@contextmanager
def working(label: str) -> Iterator[None]:
    """Show that something is going on while the block runs, when it cannot tell how far it is."""
    with progress() as bars:
        bars.add_task(label, total=None)
        yield


def score_rows(scores: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Return table rows of scores: one row a measure, one column a map."""
    return [
        [label, *(_number(values[name], unit) for values in scores.values())]
        for name, label, unit in SCORES
    ]


# Which scores people see, in what words and unit; the JSON has them all, with their counts.
SCORES = (
    ("skill", "skill over the blank sheet", ""),
    ("map_score", "Map Score per cell", "bit"),
    ("average_precision", "average precision", ""),
    ("tolerant_average_precision", "the same within 1 cell", ""),
    ("calibration_error", "calibration error", ""),
    ("brier", "Brier score", ""),
    ("correlation", "correlation", ""),
    ("f1_1_cell", "F1 within 1 cell", ""),
    ("f1_10_cm", "F1 within 10 cm", ""),
    ("f1_20_cm", "F1 within 20 cm", ""),
    ("coverage", "coverage", ""),
    ("false_free_m2", "false-free area", "m²"),
    ("phantom_m2", "phantom area", "m²"),
    ("wall_gap_m", "walls without a cell", "m"),
    ("thickness_m", "thickness of walls", "m"),
    ("baddeley_m", "Baddeley's distance", "m"),
    ("image_dissimilarity", "image dissimilarity", "cells"),
    ("map_to_truth_m", "map to truth, mean", "m"),
    ("truth_to_map_m", "truth to map, mean", "m"),
)


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.3f} {unit}".strip()
