"""Cross-talk: how often a sonar hears another one's sound, by the way in which they fire."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim import AllAtOnce, Eeruf, Firing, InTurn
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.acoustics.driving import timed_drive
from sonarbed.studies.acoustics.theory import physical
from sonarmap import Cause, SonarLog, eeruf_accepts
from worlds.colours import CAUSE_COLOURS

__all__ = ["SCHEMES", "SECONDS", "run"]

SCHEMES: dict[str, Firing] = {
    "all at once, every 100 ms": AllAtOnce(0.100),
    "in turn, every 40 ms": InTurn(),
    "EERUF, every 100 ms": Eeruf(),
}
_ROOMS = ("corridor", "office", "clutter")
SECONDS = (30.0, 10.0)
"""How long a drive is in the full page and in a quick one."""
# The sonar of the picture: front left, whose neighbours look aside by 30 and 26 degrees.
_SHOWN_ROOM, _SHOWN_SONAR = "office", 2


def run(context: StudyContext) -> Section:
    """Drive with three ways of firing."""
    return Section("crosstalk", "Cross-talk", (_schemes(context),))


def _schemes(context: StudyContext) -> Item:
    sonar = physical(context.sonar)
    seconds = SECONDS[context.quick]
    keys = [(room, scheme) for room in _ROOMS for scheme in SCHEMES]
    specs = [
        timed_drive(room, sonar.replace(firing=SCHEMES[scheme]), seconds) for room, scheme in keys
    ]
    logs = dict(zip(keys, context.logs(specs, "driving with three firings"), strict=True))
    rows = []
    for (room, scheme), log in logs.items():
        cross, right = _is(log)
        tested = ("-", "-")
        if isinstance(SCHEMES[scheme], Eeruf):
            kept = eeruf_accepts(log)
            tested = (f"{_share(~kept[cross]):.1%}", f"{_share(kept[right]):.1%}")
        rows.append((room, scheme, len(log), f"{cross.mean():.1%}", *tested))
    figure, panels = figure_with(1, 3, width=4.4, height=3.6, sharey=True)
    for axes, scheme in zip(panels, SCHEMES, strict=True):
        log = logs[_SHOWN_ROOM, scheme]
        cross, right = _is(log)
        mine = log.sonar == _SHOWN_SONAR
        heard = np.isfinite(log.range_m)
        kinds = (
            ("right", right, COLOURS[0], "."),
            ("other errors", ~right & ~cross, CAUSE_COLOURS[Cause.BOUNCE], "x"),
            ("cross-talk", cross, CAUSE_COLOURS[Cause.CROSSTALK], "v"),
        )
        for label, chosen, colour, marker in kinds:
            rows_of = mine & heard & chosen
            axes.plot(log.time_s[rows_of], log.range_m[rows_of], marker, color=colour, ms=4,
                      ls="none", label=label)  # fmt: skip
        axes.set_title(f"{scheme}: {cross[mine].mean():.0%} cross-talk", fontsize=10)
        axes.set(xlabel="time, s", ylim=(0, None), xlim=(0, seconds))
    panels[0].set_ylabel("range, m")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    shares = {scheme: [_is(logs[room, scheme])[0].mean() for room in _ROOMS] for scheme in SCHEMES}
    by_scheme = "; ".join(
        f"{scheme}: {min(values):.0%}"
        + (f" to {max(values):.0%}" if max(values) > min(values) else "")
        for scheme, values in shares.items()
    )
    pooled = [logs[room, scheme] for room, scheme in keys if isinstance(SCHEMES[scheme], Eeruf)]
    kept, cross, right = (
        np.concatenate(parts)
        for parts in zip(*((eeruf_accepts(log), *_is(log)) for log in pooled), strict=True)
    )
    return Item(
        "Three ways of firing",
        "Fired at once, a sonar takes its neighbour's sound for its own echo; fired one every "
        "40 ms it hears another's only by a way of more than 13.7 m; EERUF lets neighbours' sounds "
        "arrive at changing times, so that a comparison with the reading before rejects them.",
        f"Share of cross-talk in {len(_ROOMS)} rooms, {seconds:g} s each: {by_scheme}. EERUF's "
        f"test rejects {_share(~kept[cross]):.0%} of its cross-talk and keeps "
        f"{_share(kept[right]):.0%} of the right readings.",
        (
            context.figure(
                "schemes",
                figure,
                f"Readings of sonar {_SHOWN_SONAR} in {_SHOWN_ROOM}; no echo is not drawn",
            ),
        ),
        (
            context.table(
                "schemes",
                (
                    "room",
                    "firing",
                    "readings",
                    "cross-talk",
                    "of it rejected by EERUF's test",
                    "right readings kept",
                ),
                rows,
                "Cross-talk by room and firing",
            ),
        ),
    )


def _is(log: SonarLog) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which readings are cross-talk, and which are right."""
    cause = log.require_truth("counting causes").cause
    return cause == Cause.CROSSTALK, np.isin(cause, [c for c in Cause if c.is_right])


def _share(chosen: NDArray[np.bool_]) -> float:
    return float(chosen.mean()) if chosen.size else float("nan")
