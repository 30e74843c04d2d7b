"""`Schedule`: all firings of a drive as arrays, for compiled code."""

from __future__ import annotations

from array import array
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.robot.clock import physics_steps
from sim.sonar.firing import Firing, pings

__all__ = ["Schedule", "schedule_of"]

# Longer schedules are not kept: of this one the numbers take 3 MB.
_MOST_KEPT_SCANS = 10_000


class Schedule(NamedTuple):
    """The firings of a drive in the order of time.

    A ping is a time at which some sonars fire together; a firing is one of those sonars.

    Parameters
    ----------
    scan : ndarray of int, shape (scans,)
        Numbers of the scans in which something fires.
    first_ping : ndarray of int, shape (scans + 1,)
        Where the pings of each scan begin.
    time_s : ndarray, shape (pings,)
        Time of each since the start.
    steps : ndarray of int, shape (pings,)
        Steps of the physics from the ping before; none are driven where it is not positive.
    first_firing : ndarray of int, shape (pings + 1,)
        Where the firings of each ping begin.
    sonar : ndarray of int, shape (firings,)
        Which sonar of the ring.
    """

    scan: NDArray[np.int64]
    first_ping: NDArray[np.int64]
    time_s: NDArray[np.float64]
    steps: NDArray[np.int64]
    first_firing: NDArray[np.int64]
    sonar: NDArray[np.int64]

    @property
    def firings_of_pings(self) -> NDArray[np.int64]:
        """How many sonars fire at each ping, shape (pings,)."""
        return np.diff(self.first_firing)

    @property
    def firings_of_scans(self) -> NDArray[np.int64]:
        """How many sonars fire in each scan, shape (scans,)."""
        return np.diff(self.first_firing[self.first_ping])


def schedule_of(firing: Firing, sonars: int, scans: int) -> Schedule:
    """Return the firings of so many scans of a ring of so many sonars."""
    if scans <= _MOST_KEPT_SCANS and _has_hash(firing):
        return _kept(firing, sonars, scans)  # type: ignore[arg-type]  # it has one
    return _made(firing, sonars, scans)


def _made(firing: Firing, sonars: int, scans: int) -> Schedule:
    # Long drives have many pings: nothing but numbers is kept of them.
    scan, time_s, steps = array("q"), array("d"), array("q")
    first_firing, sonar = array("q", [0]), array("q")
    for ping in pings(firing, sonars, scans=scans):
        scan.append(ping.scan)
        time_s.append(ping.time_s)
        steps.append(physics_steps(ping.time_s))
        sonar.extend(ping.sonars)
        first_firing.append(len(sonar))
    of_scans, first_ping = np.unique(np.array(scan, np.int64), return_index=True)
    return Schedule(
        of_scans,
        np.append(first_ping, len(scan)),
        np.array(time_s, float),
        np.diff(steps, prepend=0).astype(np.int64),
        np.array(first_firing, np.int64),
        np.array(sonar, np.int64),
    )


# Many drives have the same one.
_kept = lru_cache(maxsize=16)(_made)


def _has_hash(firing: Firing) -> bool:
    """Return whether a schedule has a hash; a person's own need not."""
    try:
        hash(firing)
    except TypeError:
        return False
    return True
