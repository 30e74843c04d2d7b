"""`sonarbed import`: logs of real robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sonarbed.choices import listed
from sonarbed.options import Json, check_writable
from sonarmap.catalogue import IMPORTERS, RINGS

__all__ = ["import_"]


def _formats() -> str:
    """Return the formats for help, with their files where that costs no loading of others'."""
    return listed(_described(name) if name in IMPORTERS.shipped else name for name in IMPORTERS)


def _described(name: str) -> str:
    importer = IMPORTERS[name]
    return f"{name} ({' '.join([*importer.files, importer.about]).strip()})"


def import_(
    files: Annotated[list[Path], typer.Argument(help="The files, in the format's order.")],
    out: Annotated[Path, typer.Option(help="The log to write (Parquet).")],
    format_: Annotated[
        str,
        typer.Option(
            "--format",
            metavar="NAME",
            help=f"{_formats()}, or package.module:Name of your own.",
        ),
    ],
    ring: Annotated[
        str | None,
        typer.Option(
            help=f"The robot's sonars: {listed(RINGS)}; default the format's own, if it has one."
        ),
    ] = None,
    keep_stale: Annotated[
        bool,
        typer.Option(
            "--keep-stale", help="Do not mark readings that only repeat the one before as stale."
        ),
    ] = False,
    as_json: Json = False,
) -> None:
    r"""Read a real robot's log; repeats are marked and left out of maps.

    Example:

      sonarbed import measurement.txt poses.txt \
        --format udacity --ring udacity8 --out log.parquet
    """
    import numpy as np

    import sonarmap as sm
    from sonarbed.console import print_json, print_table

    check_writable(out)
    log = sm.import_log(files, format_, None if ring is None else sm.ring(ring))
    if not keep_stale:
        log = sm.mark_stale(log)
    log.write(out)
    facts = {
        "file": str(out),
        "scans": int(np.unique(log.scan).size),
        "readings": len(log),
        "seconds": round(float(log.time_s[-1] - log.time_s[0]), 3),
        "no_echo": int(np.isposinf(log.range_m).sum()),
        "too_close": int(np.isneginf(log.range_m).sum()),
        "stale": int(log.stale.sum()),
    }
    if as_json:
        print_json(facts)
        return
    print_table("Imported", ["what", "value"], [[k, str(v)] for k, v in facts.items()])
