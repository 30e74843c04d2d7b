"""`Pipeline`: filters and a method, which together make a map of a log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sonarmap.errors import InputError
from sonarmap.filters.choosing import as_filter
from sonarmap.filters.protocol import Filtered, ReadingFilter
from sonarmap.grid import GridSpec
from sonarmap.log import SonarLog
from sonarmap.methods.choosing import as_method
from sonarmap.methods.protocol import MappingMethod
from sonarmap.occupancy import OccupancyMap

__all__ = ["Pipeline", "apply_all"]


@dataclass(frozen=True)
class Pipeline:
    """Reading filters, one after the other, and a mapping method after them.

    Parameters
    ----------
    filters : sequence of ReadingFilter
        Filters, or functions of a log. Each gets the log as the one before it left it, and what
        any of them rejects stays rejected.
    method : MappingMethod
        A method, or a function of a log and a grid.
    """

    filters: tuple[ReadingFilter, ...]
    method: MappingMethod

    def __init__(self, filters: Sequence[Any], method: Any) -> None:
        object.__setattr__(self, "filters", tuple(as_filter(each) for each in filters))
        object.__setattr__(self, "method", as_method(method))

    @property
    def name(self) -> str:
        """The names of its parts in their order: "hsr + bayes-standard"."""
        return " + ".join([*(each.name for each in self.filters), self.method.name])

    def apply(self, log: SonarLog) -> Filtered:
        """Return what the filters together make of a log, see `apply_all`."""
        return apply_all(self.filters, log)

    def map(self, log: SonarLog, grid: GridSpec) -> OccupancyMap:
        """Return the map that the method makes of the filtered log."""
        return self.method.map(self.apply(log).log, grid)


def apply_all(filters: Sequence[ReadingFilter], log: SonarLog) -> Filtered:
    """Return what filters, one after the other, make of a log.

    Returns
    -------
    Filtered
        Of the whole chain: a reading is changed if it ends as another than it began, and rejected
        if any filter rejects it. Of doubts, predictions and likely causes the last opinion counts.
        The report is a tuple, one a filter.

    Raises
    ------
    InputError
        If a filter returns a log of other readings.
    """
    now, reports = log, []
    predicted_m, likely_cause = None, None
    for each in filters:
        made = each.apply(now)
        if len(made.log) != len(log):
            raise InputError(
                f"filter {each.name!r} must return a log of {len(log)} readings, "
                f"got {len(made.log)}"
            )
        doubt = np.where(np.isnan(made.log.doubt), now.doubt, made.log.doubt)
        rejected = now.rejected | made.log.rejected
        now = made.log.replace(rejected=rejected, doubt=doubt)
        reports.append(made.report)
        if made.predicted_range_m is not None:
            earlier = np.nan if predicted_m is None else predicted_m
            unsure = np.isnan(made.predicted_range_m)
            predicted_m = np.where(unsure, earlier, made.predicted_range_m)
        if made.likely_cause is not None:
            earlier = -1 if likely_cause is None else likely_cause
            likely_cause = np.where(made.likely_cause < 0, earlier, made.likely_cause)
    return Filtered(now, now.range_m != log.range_m, predicted_m, likely_cause, tuple(reports))
