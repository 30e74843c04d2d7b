"""Names that the options of the command line offer, listed without loading what they name."""

from __future__ import annotations

import runpy
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sonarmap.registry import Registry

__all__ = ["listed", "simulator"]


def listed(names: Iterable[str]) -> str:
    """Return names as a help text lists them: "one, two or three"."""
    *first, last = names
    return f"{', '.join(first)} or {last}" if first else last


def simulator(kind: str) -> Registry[Any]:
    """Return the names of "drivers", "engines" or "sonar_presets", installed ones included."""
    return Registry(kind, f"sonarbed.{kind}", _catalogue()[kind.upper()])


@cache
def _catalogue() -> dict[str, Any]:
    # Run, not imported: to import a module of `sim` is to import `sim`, which loads Gymnasium.
    spec = find_spec("sim")
    assert spec is not None, "sim is installed with the command line"
    assert spec.submodule_search_locations is not None, "sim is a package"
    return runpy.run_path(str(Path(spec.submodule_search_locations[0]) / "catalogue.py"))
