"""Dropout against incidence: how far a wall of each material may be tilted and still answers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from numpy.typing import NDArray

from sim import PhysicalSonar
from sonarbed.reporting.bench import board, echoes, scene
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.acoustics.theory import heard_spans_rad, physical, plane_over_db
from worlds import MATERIALS, Material

__all__ = [
    "DISTANCES_M",
    "LOST",
    "MIRRORED",
    "PERFECT",
    "SCATTERED",
    "answers",
    "dead_bands_deg",
    "run",
]

DISTANCES_M = (0.5, 1.0, 2.0, 3.0)
LOST, MIRRORED, SCATTERED = range(3)
_COLOURS = ("#E4E4E4", COLOURS[0], COLOURS[4])
_LABELS = ("lost", "mirror echo: reads the perpendicular distance", "scattered echo")
# So loud a sonar hears three side lobes; Cao and Borenstein 2002 saw walls up to 42 degrees.
_LOUD_DB = 56.0
_WIDEST_DEG = 75.0
PERFECT = Material("perfect mirror", math.radians(10), 1.0, 0.0, diffuse_floor_db=-100.0)
"""What the rule of 42 degrees is about: the last lobe stands 0.1 dB above the threshold."""


def run(context: StudyContext) -> Section:
    """Turn a sonar before walls of all materials."""
    return Section("dropout", "Dropout against incidence", (_materials(context), _lobes(context)))


def answers(
    sonar: PhysicalSonar,
    material: str | Material,
    distance_m: float,
    incidence_rad: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Return what comes back from a long wall: `LOST`, `MIRRORED` or `SCATTERED`.

    Parameters
    ----------
    sonar : PhysicalSonar
        Whose acoustics.
    material : str or Material
        Of the wall, or its name in `worlds.MATERIALS`.
    distance_m : float
        Perpendicular distance of the wall, metres.
    incidence_rad : ndarray
        Angles between the axis and the wall's normal, radians.
    """
    wall = scene(board("wall", 60.0, material=material))
    places = np.broadcast_to([-distance_m, 0.0], (incidence_rad.size, 2))
    # The same noise for every sonar: whether there is an echo does not depend on it.
    heard = echoes(sonar, wall, places, incidence_rad, np.random.default_rng(0))
    mirrored = heard.incidence_rad < 1e-6
    return np.select([np.isinf(heard.range_m), mirrored], [LOST, MIRRORED], SCATTERED)


def dead_bands_deg(
    incidence_deg: NDArray[np.float64], answer: NDArray[np.int64]
) -> list[tuple[float, float]]:
    """Return from where to where, between two heard lobes, nothing is heard, degrees."""
    heard = answer != LOST
    change = np.diff(heard.astype(int))
    ends, begins = np.flatnonzero(change == -1), np.flatnonzero(change == 1)
    return [
        (float(incidence_deg[end + 1]), float(incidence_deg[begins[begins > end][0]]))
        for end in ends
        if (begins > end).any()
    ]


def _step_deg(context: StudyContext) -> float:
    return 1.0 if context.quick else 0.25


def _strips(
    axes: Axes,
    incidence_deg: NDArray[np.float64],
    answer: Sequence[NDArray[np.int64]],
    names: Sequence[str],
) -> None:
    """Draw one strip a row, coloured by what comes back."""
    step = incidence_deg[1] - incidence_deg[0]
    for row, answered in enumerate(answer):
        changes = np.flatnonzero(np.diff(answered)) + 1
        for part in np.split(np.arange(answered.size), changes):
            begin = incidence_deg[part[0]] - (step / 2 if part[0] else 0.0)
            width = incidence_deg[part[-1]] + step / 2 - begin
            axes.barh(row, width, left=begin, height=0.82, color=_COLOURS[answered[part[0]]])
    axes.set_yticks(range(len(names)), names)
    axes.set_xlim(0, incidence_deg[-1])
    axes.set_xticks(range(0, int(incidence_deg[-1]) + 1, 15))


