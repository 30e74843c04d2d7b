"""What a reading filter is, and what it returns: readings changed, rejected or doubted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sonarmap.errors import InputError
from sonarmap.log import Cause, SonarLog
from sonarmap.parameters import Space

__all__ = ["Filtered", "ReadingFilter"]


@dataclass(frozen=True, eq=False)
class Filtered:
    """What a filter made of the n readings of a log.

    Parameters
    ----------
    log : SonarLog
        The log with changed readings, and with its columns ``stale``, ``rejected`` and ``doubt``
        as the filter left them; otherwise as it was.
    changed : array_like of bool, shape (n,)
        Which readings have another range than before.
    predicted_range_m : array_like, shape (n,), optional
        What the filter thinks the sonar should have read, metres; NaN for no opinion. None: the
        filter does not predict.
    likely_cause : array_like of int, shape (n,), optional
        The `Cause` that the filter thinks most likely; -1 for no opinion. None: it names none.
    report : object, optional
        The filter's own account of its work.
    """

    log: SonarLog
    changed: NDArray[np.bool_]
    predicted_range_m: NDArray[np.float64] | None = None
    likely_cause: NDArray[np.int8] | None = None
    report: Any = None

    def __post_init__(self) -> None:
        self._freeze("changed", self.changed, np.bool_)
        if self.predicted_range_m is not None:
            self._freeze("predicted_range_m", self.predicted_range_m, np.float64)
        if self.likely_cause is not None:
            self._freeze("likely_cause", self.likely_cause, np.int8)
            known = np.isin(self.likely_cause, [-1, *(cause.value for cause in Cause)])
            if not known.all():
                row = int(np.argmin(known))
                raise InputError(
                    f"likely_cause[{row}] must be -1 to {len(Cause) - 1}, "
                    f"got {self.likely_cause[row]}"
                )

    def _freeze(self, name: str, values: ArrayLike, dtype: Any) -> None:
        column = np.array(values, dtype=dtype)
        if column.shape != (len(self.log),):
            raise InputError(f"{name} must have shape ({len(self.log)},), got {column.shape}")
        column.flags.writeable = False
        object.__setattr__(self, name, column)

    @property
    def rejected(self) -> NDArray[np.bool_]:
        """Which readings are rejected, shape (n,)."""
        return self.log.rejected

    @property
    def doubt(self) -> NDArray[np.float64]:
        """Probability that a reading is wrong, shape (n,); NaN for no opinion."""
        return self.log.doubt


@runtime_checkable
class ReadingFilter(Protocol):
    """What judges or repairs the readings of a log: a frozen dataclass of its parameters.

    `name` is what `sonarmap.filter` and the command line call it, `source` one sentence on where
    it comes from; both are class variables.
    """

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def source(self) -> str:
        """Where it comes from."""

    def apply(self, log: SonarLog) -> Filtered:
        """Return what it makes of a log, which stays as it is.

        Stale and rejected readings are never used, changed or judged. What was rejected before
        stays so.
        """

    @classmethod
    def space(cls) -> Space:
        """Return what may be searched: ranges of parameters by their names."""
