"""The parts of the page on acoustics: each draws what the sonars do beside theory.

A part is a module with a function ``run(context) -> Section``, as a study of the thesis report.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sonarbed.reporting.context import StudyContext
    from sonarbed.reporting.section import Section

__all__ = ["PARTS", "load"]

# In the order of the page; each is a module or a folder of this package.
PARTS = ("beam", "regions", "sizes", "dropout", "ghost", "crosstalk", "causes", "reality")


def load(name: str) -> Callable[[StudyContext], Section]:
    """Return the function that makes the part called `name`."""
    run: Callable[[StudyContext], Section] = import_module(f"sonarbed.studies.acoustics.{name}").run
    return run
