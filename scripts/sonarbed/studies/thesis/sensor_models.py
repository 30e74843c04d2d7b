"""Figures 4.4 to 4.6, 5.1 and 5.5 to 5.7: what the two sensor models say of one reading."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item
from sonarbed.studies.thesis.contradictions import contradictions
from sonarbed.studies.thesis.questions import ThesisSection
from sonarmap import ParameterizedModel, SensorModel, StandardModel

__all__ = ["run"]

# The settings of the figures, in the thesis's own units (its figures have no metres).
_MURPHY = StandardModel(math.radians(15), 10.0, 0.98, 0.5)
_FIGURE_5_1 = StandardModel(math.radians(15), 10.0, 0.9, 0.5)
_PROPOSED = ParameterizedModel(p1=0.02, p2=0.15, p3_m=1.0, p4=0.98, p5_rad=math.radians(15))
# Cells of figures 4.4 and 4.5: range, bearing in degrees, and what Murphy's book computes.
_EXAMPLES = (
    ("4.4, region 1", "P(s|Occupied)", 6.0, 5.0, 0.52),
    ("4.5, region 2", "P(s|Empty)", 3.5, 0.0, 0.83),
)


def run(context: StudyContext) -> ThesisSection:
    """Draw both models and compute the book's examples."""
    return ThesisSection(
        "sensor_models",
        "The sensor models (chapters 4 and 5)",
        (_examples(context), _standard(context), _on_axis(context), _parameterized(context)),
    )


def _examples(context: StudyContext) -> Item:
    rows = []
    for figure, name, range_m, bearing_deg, book in _EXAMPLES:
        occupied = float(_MURPHY.probability(range_m, math.radians(bearing_deg), 6.0))
        ours = occupied if "Occupied" in name else 1 - occupied
        rows.append((figure, name, range_m, bearing_deg, book, f"{ours:.4f}"))
    table = context.table(
        "examples",
        ("figure", "what", "r", "bearing, degrees", "book", "ours"),
        rows,
        "The example cells: s = 6, R = 10, beta = 15 degrees",
    )
    return Item(
        "Figures 4.4 and 4.5",
        "Two example cells of a reading s = 6 after Murphy: 0.52 and 0.83.",
        f"Equations 4.9 and 4.12 give {rows[0][-1]} and {rows[1][-1]}: the book's, rounded.",
        tables=(table,),
    )


def _standard(context: StudyContext) -> Item:
    figure = _two_views(_MURPHY, 6.0, 10.0)
    wrong_near, wrong_hill = contradictions(_MURPHY, 6.0, _MURPHY.tolerance_m)
    return Item(
        "Figure 4.6",
        "The standard model in 2-D and 3-D; the thesis notes spikes in the wrong direction.",
        f"{wrong_near:.0%} of the cone's area before the hill says 'occupied' (P > 0.5) and "
        f"{wrong_hill:.0%} of the hill's area says 'empty' (P < 0.5): the spikes are real.",
        (context.figure("standard", figure, "Standard model, s = 6, R = 10, beta = 15 degrees"),),
    )


def _on_axis(context: StudyContext) -> Item:
    figure, (left, right) = figure_with(1, 2, sharey=True)
    r = np.linspace(0, 10, 4001)
    left.plot(r, _FIGURE_5_1.probability(r, 0.0, 5.0), color=COLOURS[0])
    left.set_title("standard, s = 5, max 0.9, tolerance 0.5 (figure 5.1)", fontsize=10)
    right.plot(r, _PROPOSED.probability(r, 0.0, 7.5), color=COLOURS[1])
    right.set_title("parameterized, s = 7.5, P3 = 1 (figure 5.5)", fontsize=10)
    for axes in (left, right):
        axes.axhline(0.5, color="#999999", lw=0.8)
        axes.set_xlabel("r, units of the thesis")
        axes.set_ylim(0, 1)
    left.set_ylabel("P(occupied) on the axis")
    start = float(_FIGURE_5_1.probability(4.5, 0.0, 5.0))
    middle = float(_FIGURE_5_1.probability(5.0, 0.0, 5.0))
    peak = float(_PROPOSED.probability(7.5, 0.0, 7.5))
    return Item(
        "Figures 5.1 and 5.5",
        "On the axis the standard model believes most in the near end of its hill, the proposed "
        "model in the reading itself.",
        f"Standard: {start:.4f} at the near end against {middle:.4f} at the reading. Proposed: "
        f"its peak is P4 = {peak:.2f}, at the reading.",
        (context.figure("axis", figure, "P(occupied) on the acoustic axis"),),
    )


def _parameterized(context: StudyContext) -> Item:
    figure = _two_views(_PROPOSED, 7.5, 10.0)
    wrong_near, wrong_hill = contradictions(_PROPOSED, 7.5, _PROPOSED.p3_m)
    return Item(
        "Figures 5.6 and 5.7",
        "The proposed model in 2-D and 3-D, s = 7.5 units: no spikes in the wrong direction.",
        f"{wrong_near:.0%} of the area before the hill says 'occupied' and {wrong_hill:.0%} of the "
        "hill says 'empty': there are none.",
        (
            context.figure(
                "parameterized", figure, "Parameterized model, 0.02, 0.15, 1 unit, 0.98, 15 degrees"
            ),
        ),
    )


def _two_views(model: SensorModel, reading: float, far: float) -> Figure:
    x, y = np.meshgrid(np.linspace(0, far, 401), np.linspace(-3, 3, 241))
    p = _probability(model, x, y, reading)
    figure = Figure(figsize=(12, 4.6), layout="constrained")
    flat = figure.add_subplot(1, 2, 1)
    image = flat.pcolormesh(x, y, p, cmap="RdBu_r", vmin=0, vmax=1, rasterized=True)
    flat.set_aspect("equal")
    flat.set_xlabel("along the axis, units")
    flat.set_ylabel("across, units")
    figure.colorbar(image, ax=flat, shrink=0.75, label="P(occupied)")
    hill: Axes3D = figure.add_subplot(1, 2, 2, projection="3d")
    hill.plot_surface(x, y, p, cmap="RdBu_r", vmin=0, vmax=1, rstride=6, cstride=6, lw=0)
    hill.set_xlabel("along, units")
    hill.set_ylabel("across, units")
    hill.set_zlabel("P(occupied)")
    hill.view_init(32, -120)
    return figure


def _probability(
    model: SensorModel, x: NDArray[np.float64], y: NDArray[np.float64], reading: float
) -> NDArray[np.float64]:
    from sonarmap.methods.bayes.models import probability

    return probability(model, np.hypot(x, y), np.arctan2(y, x), reading)
