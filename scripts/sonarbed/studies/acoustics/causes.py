"""What readings come from, counted by room and sonar."""

from __future__ import annotations

import numpy as np

from sim.sonar.presets import PRESETS
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.reporting.wording import cause_name
from sonarbed.studies.acoustics.driving import timed_drive
from sonarmap import Cause
from worlds.colours import CAUSE_COLOURS

__all__ = ["ROOMS", "SECONDS", "run"]

ROOMS = ("thesis-exp1", "corridor", "office", "clutter")
SECONDS = (40.0, 12.0)
"""How long a drive is in the full page and in a quick one."""
# Room for a share's number in its bar.
_WORTH_A_NUMBER = 0.06


def run(context: StudyContext) -> Section:
    """Drive in each room with each sonar."""
    return Section("causes", "Causes of readings", (_causes(context),))


def _causes(context: StudyContext) -> Item:
    seconds = SECONDS[context.quick]
    keys = [(room, name) for room in ROOMS for name in PRESETS]
    specs = [timed_drive(room, PRESETS[name], seconds) for room, name in keys]
    logs = context.logs(specs, "driving with each sonar")
    shares = {
        key: np.bincount(log.require_truth("counting causes").cause, minlength=len(Cause))
        / len(log)
        for key, log in zip(keys, logs, strict=True)
    }
    figure, panels = figure_with(1, len(ROOMS), width=3.1, height=4.2, sharey=True)
    for axes, room in zip(panels, ROOMS, strict=True):
        bottom = np.zeros(len(PRESETS))
        for cause in Cause:
            height = np.array([shares[room, name][cause] for name in PRESETS])
            axes.bar(list(PRESETS), height, bottom=bottom, color=CAUSE_COLOURS[cause], width=0.75,
                     label=cause_name(cause), ec="white", lw=0.5)  # fmt: skip
            for place, (h, b) in enumerate(zip(height, bottom, strict=True)):
                if h >= _WORTH_A_NUMBER:
                    dark = cause in (Cause.DIRECT, Cause.DROPOUT)
                    axes.text(place, b + h / 2, f"{h:.0%}", ha="center", va="center", fontsize=8,
                              color="white" if dark else "black")  # fmt: skip
            bottom += height
        axes.set_title(room, fontsize=10)
        axes.set_ylim(0, 1)
        axes.tick_params(axis="x", labelrotation=30)
    panels[0].set_ylabel("share of the readings")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(Cause))
    wrong = {
        key: sum(share[cause] for cause in Cause if not cause.is_right)
        for key, share in shares.items()
    }
    wrong_by_room = "; ".join(
        f"{room}: " + ", ".join(f"{name} {wrong[room, name]:.0%}" for name in PRESETS)
        for room in ROOMS
    )
    return Item(
        "Causes by room and preset",
        "A reading is right when it tells the surface on the axis, one nearer in the cone, or that "
        "there is none in range; wrong over a bounce, by another's sound, or lost.",
        f"Wrong readings in drives of {seconds:g} s: {wrong_by_room}.",
        (context.figure("causes", figure, f"Causes of the readings in drives of {seconds:g} s"),),
        (
            context.table(
                "causes",
                ("room", "preset", "readings", *(cause_name(cause) for cause in Cause)),
                [
                    (*key, len(log), *(f"{share:.1%}" for share in shares[key]))
                    for key, log in zip(keys, logs, strict=True)
                ],
                "Shares of the causes",
            ),
        ),
    )
