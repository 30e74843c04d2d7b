"""What commands print: results on standard output, progress on standard error."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

__all__ = ["print_json", "print_table", "progress", "say"]


def say(message: str) -> None:
    """Print a line for people on standard output."""
    Console(highlight=False, soft_wrap=True).print(message, markup=False)


def print_json(value: Any) -> None:
    """Print a value as JSON on standard output, for programs."""
    print(json.dumps(value, indent=2, sort_keys=True, allow_nan=False))


def print_table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; every column but the first is aligned to the right."""
    table = Table(title=title, title_justify="left")
    for index, name in enumerate(header):
        table.add_column(name, justify="left" if index == 0 else "right")
    for row in rows:
        table.add_row(*row)
    Console(highlight=False).print(table)


@contextmanager
def progress(*, shown: bool = True) -> Iterator[Progress]:
    """Show progress bars on standard error while the block runs, if that is a terminal."""
    bars = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
        disable=not shown,
    )
    with bars:
        yield bars


def score_rows(scores: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Return table rows of scores: one row a measure, one column a map."""
    return [
        [label, *(_number(values[name], unit) for values in scores.values())]
        for name, label, unit in SCORES
    ]


# Which scores people see, in what words and unit; the JSON has them all, with their counts.
SCORES = (
    ("map_score", "Map Score per cell", "bit"),
    ("brier", "Brier score", ""),
    ("correlation", "correlation", ""),
    ("f1_1_cell", "F1 within 1 cell", ""),
    ("f1_10_cm", "F1 within 10 cm", ""),
    ("f1_20_cm", "F1 within 20 cm", ""),
    ("coverage", "coverage", ""),
    ("false_free_m2", "false-free area", "m²"),
    ("phantom_m2", "phantom area", "m²"),
    ("map_to_truth_m", "map to truth, mean", "m"),
    ("truth_to_map_m", "truth to map, mean", "m"),
)


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.3f} {unit}".strip()
