"""`Job`: one piece of work, and what became of it."""

from __future__ import annotations

import errno
import json
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256
from typing import Any, Protocol

from sim.runs.jobs.store import Store
from sonarmap.errors import InputError

__all__ = ["DIGITS", "Job", "JobFailure", "Outcome", "attempt", "digest_of"]

DIGITS = 12
"""Digits of a digest in a file's name: those of a million jobs differ with a chance of 99.8 %."""
# A store in such a state fails every job that follows, too.
_HOPELESS = {errno.ENOSPC, errno.EDQUOT, errno.EROFS}


class Job(Protocol):
    """One piece of work: a frozen value that pickles."""

    @property
    def label(self) -> str:
        """What messages call it, with its seed: "office-000017, seed 3"."""

    @property
    def description(self) -> Mapping[str, Any]:
        """All that decides its outputs, as JSON-able values."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the files that it writes, as ``folder/name``.

        They hold the digest of the description: a file of that name is the whole output of this
        very job. It is complete when all are there.
        """

    def run(self, store: Store) -> int:
        """Write the outputs by `Store.writing`; return how many readings they took."""


@dataclass(frozen=True)
class JobFailure:
    """A job that could not be done.

    Parameters
    ----------
    label : str
        What messages call the job.
    description : mapping
        All that decides its outputs, its seed included.
    error : str
        What went wrong, one line.
    details : str
        The traceback; empty for bad input, whose line says all, and for a worker that died.
    """

    label: str
    description: Mapping[str, Any]
    error: str
    details: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return it as JSON-able values."""
        return {
            "job": self.label,
            "error": self.error,
            "description": dict(self.description),
            "details": self.details,
        }


@dataclass(frozen=True)
class Outcome:
    """What became of a job; plain values, so that it comes back from any process.

    Parameters
    ----------
    readings : int
        How many readings its outputs took.
    error : str or None
        What went wrong, one line; None if nothing did.
    details : str
        The traceback.
    is_hopeless : bool
        Whether no other job will fare better: the disk is full.
    """

    readings: int = 0
    error: str | None = None
    details: str = ""
    is_hopeless: bool = False


def attempt(job: Job, store: Store) -> Outcome:
    """Run a job and return what became of it, whatever it raised."""
    try:
        readings = job.run(store)
        missing = [name for name in job.outputs if not store.has(name)]
        if missing:
            raise RuntimeError(f"the job did not write {missing[0]!r}")
        return Outcome(readings)
    except InputError as error:
        return Outcome(error=_line(error), is_hopeless=_is_hopeless(error))
    except Exception as error:
        line = f"{type(error).__name__}: {_line(error)}"
        return Outcome(error=line, details=traceback.format_exc(), is_hopeless=_is_hopeless(error))


def digest_of(description: Mapping[str, Any]) -> str:
    """Return the digest of JSON-able values, the same in every process."""
    text = json.dumps(description, sort_keys=True, separators=(",", ":"))
    return sha256(text.encode()).hexdigest()


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())


def _is_hopeless(error: BaseException | None) -> bool:
    """Return whether an error, or one that it came of, is that of a full disk."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in _HOPELESS:
            return True
        error = error.__cause__ or error.__context__
    return False
