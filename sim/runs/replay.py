"""`replay`: a log's readings taken again by simulated sonars, from the log's own poses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sim.engines.opening import open_engine
from sim.runs.motion import transducers
from sim.runs.recorder import Recorder
from sim.sonar import presets as sonars
from sim.sonar.carried import carrying
from sim.sonar.firing import fitted
from sim.sonar.physical.sonar import PhysicalSonar
from sim.sonar.physical.spread import TransducerSpread
from sim.sonar.protocol import Sonar, SonarArray, from_sonars
from sonarmap import Cause, InputError, SonarLog
from sonarmap.account import ReadingAccount, account_of
from sonarmap.errors import instance, one_of, whole
from worlds import Pose, World

__all__ = ["CLOSE_M", "Replay", "replay"]

CLOSE_M = (0.05, 0.10, 0.20)
"""Two ranges are called alike within these, metres."""


@dataclass(frozen=True)
class Replay:
    """The readings of a log beside those that simulated sonars take at the same poses.

    Parameters
    ----------
    log : SonarLog
        The readings that are compared: neither stale nor rejected.
    simulated : SonarLog
        The same rows with simulated ranges and their truth.
    account : ReadingAccount
        How many readings the whole log has, and why the others are not compared.
    poses : {"true", "odometry"}
        Where the sonars were taken to be.
    """

    log: SonarLog
    simulated: SonarLog
    account: ReadingAccount
    poses: str

    @cached_property
    def silent(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which readings have no echo: of the log, and simulated, shape (n,) each."""
        return self.log.range_m == np.inf, self.simulated.range_m == np.inf

    @cached_property
    def both_measured(self) -> NDArray[np.bool_]:
        """Which readings are a range in both, shape (n,)."""
        both: NDArray[np.bool_] = np.isfinite(self.log.range_m) & np.isfinite(
            self.simulated.range_m
        )
        return both

    @property
    def agreement(self) -> float:
        """Share of the readings that are an echo in both, or silence in both; NaN for none."""
        real, simulated = self.silent
        return float(np.mean(real == simulated)) if real.size else math.nan

    def within(self, close_m: float) -> float:
        """Return the share of the readings with a range in both that differ by no more than so.

        Parameters
        ----------
        close_m : float
            How much, metres.
        """
        return (
            float(np.mean(self._difference_m <= close_m)) if self._difference_m.size else math.nan
        )

    def silence_by_sonar(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return each sonar's share of readings without echo: of the log, and simulated.

        NaN for a sonar without readings; shape (sonars,) each.
        """
        k = len(self.log.ring)
        fired = np.bincount(self.log.sonar, minlength=k)
        real, simulated = (
            np.bincount(self.log.sonar[silent], minlength=k) / np.where(fired, fired, np.nan)
            for silent in self.silent
        )
        return real, simulated

    def disagreements(self, close_m: float = CLOSE_M[-1]) -> dict[str, dict[str, int]]:
        """Return how many readings differ in which way, by the cause of the simulated reading.

        The cause is the likely one: of the echo that the log lacks, or of that which it has
        instead of another.

        Parameters
        ----------
        close_m : float
            Ranges that differ by more than this differ, metres.
        """
        real, simulated = self.silent
        log_m, simulated_m = self.log.range_m, self.simulated.range_m
        measured = ~real & ~simulated
        # Too close is nearer than any range.
        with np.errstate(invalid="ignore"):
            off_m = np.where(log_m == simulated_m, 0.0, log_m - simulated_m)
        ways = {
            "silent_but_simulated_echo": real & ~simulated,
            "echo_but_simulated_silent": ~real & simulated,
            "shorter_than_simulated": measured & (off_m < -close_m),
            "longer_than_simulated": measured & (off_m > close_m),
        }
        causes = self.simulated.require_truth("causes").cause
        counts = {}
        for way, chosen in ways.items():
            found = np.bincount(causes[chosen], minlength=len(Cause))
            counts[way] = {cause.name: int(found[cause]) for cause in Cause if found[cause]}
        return counts

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as JSON-able values."""
        real, simulated = self.silent
        by_sonar = self.silence_by_sonar()
        return {
            "account": self.account.to_dict(),
            "poses": self.poses,
            "silent": {"log": int(real.sum()), "simulated": int(simulated.sum())},
            "silence_by_sonar": {
                "log": by_sonar[0].tolist(),
                "simulated": by_sonar[1].tolist(),
            },
            "agreement": self.agreement,
            "both_measured": int(self.both_measured.sum()),
            "within": {f"{close_m:g}": self.within(close_m) for close_m in CLOSE_M},
            "disagreements": self.disagreements(),
        }

    @cached_property
    def _difference_m(self) -> NDArray[np.float64]:
        both = self.both_measured
        difference: NDArray[np.float64] = np.abs(
            self.log.range_m[both] - self.simulated.range_m[both]
        )
        return difference


def replay(
    log: SonarLog,
    world: World,
    *,
    sonar: str | Sonar = "physical",
    seed: int = 0,
    poses: Literal["auto", "true", "odometry"] = "auto",
    engine: str = "segments",
) -> Replay:
    """Fire simulated sonars at the poses and times of a log, and set their readings beside its own.

    Parameters
    ----------
    log : SonarLog
        Of a real robot or a simulated one, in the frame of the room (`worlds.align` finds it).
        Stale and rejected readings are not compared.
    world : World
        The room as it was measured.
    sonar : str or Sonar
        The acoustics, see `simulate`; the ring is the log's. Nobody knows how its transducers
        differ: they are all alike unless the sonar's `spread` has a seed.
    seed : int
        Of the noise, >= 0.
    poses : {"auto", "true", "odometry"}
        Where the robot was: by the truth of a simulated log, or by odometry. "auto": by the truth
        where there is one.
    engine : str
        What casts the rays, see `simulate`.

    Returns
    -------
    Replay

    Raises
    ------
    InputError
        If nothing in the log can be compared, or an argument breaks its rule.

    Notes
    -----
    Sonars that the log has at one time fire at once if the simulated ring fires so many together;
    else the log tells when it heard of them and not when they fired, as status packets do, and they
    fire each for itself, without the sound of the others.
    """
    instance("log", log, SonarLog)
    instance("world", world, World)
    whole("seed", seed, least=0)
    one_of("poses", poses, ("auto", "true", "odometry"))
    is_true = poses == "true" or (poses == "auto" and log.truth is not None)
    used = log.select(log.usable)
    if not len(used):
        raise InputError("log must have readings that are neither stale nor rejected, got none")
    where = used.at_true_poses() if is_true else used
    heard = _nominal(carrying(sonars.of(sonar), log.ring))
    recorder = Recorder(log.ring, world)
    rng = np.random.default_rng(seed)
    with open_engine(engine, world) as robot:
        _fire_all(where, world, heard, heard.array(robot, world, rng), recorder, robot, rng)
    provenance = {"world": world.name, "sonar": heard.name, "seed": seed, "replay": True}
    simulated = recorder.log(provenance)
    return Replay(
        log=used,
        simulated=simulated.replace(x_m=used.x_m, y_m=used.y_m, heading_rad=used.heading_rad),
        account=account_of(log, log.usable),
        poses="true" if is_true else "odometry",
    )


def _nominal(sonar: Sonar) -> Sonar:
    """Return a sonar with nominal transducers, unless it says which ones it has."""
    if isinstance(sonar, PhysicalSonar) and sonar.spread.seed is None:
        return sonar.replace(spread=TransducerSpread(0.0, 0.0))
    return sonar


def _fire_all(
    log: SonarLog,
    world: World,
    sonar: Sonar,
    array: SonarArray,
    recorder: Recorder,
    rays: Any,
    rng: np.random.Generator,
) -> None:
    """Fire every reading of a log and record it."""
    slots = fitted(sonar.firing, len(log.ring)).slots(0, len(log.ring))
    together = max(len(slot.sonars) for slot in slots)
    for rows in _runs(log.scan):
        waiting = False
        for at in _firings(log, rows):
            pose = Pose(float(log.x_m[at[0]]), float(log.y_m[at[0]]), float(log.heading_rad[at[0]]))
            time_s, fired = float(log.time_s[at[0]]), tuple(int(k) for k in log.sonar[at])
            places, axes = transducers(log.ring, pose)
            recorder.fired(int(log.scan[at[0]]), time_s, fired, pose, pose)
            if len(fired) <= together:
                array.fire(time_s, fired, places, axes)
                waiting = True
                continue
            if waiting:
                recorder.detected(array.detect(), touched=False)
                waiting = False
            chosen = list(fired)
            echoes = sonar.listen(rays, world, places[chosen], axes[chosen], rng)
            recorder.detected(from_sonars(echoes, fired), touched=False)
        if waiting:
            recorder.detected(array.detect(), touched=False)


def _runs(values: NDArray[Any]) -> Iterator[slice]:
    """Yield the stretches of equal values."""
    ends = np.flatnonzero(np.diff(values)) + 1
    for first, last in zip([0, *ends], [*ends, values.size], strict=True):
        yield slice(int(first), int(last))


def _firings(log: SonarLog, rows: slice) -> Iterator[NDArray[np.intp]]:
    """Yield the rows that were taken at one time from one pose, no sonar twice."""
    begin = rows.start
    seen: set[int] = set()
    for row in range(rows.start, rows.stop):
        first = log.time_s[begin], log.x_m[begin], log.y_m[begin], log.heading_rad[begin]
        here = log.time_s[row], log.x_m[row], log.y_m[row], log.heading_rad[row]
        if here != first or int(log.sonar[row]) in seen:
            yield np.arange(begin, row)
            begin, seen = row, set()
        seen.add(int(log.sonar[row]))
    yield np.arange(begin, rows.stop)
