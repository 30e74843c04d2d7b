"""When the sonars of a ring fire: all at once, in turn, or with EERUF's alternating delays."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, NamedTuple, Protocol

from sim.robot.clock import check_steps
from sonarmap import InputError
from sonarmap.errors import non_negative, positive, whole

__all__ = [
    "AllAtOnce",
    "Eeruf",
    "Firing",
    "InTurn",
    "Ping",
    "Slot",
    "check_firing",
    "fitted",
    "pings",
]


class _WholeRing(tuple[int, ...]):
    """The order in which all sonars of a ring fire, whatever their number; else a plain tuple."""

    __slots__ = ()

    @classmethod
    def of(cls, sonars: int) -> _WholeRing:
        return cls(range(sonars))


# Of the AmigoBot's eight sonars until the schedule meets another ring.
_IN_ORDER = _WholeRing.of(8)


@dataclass(frozen=True, slots=True)
class Slot:
    """Sonars that fire at the same time of a scan.

    Parameters
    ----------
    offset_s : float
        Time since the scan began.
    sonars : tuple of int
        Their numbers in the ring.
    """

    offset_s: float
    sonars: tuple[int, ...]


class Ping(NamedTuple):
    """One firing of a schedule: sonars that fire at the same time.

    Parameters
    ----------
    scan : int
        In which scan.
    offset_s : float
        Time since the scan began.
    time_s : float
        Time since the first scan began.
    sonars : tuple of int
        Their numbers in the ring.
    """

    scan: int
    offset_s: float
    time_s: float
    sonars: tuple[int, ...]


class Firing(Protocol):
    """The times at which the sonars of a ring fire; `pings` walks through them."""

    @property
    def period_s(self) -> float:
        """Time from the begin of a scan to that of the next, seconds."""

    @property
    def listening_s(self) -> float:
        """How long a sonar that has fired listens at most, seconds."""

    def slots(self, scan: int, sonars: int) -> tuple[Slot, ...]:
        """Return the slots of a scan of a ring of so many sonars, in the order of time."""

    def check(self, sonars: int) -> None:
        """Raise `InputError` if the schedule does not fit a ring of so many sonars."""


def pings(firing: Firing, sonars: int, *, scans: int | None = None) -> Iterator[Ping]:
    """Yield the firings of a ring in the order of time.

    Parameters
    ----------
    firing : Firing
        The schedule; without an order of its own it is that of all sonars, see `fitted`.
    sonars : int
        How many sonars the ring has.
    scans : int, optional
        Of so many scans, counted from 0; by default for ever.
    """
    firing = fitted(firing, sonars)
    for scan in count() if scans is None else range(scans):
        begin_s = scan * firing.period_s
        for slot in firing.slots(scan, sonars):
            yield Ping(scan, slot.offset_s, begin_s + slot.offset_s, slot.sonars)


def fitted(firing: Firing, sonars: int) -> Firing:
    """Return the schedule of a ring: one that was given no order takes all sonars in turn.

    Parameters
    ----------
    firing : Firing
        The schedule.
    sonars : int
        How many sonars the ring has.

    Raises
    ------
    InputError
        If it does not fit: its order names a sonar that is not there, or its times are too short
        for so many.
    """
    if isinstance(getattr(firing, "order", None), _WholeRing):
        firing = replace(firing, order=_of_ring(firing.order, sonars))  # type: ignore[type-var, attr-defined]
    firing.check(sonars)
    return firing


def check_firing(firing: Firing, sonars: int) -> None:
    """Raise `InputError` if a ring of so many sonars cannot fire between steps of the physics."""
    firing = fitted(firing, sonars)
    check_steps("scan_period_s", firing.period_s)
    # Two scans: EERUF's delays alternate.
    offsets = {ping.offset_s for ping in pings(firing, sonars, scans=2)}
    for offset_s in sorted(offsets - {0.0}):
        check_steps("the time between firings", offset_s)


@dataclass(frozen=True)
class AllAtOnce:
    """Every sonar fires at the begin of the scan.

    Parameters
    ----------
    period_s : float
        Time from one scan to the next, seconds, > 0.
    """

    period_s: float

    def __post_init__(self) -> None:
        positive("period_s", self.period_s)

    @property
    def listening_s(self) -> float:
        """How long a sonar that has fired listens at most, seconds."""
        return self.period_s

    def slots(self, scan: int, sonars: int) -> tuple[Slot, ...]:
        """Return the one slot of a scan."""
        return (Slot(0.0, tuple(range(sonars))),)

    def check(self, sonars: int) -> None:
        """Accept a ring of any size."""


@dataclass(frozen=True)
class InTurn:
    """One sonar after the other; each listens until the next one fires.

    Parameters
    ----------
    slot_s : float
        Time from one firing to the next, seconds, > 0. The Pioneers' sonar board needs 40 ms by
        default, 320 ms for a ring of eight, and can be set to 2 to 120 ms (Pioneer 3 manual,
        p. 34; taken over for the AmigoBot).
    order : tuple of int
        Numbers of the sonars as they fire; as on the board some may be left out or come twice.
        By default all sonars of the ring, whatever their number; eight until it meets a ring.
    """

    slot_s: float = 0.040
    order: tuple[int, ...] = _IN_ORDER

    def __post_init__(self) -> None:
        positive("slot_s", self.slot_s)
        object.__setattr__(self, "order", _checked_order(self.order))

    @property
    def period_s(self) -> float:
        """Time from the begin of a scan to that of the next, seconds."""
        return self.slot_s * len(self.order)

    @property
    def listening_s(self) -> float:
        """How long a sonar that has fired listens at most, seconds."""
        return self.slot_s

    def slots(self, scan: int, sonars: int) -> tuple[Slot, ...]:
        """Return a slot for each sonar of the order."""
        order = _of_ring(self.order, sonars)
        return tuple(Slot(i * self.slot_s, (sonar,)) for i, sonar in enumerate(order))

    def check(self, sonars: int) -> None:
        """Raise `InputError` if the order names a sonar that the ring does not have."""
        _checked_order(_of_ring(self.order, sonars), sonars)


@dataclass(frozen=True)
class Eeruf:
    """Sonars fire in quick succession, each after one of two delays, scan by scan in turn.

    Between two scans the delays of two sonars change differently, so what a sonar detects
    of another's sound moves by the difference, while its own echoes stay where they are:
    `sonarmap.eeruf_accepts` keeps readings that agree with a neighbour in time. After Borenstein
    and Koren, "Error Eliminating Rapid Ultrasonic Firing for Mobile Robot Obstacle Avoidance",
    IEEE Transactions on Robotics and Automation 11(1), 1995.

    Parameters
    ----------
    period_s : float
        Time from one scan to the next, seconds, > 0; the paper gives 60 to 100 ms for eight to
        twelve sonars.
    lag_even_s, lag_odd_s : float
        Time from one sonar to the next in even and in odd scans, seconds, >= 0, not equal. The
        cross-talk of the n-th neighbour moves by n times their difference: with 5 ms a range
        changes by 0.86 m. The numbers are assumed.
    order : tuple of int
        Numbers of the sonars as they fire, none twice. By default all sonars of the ring, whatever
        their number; eight until it meets a ring.
    """

    period_s: float = 0.100
    lag_even_s: float = 0.010
    lag_odd_s: float = 0.005
    order: tuple[int, ...] = _IN_ORDER

    def __post_init__(self) -> None:
        positive("period_s", self.period_s)
        non_negative("lag_even_s", self.lag_even_s)
        non_negative("lag_odd_s", self.lag_odd_s)
        if math.isclose(self.lag_even_s, self.lag_odd_s):
            raise InputError(
                f"lag_odd_s must differ from lag_even_s, got {self.lag_odd_s!r} for both"
            )
        object.__setattr__(self, "order", _checked_order(self.order))
        if len(set(self.order)) != len(self.order):
            raise InputError(f"order must name no sonar twice, got {self.order!r}")
        if self.listening_s <= 0:
            raise InputError(
                f"period_s must be longer than the {len(self.order) - 1} lags of a scan, "
                f"got {self.period_s!r}"
            )

    @property
    def listening_s(self) -> float:
        """How long a sonar that has fired listens at most, seconds: to the end of the scan."""
        return self.period_s - (len(self.order) - 1) * max(self.lag_even_s, self.lag_odd_s)

    def slots(self, scan: int, sonars: int) -> tuple[Slot, ...]:
        """Return a slot for each sonar of the order, closer in odd scans or in even ones."""
        lag_s = self.lag_odd_s if scan % 2 else self.lag_even_s
        order = _of_ring(self.order, sonars)
        return tuple(Slot(i * lag_s, (sonar,)) for i, sonar in enumerate(order))

    def check(self, sonars: int) -> None:
        """Raise `InputError` if the order names a sonar that the ring does not have."""
        _checked_order(_of_ring(self.order, sonars), sonars)


def _of_ring(order: tuple[int, ...], sonars: int) -> tuple[int, ...]:
    """Return the order as a ring of so many sonars has it."""
    return _WholeRing.of(sonars) if isinstance(order, _WholeRing) else order


def _checked_order(order: Any, sonars: int | None = None) -> tuple[int, ...]:
    """Return an order of whole numbers, all of the ring's if their number is known."""
    if isinstance(order, str) or not hasattr(order, "__len__"):
        raise InputError(f"order must be the numbers of sonars, got {order!r}")
    if not len(order):
        raise InputError("order must name at least one sonar, got none")
    numbers = tuple(whole(f"order[{place}]", sonar) for place, sonar in enumerate(order))
    for place, sonar in enumerate(numbers):
        if sonar < 0 or (sonars is not None and sonar >= sonars):
            rule = ">= 0" if sonars is None else f"0 to {sonars - 1}"
            raise InputError(f"order[{place}] must be {rule}, got {sonar!r}")
    return order if isinstance(order, _WholeRing) else numbers
