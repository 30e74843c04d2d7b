"""Small things: plates by their width, and the zone in which a rod and a plate are detected."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from scipy.special import fresnel

from sim import PhysicalSonar
from sonarbed.reporting.bench import board, echoes, post, scene
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.acoustics.theory import (
    GLASS,
    LOSS_DB,
    physical,
    pillar_db,
    plane_over_db,
    sharp,
)
from worlds import World

__all__ = ["run", "strip_db"]

_DISTANCES_M = (1.0, 2.0, 3.0)
_LARGE_M = 60.0
# What makers of ultrasonic sensors print: a rod of 25 mm, and a plate, here half a metre wide.
_ROD_M, _PLATE_M = 0.0125, 0.5
# Places nearer to the sonar than this are not drawn: the receiver is still deaf.
_NEAREST_M = 0.15


def run(context: StudyContext) -> Section:
    """Draw levels by width, and zones of detection."""
    return Section("sizes", "Small things", (_plates(context), _zones(context)))


def strip_db(width_m: float, distance_m: float, wavelength_m: float) -> float:
    """Return the level of a plate met head-on against a large one, by Fresnel's integrals."""
    sine, cosine = fresnel(width_m / math.sqrt(wavelength_m * distance_m))
    return float(10 * math.log10(2 * (sine**2 + cosine**2)))


def _plates(context: StudyContext) -> Item:
    sonar = sharp(physical(context.sonar))
    wavelength_m = sonar.piston.wavelength_m
    widths_m = np.arange(0.05, 0.601, 0.05 if context.quick else 0.025)
    fine_m = np.linspace(0.02, 0.62, 600)
    figure, (axes,) = figure_with(width=9.5)
    rows, deviations = [], []
    for distance_m, colour in zip(_DISTANCES_M, COLOURS, strict=False):
        theory_db = [strip_db(width, distance_m, wavelength_m) for width in fine_m]
        measured_db = _plate_db(sonar, widths_m, distance_m)
        axes.plot(100 * fine_m, theory_db, color=colour, lw=1.2)
        axes.plot(100 * widths_m, measured_db, "o", ms=4.5, mfc="none", color=colour,
                  label=f"at {distance_m:g} m")  # fmt: skip
        zone_m = math.sqrt(wavelength_m * distance_m / 2)
        axes.axvline(200 * zone_m, color=colour, lw=0.8, ls=":")
        expected_db = [strip_db(width, distance_m, wavelength_m) for width in widths_m]
        # What is farther off than 6 of Fresnel's arguments sends its sound when the pulse ends.
        firm = widths_m / math.sqrt(wavelength_m * distance_m) < 6
        deviations.append(np.abs(measured_db - expected_db)[firm].max())
        rows += [
            (f"{distance_m:g}", f"{100 * width:.1f}", f"{ours:.2f}", f"{theory:.2f}")
            for width, ours, theory in zip(widths_m, measured_db, expected_db, strict=True)
        ]
    axes.axhline(0, color="#888888", lw=0.8)
    axes.set(xlim=(0, 62), ylim=(-15, 4), xlabel="width of the plate, cm",
             ylabel="level against a large wall, dB")  # fmt: skip
    axes.legend(loc="lower right", title="lines: Fresnel's integrals")
    recess_db = ", ".join(
        f"{strip_db(0.2, distance_m, wavelength_m):+.1f} dB at {distance_m:g} m"
        for distance_m in _DISTANCES_M
    )
    return Item(
        "Plates by their width",
        "A face no larger than the first Fresnel zone, of diameter 2 sqrt(λ r / 2) (dotted), sends "
        "back less than a large one, by 6 dB at each halving; a little larger it sends back more.",
        f"Simulated levels agree with Fresnel's integrals within {max(deviations):.2f} dB. The "
        f"back of a door recess of 20 cm: {recess_db}; a strip of 5 cm "
        f"{strip_db(0.05, 3.0, wavelength_m):.1f} dB at 3 m.",
        (context.figure("plates", figure, "Level of a plate by its width, against a large wall"),),
        (
            context.table(
                "plates",
                ("distance, m", "width, cm", "simulated, dB", "theory, dB"),
                rows,
                "Levels of plates against a large wall",
            ),
        ),
    )


def _plate_db(
    sonar: PhysicalSonar, widths_m: NDArray[np.float64], distance_m: float
) -> NDArray[np.float64]:
    """Return simulated levels of plates, met head-on, against that of a large one."""

    def level_db(width_m: float) -> float:
        room = scene(board("plate", width_m, material=GLASS))
        place = np.array([[-distance_m, 0.0]])
        return float(echoes(sonar, room, place, 0.0, np.random.default_rng(0)).level_db[0])

    whole_db = level_db(_LARGE_M)
    return np.array([level_db(width) for width in widths_m]) - whole_db


