"""The figure of the study of openings."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.statistics import mean_of
from sonarbed.studies.thesis.openings.passes import SHARE, Line, Passes

__all__ = ["draw_passes"]


def draw_passes(passes: Passes, theory: Line, rule_m: tuple[float, float]) -> Figure:
    """Draw how detection falls with distance, and the largest distance over the width.

    `rule_m` is the thesis's own point: width of an opening and largest distance.
    """
    figure, (left, right) = figure_with(1, 2)
    for gap_m, colour in zip((0.4, 0.8, 1.2, 1.6), COLOURS, strict=False):
        gap = int(np.argmin(np.abs(passes.gaps_m - gap_m)))
        counted = passes.detected[:, gap]
        share = (counted / np.maximum(counted[:, :1], 1)).mean(axis=0)
        left.plot(passes.distances_m, share, color=colour, label=f"g = {passes.gaps_m[gap]:g} m")
    left.axhline(SHARE, color="#888888", ls="--", lw=1)
    left.set_xlabel("distance from the boards, m")
    left.set_ylabel("readings that detect it, of the nearest pass")
    left.set_xlim(0, 2.6)
    left.set_ylim(bottom=0)
    left.legend(fontsize=9)

    gaps = np.array([0.0, 1.7])
    right.plot(gaps, theory.at(gaps), color="#888888", label="derived from the cone")
    if passes.fits:
        fit = Line(passes.slope.value, passes.offset_m.value)
        right.plot(gaps, fit.at(gaps), ls="--", color=COLOURS[1], label="fitted")
    means = [mean_of(passes.farthest_m[:, i]) for i in range(passes.gaps_m.size)]
    right.errorbar(
        passes.gaps_m,
        [mean.value for mean in means],
        [[mean.value - mean.low for mean in means], [mean.high - mean.value for mean in means]],
        fmt="o",
        ms=4,
        color=COLOURS[0],
        label=f"simulated, {SHARE:.0%} of the readings",
    )
    right.plot(*rule_m, "*", ms=13, color=COLOURS[4], label="the thesis's rule")
    right.set_xlabel("opening g, m")
    right.set_ylabel("largest distance d_max, m")
    right.set_xlim(0, 1.7)
    right.set_ylim(bottom=0)
    right.legend(fontsize=9)
    return figure
