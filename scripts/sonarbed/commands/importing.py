"""`sonarbed import`: logs of real robots."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sonarbed.choices import listed
from sonarbed.options import Json, check_log_out
from sonarmap.catalogue import IMPORTERS, RINGS

__all__ = ["import_"]

_UNUSED = ("stale", "rejected", "too_close")


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
            help=f"The robot's sonars: {listed(RINGS)}, or a TOML file; default the format's own, "
            "if it has one."
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
    from sonarmap.account import account_of

    check_log_out(out)
    log = sm.import_log(files, format_, None if ring is None else sm.ring(ring))
    if not keep_stale:
        log = sm.mark_stale(log)
    log.write(out)
    account, usable = account_of(log), log.usable
    facts = {
        "file": str(out),
        "scans": int(np.unique(log.scan).size),
        "seconds": round(float(log.time_s[-1] - log.time_s[0]), 3),
        # Each reading counts once: what is stale or rejected is neither too close nor silent.
        "readings": account.readings,
        **{name: account.unused.get(name.replace("_", " "), 0) for name in _UNUSED},
        "used": account.used,
        "no_echo": int((usable & np.isposinf(log.range_m)).sum()),
    }
    if as_json:
        print_json(facts)
        return
    print_table("Imported", ["what", "value"], [[k, str(v)] for k, v in facts.items()])
