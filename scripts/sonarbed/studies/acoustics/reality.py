"""A simulated hallway beside the log of a real one: silence and repeated values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import worlds
from sim import InTurn, PhysicalSonar, StatusPackets, Waypoints
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.drives import DriveSpec
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.acoustics.driving import timed_drive
from sonarbed.studies.acoustics.theory import physical
from sonarmap import SonarLog, mark_stale, ring

__all__ = ["REAL", "ROOM", "SECONDS", "LogShares", "as_real", "run", "shares_of"]


@dataclass(frozen=True)
class LogShares:
    """Shares of a log's readings, overall and by sonar.

    Parameters
    ----------
    lost, repeated : float
        Of all readings: without an echo, and equal to the packet before.
    lost_by_sonar, repeated_by_sonar : tuple of float
        The same of each sonar.
    """

    lost: float
    repeated: float
    lost_by_sonar: tuple[float, ...]
    repeated_by_sonar: tuple[float, ...]


# github.com/udacity/RoboND-OccupancyGridMappingAlgorithm, Data/measurement.txt and poses.txt at
# 5954edb: 413 rows of eight sonars, counted after import by the rules that count ours.
REAL = LogShares(
    0.331,
    0.670,
    (0.157, 0.317, 0.259, 0.433, 0.809, 0.308, 0.312, 0.051),
    (0.680, 0.596, 0.634, 0.697, 0.884, 0.600, 0.639, 0.632),
)

# The same log's rows are 214 ms apart and each sonar has a new value in every second row, so its
# ring takes 428 ms; its ranges are whole centimetres; its robot drives at 0.29 m/s. Times of the
# simulation are whole multiples of 5 ms.
_SLOT_S, _PACKET_S, _QUANTUM_M, _SPEED_MPS = 0.055, 0.215, 0.01, 0.29

ROOM = Path(__file__).with_name("hallway.toml")
"""The hallways of the real log, reconstructed from its ranges."""

SECONDS = (83.0, 20.0)
"""How long a drive is in the full page and in a quick one."""


def run(context: StudyContext) -> Section:
    """Drive along the hallways of the real log as its robot did."""
    return Section("reality", "Beside a real log", (_hallway(context),))


def as_real(sonar: PhysicalSonar, seconds: float, seed: int) -> DriveSpec:
    """Return the drive with the ring, the times and the steps of the real robot."""
    world = worlds.load(str(ROOM))
    return timed_drive(
        str(ROOM),
        sonar.replace(
            ring=ring("udacity8"),
            firing=InTurn(_SLOT_S),
            receiver=replace(sonar.receiver, quantum_m=_QUANTUM_M),
        ),
        seconds,
        seed=seed,
        packets=StatusPackets(_PACKET_S),
        driver=Waypoints(world.route_m, speed_mps=_SPEED_MPS),
    )


def shares_of(log: SonarLog) -> LogShares:
    """Return how much of a log is silence, and how much repeats."""
    lost, repeated = np.isposinf(log.range_m), mark_stale(log).stale

    def by_sonar(chosen: NDArray[np.bool_]) -> tuple[float, ...]:
        return tuple(float(chosen[log.sonar == k].mean()) for k in range(len(log.ring)))

    return LogShares(float(lost.mean()), float(repeated.mean()), by_sonar(lost), by_sonar(repeated))


def _hallway(context: StudyContext) -> Item:
    sonar = physical(context.sonar)
    seconds = SECONDS[context.quick]
    specs = [as_real(sonar, seconds, seed) for seed in range(1 if context.quick else 3)]
    logs = context.logs(specs, "driving along the hallway")
    each = [shares_of(log) for log in logs]
    ours = LogShares(
        float(np.mean([shares.lost for shares in each])),
        float(np.mean([shares.repeated for shares in each])),
        tuple(np.mean([shares.lost_by_sonar for shares in each], axis=0).tolist()),
        tuple(np.mean([shares.repeated_by_sonar for shares in each], axis=0).tolist()),
    )
    rows = [
        (name, _percent(mine), _percent(real), _points(mine - real))
        for (name, mine), real in zip(_rows_of(ours).items(), _rows_of(REAL).values(), strict=True)
    ]
    figure, panels = figure_with(1, 2, width=5.2, height=3.4, sharey=True)
    names = ("no echo", "repeated value")
    bearings = [f"{bearing:g}" for bearing in np.degrees(ring("udacity8").heading_rad)]
    for axes, name, mine, real in zip(
        panels,
        names,
        (ours.lost_by_sonar, ours.repeated_by_sonar),
        (REAL.lost_by_sonar, REAL.repeated_by_sonar),
        strict=True,
    ):
        place = np.arange(len(mine))
        axes.bar(place - 0.2, real, 0.38, color="#9A9A9A", label="real log")
        axes.bar(place + 0.2, mine, 0.38, color=COLOURS[0], label="simulated")
        axes.set(title=name, xlabel="the sonar's axis (degrees, left positive)", ylim=(0, 1))
        axes.set_xticks(place, bearings)
    panels[0].set_ylabel("share of the sonar's readings")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    front = slice(3, 5)
    return Item(
        "A hallway: silence and repeats",
        f"No theory but a real robot's log (RoboND-OccupancyGridMapping): {REAL.lost:.0%} of the "
        f"readings without echo, {min(REAL.lost_by_sonar):.0%} to {max(REAL.lost_by_sonar):.0%} by "
        f"sonar; {min(REAL.repeated_by_sonar):.0%} to {max(REAL.repeated_by_sonar):.0%} repeat the "
        "row before.",
        f"Simulated: {ours.lost:.0%} without echo, {min(ours.lost_by_sonar):.0%} to "
        f"{max(ours.lost_by_sonar):.0%} by sonar; {min(ours.repeated_by_sonar):.0%} to "
        f"{max(ours.repeated_by_sonar):.0%} repeats. Taken from the log: the sonars' directions, "
        f"one sonar every {1000 * _SLOT_S:.0f} ms, a row every {1000 * _PACKET_S:.0f} ms, whole "
        f"centimetres, {_SPEED_MPS:g} m/s, the hallways' widths and open ends. Set to get there: "
        f"door frames every 4 m and {sonar.receiver.dynamic_range_db:g} dB of dynamic range. "
        "The real transducers seem to differ more than ours: of its two front sonars one loses "
        f"{min(REAL.lost_by_sonar[front]):.0%} and one {max(REAL.lost_by_sonar[front]):.0%}, "
        f"{np.mean(REAL.lost_by_sonar[front]):.0%} together; ours lose "
        f"{min(ours.lost_by_sonar[front]):.0%} and {max(ours.lost_by_sonar[front]):.0%}, "
        f"{np.mean(ours.lost_by_sonar[front]):.0%} together.",
        (context.figure("hallway", figure, "Shares by sonar"),),
        (
            context.table(
                "hallway",
                ("share", "simulated", "real", "difference, points"),
                rows,
                f"The hallway; {len(logs)} {'drive' if len(logs) == 1 else 'drives'} of "
                f"{seconds:g} s",
            ),
        ),
    )


def _rows_of(shares: LogShares) -> dict[str, float]:
    return {
        "no echo, overall": shares.lost,
        "no echo, least of the sonars": min(shares.lost_by_sonar),
        "no echo, most of the sonars": max(shares.lost_by_sonar),
        "repeated, overall": shares.repeated,
        "repeated, least of the sonars": min(shares.repeated_by_sonar),
        "repeated, most of the sonars": max(shares.repeated_by_sonar),
    }


def _percent(share: float) -> str:
    return f"{share:.0%}"


def _points(difference: float) -> str:
    return f"{100 * difference:+.0f}"
