"""The filter that does nothing: what every other one must beat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from sonarmap.filters.protocol import Filtered
from sonarmap.log import SonarLog
from sonarmap.parameters import Space

__all__ = ["NoFilter"]


@dataclass(frozen=True)
class NoFilter:
    """The identity: it changes, rejects and doubts nothing."""

    name: ClassVar[str] = "none"
    source: ClassVar[str] = "Ours: the floor under every filter."

    def apply(self, log: SonarLog) -> Filtered:
        """Return the log as it is."""
        return Filtered(log, np.zeros(len(log), bool))

    @classmethod
    def space(cls) -> Space:
        """Return nothing: it has no parameters."""
        return {}
