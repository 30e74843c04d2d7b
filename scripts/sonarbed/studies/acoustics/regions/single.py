"""Regions of constant depth of single things, each alone before a sonar that turns."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item
from sonarbed.studies.acoustics.regions.sweeps import (
    axes_rad,
    compared,
    draw_theory,
    legend_below,
    sweep,
)
from sonarbed.studies.acoustics.regions.targets import Target, targets
from sonarbed.studies.acoustics.theory import (
    as_deviation,
    as_range,
    main_half_width_rad,
    physical,
    range_m,
    sharp,
)

__all__ = ["single_things"]


def single_things(context: StudyContext) -> Item:
    """Turn a sonar before a plane, a corner, an edge and pillars."""
    sonar = physical(context.sonar)
    exact = sharp(sonar)
    step_deg = 1.0 if context.quick else 0.25
    axis = axes_rad(step_deg)
    figure, panels = figure_with(2, 3, width=4.0, height=3.0, sharex=True)
    rows, samples, deviations, late_m, widths = [], [], [], [], []
    for axes, target in zip(panels, targets(sonar), strict=True):
        place = (-target.distance_m, 0.0)
        theory_m = range_m(sonar, target.loci, axis)
        deviation = compared(sweep(exact, target.world, place, axis).range_m, theory_m)
        read_m = sweep(sonar, target.world, place, axis).range_m
        own_m = target.loci[0].range_m
        width_deg = _main_width_deg(axis, np.abs(read_m - own_m) < 0.1)
        theory_deg = 2 * math.degrees(main_half_width_rad(sonar, target.loci[0]))
        deviations.append(deviation)
        late_m.append(compared(read_m, theory_m).largest_m)
        widths.append((target.name, width_deg, theory_deg))
        rows.append(
            (
                target.name,
                f"{own_m:.3f}",
                f"{width_deg:.1f}",
                f"{theory_deg:.1f}",
                as_deviation(deviation.largest_m),
                f"{1000 * late_m[-1]:.1f}",
                f"{deviation.agreeing:.2%}",
            )
        )
        samples += [
            (target.name, f"{math.degrees(a):.2f}", as_range(r), as_range(t))
            for a, r, t in zip(axis, read_m, theory_m, strict=True)
            if np.isfinite(r) or np.isfinite(t)
        ]
        _draw(axes, target, axis, read_m, theory_m)
    for axes in panels[3:]:
        axes.set_xlabel("bearing of the axis, degrees")
    for axes in panels[::3]:
        axes.set_ylabel("range, m")
    legend_below(figure, panels[0])
    worst_m = max(deviation.largest_m for deviation in deviations)
    wide = ", ".join(f"{name} {ours:.1f} ({theory:.1f})" for name, ours, theory in widths)
    return Item(
        "Single things, each alone in a sweep of 360 degrees",
        "A plane is read at its perpendicular distance, a corner and an edge at their vertex's, a "
        "pillar at its axis's less its radius, unchanged while the thing lies in the part of the "
        "beam that its level allows.",
        "Without pulse length and noise the largest deviation from theory is "
        f"{as_deviation(worst_m)}; as the preset reads, weak echoes at the arcs' ends are up to "
        f"{1000 * max(late_m):.0f} mm long. Main arcs in degrees, simulated (theory): {wide}; "
        f"steps of {step_deg:g} degrees. "
        "Side arcs belong to the beam's side lobes.",
        (context.figure("single", figure, "Range against bearing of the axis, single things"),),
        (
            context.table(
                "single",
                (
                    "thing",
                    "range, m",
                    "main arc, degrees",
                    "theory",
                    "largest deviation",
                    "as read, mm",
                    "bearings that agree",
                ),
                rows,
                "Arcs and deviations; 'as read' with pulse length, noise and whole millimetres",
            ),
            context.table(
                "sweeps",
                ("thing", "bearing, degrees", "read, m", "theory, m"),
                samples,
                "The sweeps where anything is heard",
            ),
        ),
    )


def _main_width_deg(axis_rad: NDArray[np.float64], read: NDArray[np.bool_]) -> float:
    """Return how wide the run of bearings about the axis is that read the thing."""
    middle = int(np.argmin(np.abs(axis_rad)))
    if not read[middle]:
        return 0.0
    lost = np.flatnonzero(~read)
    first, last = lost[lost < middle].max() + 1, lost[lost > middle].min() - 1
    return math.degrees(axis_rad[last] - axis_rad[first])


def _draw(
    axes: Axes,
    target: Target,
    axis: NDArray[np.float64],
    read_m: NDArray[np.float64],
    theory_m: NDArray[np.float64],
) -> None:
    draw_theory(axes, axis, theory_m)
    axes.plot(np.degrees(axis), read_m, ".", ms=2.5, color=COLOURS[0], label="simulated, as read")
    axes.set_title(target.name, fontsize=10)
    nearest_m = min(locus.range_m for locus in target.loci)
    axes.set_ylim(nearest_m - 0.15, target.loci[0].range_m + 0.15)
    axes.set_xlim(-80, 80)
    axes.set_xticks(range(-80, 81, 20))