def _zones(context: StudyContext) -> Item:
    sonar = physical(context.sonar)
    exact = sharp(sonar)
    reach_m = sonar.ring.range_max_m
    distance_m = np.arange(_NEAREST_M, reach_m - 0.05, 0.1 if context.quick else 0.04)
    bearing_rad = np.radians(np.arange(-60, 60.01, 1.0 if context.quick else 0.25))
    targets = (
        ("plate of 50 cm that faces the sonar", board("plate", _PLATE_M, material=GLASS),
         [strip_db(_PLATE_M, r, sonar.piston.wavelength_m) for r in distance_m], COLOURS[5]),
        ("rod of 25 mm", post("rod", _ROD_M, material=GLASS),
         [pillar_db(_ROD_M, r) for r in distance_m], COLOURS[0]),
    )  # fmt: skip
    figure, (axes,) = figure_with(width=9.5, height=6.2)
    agreeing, rows = [], []
    for name, solid, share_db, colour in targets:
        heard = _heard(exact, scene(solid), distance_m, bearing_rad)
        over_db = LOSS_DB + np.array(
            [plane_over_db(sonar, r) + one for r, one in zip(distance_m, share_db, strict=True)]
        )
        theory = over_db[:, None] + 2 * sonar.piston.level_db(bearing_rad)[None, :] > 0
        agreeing.append((name, float((heard == theory).mean())))
        _draw_zone(axes, distance_m, bearing_rad, heard, colour, name)
        rows += [
            (name, f"{r:.2f}", f"{_half_width_deg(bearing_rad, row):.2f}",
             f"{_half_width_deg(bearing_rad, expected):.2f}")
            for r, row, expected in zip(distance_m, heard, theory, strict=True)
        ]  # fmt: skip
    half = sonar.ring.half_angle_rad
    side_x, side_y = reach_m * math.cos(half), reach_m * math.sin(half)
    axes.plot([side_x, 0, side_x], [side_y, 0, -side_y], color="#555555", lw=1, ls="--",
              label=f"nominal cone, ±{math.degrees(half):g}°")  # fmt: skip
    axes.plot(0, 0, "k>", ms=8)
    axes.set_aspect("equal")
    axes.set(xlim=(-0.1, reach_m), ylim=(-1.9, 1.9), xlabel="ahead, m", ylabel="aside, m")
    axes.legend(loc="upper left", fontsize=9)
    told = "; ".join(f"{name} {share:.1%}" for name, share in agreeing)
    return Item(
        "Where a rod and a plate are detected",
        "A plate is detected farther off the axis and from farther away than a rod; near things "
        "are detected by side lobes, far ones about the axis only: the zone is no cone.",
        f"Places at which simulation and theory agree: {told}.",
        (context.figure("zones", figure, "The zones in which a rod and a plate are detected"),),
        (
            context.table(
                "zones",
                ("thing", "distance, m", "main lobe, degrees", "theory, degrees"),
                rows,
                "How far off the axis a thing is detected without a gap",
            ),
        ),
    )


def _heard(
    sonar: PhysicalSonar,
    room: World,
    distance_m: NDArray[np.float64],
    bearing_rad: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Return whether a thing in the origin is detected from each distance, at each bearing."""
    far, turned = (grid.ravel() for grid in np.meshgrid(distance_m, bearing_rad, indexing="ij"))
    places = np.column_stack([-far, np.zeros(far.size)])
    # The thing's edges count for more than it does where its face is silent: of the plate only
    # what its face sends back is asked for.
    detected = echoes(sonar.replace(edge_db=-200.0), room, places, -turned,
                      np.random.default_rng(0))  # fmt: skip
    return np.isfinite(detected.range_m).reshape(distance_m.size, bearing_rad.size)


def _half_width_deg(bearing_rad: NDArray[np.float64], heard: NDArray[np.bool_]) -> float:
    """Return up to which bearing a thing is detected without a gap, degrees; NaN if nowhere."""
    ahead = heard[bearing_rad >= -1e-9]
    if not ahead[0]:
        return math.nan
    lost = np.flatnonzero(~ahead)
    last = (lost[0] if lost.size else ahead.size) - 1
    return math.degrees(bearing_rad[bearing_rad >= -1e-9][last])


def _draw_zone(
    axes: Axes,
    distance_m: NDArray[np.float64],
    bearing_rad: NDArray[np.float64],
    heard: NDArray[np.bool_],
    colour: str,
    name: str,
) -> None:
    far, turned = np.meshgrid(distance_m, bearing_rad, indexing="ij")
    axes.contourf(far * np.cos(turned), far * np.sin(turned), heard.astype(float), [0.5, 1.5],
                  colors=[colour])  # fmt: skip
    axes.fill([], [], color=colour, label=name)