def _materials(context: StudyContext) -> Item:
    sonar = physical(context.sonar)
    incidence_deg = np.arange(0, _WIDEST_DEG + 0.01, _step_deg(context))
    incidence = np.radians(incidence_deg)
    figure, panels = figure_with(5, 3, width=3.9, height=1.75, sharex=True, sharey=True)
    rows, widest = [], {}
    for axes, material in zip(panels, MATERIALS, strict=False):
        answer = [answers(sonar, material, distance_m, incidence) for distance_m in DISTANCES_M]
        _strips(axes, incidence_deg, answer, [f"{d:g}" for d in DISTANCES_M])
        axes.set_title(material, fontsize=10)
        widest[material] = _last_deg(incidence_deg, answer[DISTANCES_M.index(2.0)])
        for distance_m, answered in zip(DISTANCES_M, answer, strict=True):
            bands = dead_bands_deg(incidence_deg, answered)
            rows.append(
                (
                    material,
                    f"{distance_m:g}",
                    f"{(answered == LOST).mean():.0%}",
                    f"{_last_deg(incidence_deg, answered):.2f}",
                    "; ".join(f"{a:.2f} to {b:.2f}" for a, b in bands) or "none",
                )
            )
    for axes in panels[len(MATERIALS) :]:
        axes.set_axis_off()
    for axes in panels[len(MATERIALS) - 3 : len(MATERIALS)]:
        axes.set_xlabel("incidence, degrees")
        axes.tick_params(labelbottom=True)
    for axes in panels[::3]:
        axes.set_ylabel("distance, m")
    handles = [Patch(color=c, label=name) for c, name in zip(_COLOURS, _LABELS, strict=True)]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    ranked = sorted(widest, key=widest.__getitem__)
    theory_rad = heard_spans_rad(sonar, plane_over_db(sonar, 2.0) - 0.2)[-1][1]
    return Item(
        "Every material at 0.5, 1, 2 and 3 m",
        "A wall answers while the beam at its normal stands above the threshold, in lobes with "
        "dead bands between them; a rough one also by what it scatters. The angle follows from "
        f"beam and level: for glass at 2 m the last lobe ends at {math.degrees(theory_rad):.1f} "
        "degrees.",
        f"At 2 m the widest incidence that still answers runs from {widest[ranked[0]]:.1f} degrees "
        f"({ranked[0]}) over {widest['glass']:.1f} (glass) and {widest['drywall']:.1f} (drywall) "
        f"to {widest[ranked[-1]]:.1f} ({ranked[-1]}).",
        (context.figure("materials", figure, "What comes back against incidence, by material"),),
        (
            context.table(
                "materials",
                (
                    "material",
                    "distance, m",
                    f"lost of 0 to {_WIDEST_DEG:g} degrees",
                    "last answer, degrees",
                    "dead bands, degrees",
                ),
                rows,
                "What is lost",
            ),
        ),
    )


def _last_deg(incidence_deg: NDArray[np.float64], answer: NDArray[np.int64]) -> float:
    heard = np.flatnonzero(answer != LOST)
    return float(incidence_deg[heard[-1]]) if heard.size else math.nan


def _lobes(context: StudyContext) -> Item:
    preset = physical(context.sonar)
    incidence_deg = np.arange(0, 60.01, _step_deg(context))
    ranges_db = (20.0, 30.0, 36.0, 40.0, preset.receiver.dynamic_range_db, _LOUD_DB)
    answer, rows = [], []
    for range_db in sorted(set(ranges_db)):
        receiver = replace(preset.receiver, dynamic_range_db=range_db, gain_share=1.0)
        sonar = preset.replace(receiver=receiver)
        answered = answers(sonar, PERFECT, 2.0, np.radians(incidence_deg))
        answer.append(answered)
        spans = heard_spans_rad(sonar, plane_over_db(sonar, 2.0))
        rows.append(
            (
                f"{range_db:g}",
                f"{_last_deg(incidence_deg, answered):.2f}",
                f"{math.degrees(spans[-1][1]):.2f}",
                "; ".join(f"{a:.2f} to {b:.2f}" for a, b in dead_bands_deg(incidence_deg, answered))
                or "none",
            )
        )
    figure, (axes,) = figure_with(width=9.5, height=3.2)
    _strips(axes, incidence_deg, answer, [row[0] for row in rows])
    axes.axvspan(40, 44, color="none", ec=COLOURS[6], ls="--", lw=1)
    axes.set(xlabel="incidence, degrees", ylabel="dynamic range, dB")
    handles = [Patch(color=_COLOURS[k], label=_LABELS[k]) for k in (LOST, MIRRORED)]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return Item(
        "Lobes and dead bands by dynamic range",
        "Cao and Borenstein (2002) saw a wall up to 42 degrees, three side lobes out: with 56 dB "
        "the last lobe ends at 42 +- 2 degrees (dashed).",
        f"With {rows[-1][0]} dB the last lobe ends at {rows[-1][1]} degrees (theory "
        f"{rows[-1][2]}); dead bands, degrees: {rows[-1][3]}.",
        (
            context.figure(
                "lobes", figure, "A perfect mirror at 2 m; the gain takes back all loss by distance"
            ),
        ),
        (
            context.table(
                "lobes",
                ("dynamic range, dB", "last answer, degrees", "theory", "dead bands, degrees"),
                rows,
                "Lobes of a perfect mirror at 2 m",
            ),
        ),
    )
