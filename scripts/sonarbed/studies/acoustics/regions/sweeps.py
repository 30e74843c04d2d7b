"""Sweeps: what a sonar reads that turns on the spot, compared with theory and drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from sim import PhysicalSonar
from sim.sonar.protocol import Echoes
from sonarbed.reporting.bench import echoes
from sonarbed.reporting.drawing import COLOURS
from worlds import World

__all__ = ["Deviation", "axes_rad", "compared", "draw_theory", "legend_below", "sweep"]


@dataclass(frozen=True)
class Deviation:
    """How a sweep differs from theory.

    Parameters
    ----------
    largest_m : float
        The largest difference of ranges where both hear something, metres.
    agreeing : float
        Share of the bearings at which both hear something or both nothing.
    """

    largest_m: float
    agreeing: float


def axes_rad(step_deg: float) -> NDArray[np.float64]:
    """Return the directions of a whole turn in steps, radians."""
    axes: NDArray[np.float64] = np.radians(np.arange(-180.0, 180.0, step_deg))
    return axes


def sweep(
    sonar: PhysicalSonar, world: World, at_m: tuple[float, float], axis_rad: NDArray[np.float64]
) -> Echoes:
    """Return what a transducer hears that turns in one place."""
    places = np.broadcast_to(at_m, (axis_rad.size, 2))
    return echoes(sonar, world, places, axis_rad, np.random.default_rng(0))


def compared(read_m: NDArray[np.float64], theory_m: NDArray[np.float64]) -> Deviation:
    """Return how the ranges of a sweep differ from those of theory."""
    read, expected = np.isfinite(read_m), np.isfinite(theory_m)
    both = read & expected
    largest_m = np.abs(read_m[both] - theory_m[both]).max() if both.any() else math.nan
    return Deviation(float(largest_m), float((read == expected).mean()))


def draw_theory(axes: Axes, axis_rad: NDArray[np.float64], theory_m: NDArray[np.float64]) -> None:
    """Draw the arcs of theory as broad lines."""
    range_m = np.where(np.isfinite(theory_m), theory_m, np.nan)
    # Where theory jumps from one thing to another there is no line between them.
    range_m[1:][np.abs(np.diff(range_m)) > 1e-6] = np.nan
    axes.plot(np.degrees(axis_rad), range_m, color=COLOURS[4], lw=6, alpha=0.6, label="theory",
              solid_capstyle="butt")  # fmt: skip


def legend_below(figure: Figure, axes: Axes) -> None:
    """Explain one panel's colours below all of them."""
    handles, labels = axes.get_legend_handles_labels()
    legend = figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    for handle in legend.legend_handles:
        if handle is not None and hasattr(handle, "set_markersize"):
            handle.set_markersize(6)
