"""The studies of the thesis report: each makes some of its figures and tables again.

A study is a module or a folder with a function ``run(context) -> ThesisSection``. It asks the
context for logs, writes its figures and tables through it, and says in a sentence what the numbers
decide.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import TYPE_CHECKING

from sonarmap.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from sonarbed.reporting.context import StudyContext
    from sonarbed.studies.thesis.questions import ThesisSection

__all__ = ["STUDIES", "load"]

# In the order of the thesis; each is a module or a folder of this package.
STUDIES = (
    "sensor_models",
    "two_models",
    "goodness",
    "data_points",
    "target_distance",
    "openings",
    "wall_sizes",
    "readings",
)


def load(name: str) -> Callable[[StudyContext], ThesisSection]:
    """Return the function that runs the study called `name`, or raise `InputError`."""
    if name not in STUDIES:
        raise InputError(f"study {name!r} is unknown{did_you_mean(name, STUDIES)}")
    study = import_module(f"sonarbed.studies.thesis.{name}")
    run: Callable[[StudyContext], ThesisSection] = study.run
    return run
