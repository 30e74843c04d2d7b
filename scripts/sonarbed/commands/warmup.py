"""`sonarbed warmup`: compile beforehand what the commands and environments use."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated

import typer

from sonarbed.options import Json

__all__ = ["warmup"]


def warmup(
    environments: Annotated[
        bool,
        typer.Option(
            "--environments/--no-environments", help="Those of Gymnasium too, if it is installed."
        ),
    ] = True,
    as_json: Json = False,
) -> None:
    """Compile now what would be compiled at its first use: for images, CI and clusters.

    The compiled code is kept beside the package or, where that may not be written, in the user's
    cache; NUMBA_CACHE_DIR names another folder.

    Example: sonarbed warmup
    """
    from sonarbed.console import print_json, print_table, progress, say
    from sonarbed.warming import is_kept, parts

    chosen = parts(environments=environments)
    seconds: dict[str, float] = {}
    with progress() as bars:
        task = bars.add_task("compiling", total=len(chosen))
        for name, run in chosen.items():
            bars.update(task, description=f"compiling: {name}")
            seconds[name] = _timed(run)
            bars.advance(task)
    kept = is_kept()
    if as_json:
        print_json({"seconds": seconds, "kept": kept})
        return
    rows = [[name, f"{spent:.1f} s"] for name, spent in seconds.items()]
    print_table("Compiled", ["for", "seconds"], rows)
    if kept:
        say("What is compiled is kept: the next process loads it.")
    else:
        say(
            "Nothing can be kept, for neither the package's folder nor a cache may be written: "
            "every process compiles anew. Let NUMBA_CACHE_DIR name a folder that may."
        )


def _timed(run: Callable[[], object]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin
