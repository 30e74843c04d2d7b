"""`sonarbed export`: logs for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from sonarbed.choices import listed
from sonarbed.options import Json, check_writable
from sonarmap.catalogue import EXPORTERS

__all__ = ["export"]


def _formats() -> str:
    """Return the formats for help, with what they hold where that costs no loading of others'."""
    return listed(
        f"{name} ({EXPORTERS[name].about})" if name in EXPORTERS.shipped else name
        for name in EXPORTERS
    )


def export(
    log: Annotated[Path, typer.Argument(help="The log (Parquet).")],
    to: Annotated[Path, typer.Option(help="The file to write.")],
    format_: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="NAME",
            help=f"{_formats()}, or package.module:Name; default by the suffix of the file.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Write a log in the format of other programs; the log stays as it is.

    Example, after `sonarbed simulate thesis-exp1 --out drive.parquet`:

      sonarbed export drive.parquet --to drive.csv
    """
    import sonarmap as sm
    from sonarbed.console import print_json, say
    from sonarmap.errors import InputError
    from sonarmap.exporters import exporter_for

    if log.resolve() == to.resolve():
        raise InputError(f"--to must be another file than the log, got {str(to)!r}")
    exporter = exporter_for(to, format_)
    check_writable(to)
    readings = sm.read_log(log)
    sm.export_log(readings, to, exporter)
    name = to.suffix.lower().removeprefix(".") if format_ is None else format_
    if as_json:
        print_json({"file": str(to), "format": name, "readings": len(readings)})
        return
    about = getattr(exporter, "about", None)
    say(f"{to}: {len(readings)} readings as {name}" + (f" ({about})" if about else ""))
