"""A simulated corridor beside the log of a real one: silence and repeated values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim import StatusPackets
from sonarbed.acoustics.driving import Drive, drive
from sonarbed.acoustics.theory import physical
from sonarbed.studies.drawing import COLOURS, figure_with
from sonarbed.studies.section import Item, Section
from sonarbed.studies.setting import Setting
from sonarmap import SonarLog, mark_stale

__all__ = ["REAL", "SECONDS", "Shares", "run", "shares_of"]


@dataclass(frozen=True)
class Shares:
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
# 5954edb: 413 rows of eight sonars, counted after import by the rules that count ours. Its sonars
# look to -90, -37.5, ... +90 degrees, so they are compared as a whole and not one by one.
REAL = Shares(
    0.331,
    0.670,
    (0.157, 0.317, 0.259, 0.433, 0.809, 0.308, 0.312, 0.051),
    (0.680, 0.596, 0.634, 0.697, 0.884, 0.600, 0.639, 0.632),
)


SECONDS = (76.8, 20.0)
"""How long a drive is in the full page and in a quick one."""


def run(setting: Setting) -> Section:
    """Drive along the shipped corridor as the real robot did."""
    return Section("reality", "Beside a real log", (_corridor(setting),))


def shares_of(log: SonarLog) -> Shares:
    """Return how much of a log is silence, and how much is told again."""
    lost, repeated = np.isposinf(log.range_m), mark_stale(log).stale

    def by_sonar(chosen: NDArray[np.bool_]) -> tuple[float, ...]:
        return tuple(float(chosen[log.sonar == k].mean()) for k in range(len(log.ring)))

    return Shares(float(lost.mean()), float(repeated.mean()), by_sonar(lost), by_sonar(repeated))


def _corridor(setting: Setting) -> Item:
    sonar = physical(setting.sonar)
    packets = StatusPackets()
    seconds = SECONDS[setting.quick]
    tasks = [
        Drive("corridor", sonar, seconds, seed=seed, packets=packets)
        for seed in range(1 if setting.quick else 3)
    ]
    logs = setting.map(drive, tasks, "driving along the corridor")
    each = [shares_of(log) for log in logs]
    ours = Shares(
        float(np.mean([shares.lost for shares in each])),
        float(np.mean([shares.repeated for shares in each])),
        tuple(np.mean([shares.lost_by_sonar for shares in each], axis=0).tolist()),
        tuple(np.mean([shares.repeated_by_sonar for shares in each], axis=0).tolist()),
    )
    rows = [
        (
            name,
            _percent(value(ours)),
            _percent(value(REAL)),
            _points(value(ours) - value(REAL)),
        )
        for name, value in (
            ("no echo, overall", lambda s: s.lost),
            ("no echo, least of the sonars", lambda s: min(s.lost_by_sonar)),
            ("no echo, most of the sonars", lambda s: max(s.lost_by_sonar)),
            ("repeated, overall", lambda s: s.repeated),
            ("repeated, least of the sonars", lambda s: min(s.repeated_by_sonar)),
            ("repeated, most of the sonars", lambda s: max(s.repeated_by_sonar)),
        )
    ]
    receiver = sonar.receiver
    first, second = sonar.firing.slots(0, len(sonar.ring))[:2]
    slot_ms = 1000 * (second.offset_s - first.offset_s)
    figure, panels = figure_with(1, 2, width=5.2, height=3.4, sharey=True)
    names = ("no echo", "repeated value")
    for axes, name, mine, real in zip(
        panels,
        names,
        (ours.lost_by_sonar, ours.repeated_by_sonar),
        (REAL.lost_by_sonar, REAL.repeated_by_sonar),
        strict=True,
    ):
        place = np.arange(1, len(mine) + 1)
        axes.bar(place - 0.2, sorted(real), 0.38, color="#9A9A9A", label="real log")
        axes.bar(place + 0.2, sorted(mine), 0.38, color=COLOURS[0], label="simulated")
        axes.set(title=name, xlabel="sonars, from the least to the most", ylim=(0, 1))
        axes.set_xticks(place)
    panels[0].set_ylabel("share of the sonar's readings")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return Item(
        "A corridor: silence and repeats",
        f"No theory but a real robot's log (RoboND-OccupancyGridMapping): {REAL.lost:.0%} of the "
        f"readings without echo, {min(REAL.lost_by_sonar):.0%} to {max(REAL.lost_by_sonar):.0%} by "
        f"sonar; {min(REAL.repeated_by_sonar):.0%} to {max(REAL.repeated_by_sonar):.0%} repeat the "
        "packet before.",
        f"Simulated: {ours.lost:.0%} without echo, {min(ours.lost_by_sonar):.0%} to "
        f"{max(ours.lost_by_sonar):.0%} by sonar; {min(ours.repeated_by_sonar):.0%} to "
        f"{max(ours.repeated_by_sonar):.0%} repeats. Set to get there: the room's carved frames, "
        f"{receiver.dynamic_range_db:g} dB of dynamic range with {receiver.gain_share:.0%} of the "
        f"loss by distance taken back, one sonar every {slot_ms:.0f} ms, "
        f"a packet every {1000 * packets.period_s:.0f} ms. Against the real "
        f"log: {_points(ours.lost - REAL.lost)} points of silence, "
        f"{_points(max(ours.lost_by_sonar) - max(REAL.lost_by_sonar))} for the most silent sonar, "
        f"{_points(ours.repeated - REAL.repeated)} of repeats.",
        (setting.figure("corridor", figure, "Shares by sonar, sorted"),),
        (
            setting.table(
                "corridor",
                ("share", "simulated", "real", "difference, points"),
                rows,
                f"The corridor; {len(logs)} {'drive' if len(logs) == 1 else 'drives'} of "
                f"{seconds:g} s",
            ),
        ),
    )


def _percent(share: float) -> str:
    return f"{share:.0%}"


def _points(difference: float) -> str:
    return f"{100 * difference:+.0f}"
