"""The beam of the transducer, one way and there and back, beside levels of simulated echoes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from sim import PhysicalSonar, Piston
from sonarbed.reporting.bench import board, echoes, scene
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.studies.acoustics.theory import GLASS, LOSS_DB, physical, sharp

__all__ = ["first_null_rad", "half_angle_rad", "run"]

_LOUD_DB = 70.0  # all lobes that are drawn stand above the threshold


def run(context: StudyContext) -> Section:
    """Draw the beam and measure it with a large pane of glass."""
    return Section("beam", "The beam", (_beam(context),))


def half_angle_rad(piston: Piston, drop_db: float) -> float:
    """Return where the main lobe has fallen by so many decibels, one way, radians."""
    return float(brentq(lambda t: float(piston.level_db(t)) + drop_db, 0.0, first_null_rad(piston)))


def first_null_rad(piston: Piston) -> float:
    """Return where the pattern has its first minimum, searched for, radians."""
    angle = np.linspace(1e-4, math.pi / 2, 90_001)
    level = piston.level_db(angle)
    return float(angle[1:-1][(level[1:-1] <= level[:-2]) & (level[1:-1] < level[2:])][0])


def _beam(context: StudyContext) -> Item:
    sonar = physical(context.sonar)
    piston = sonar.piston
    angle_deg = np.arange(0, 60.01, 0.05)
    one_way_db = piston.level_db(np.radians(angle_deg))
    tilt_deg = np.arange(0, 60.01, 2.0 if context.quick else 1.0)
    measured_db = _measured_db(sonar, np.radians(tilt_deg))
    theory_db = 2 * piston.level_db(np.radians(tilt_deg))
    heard = np.isfinite(measured_db)
    # Beside a null the level falls so steeply that the beam's table counts, not the echo.
    firm = heard & (theory_db > -60)
    deviation_db = float(np.abs(measured_db - theory_db)[firm].max())
    null, rule = first_null_rad(piston), math.asin(0.61 * piston.wavelength_m / piston.radius_m)
    three, six = half_angle_rad(piston, 3.0), half_angle_rad(piston, 6.0)

    figure, (axes,) = figure_with(width=9.5)
    axes.plot(angle_deg, one_way_db, color=COLOURS[0], label="one way")
    axes.plot(angle_deg, 2 * one_way_db, color=COLOURS[1], label="there and back")
    axes.plot(tilt_deg[heard], measured_db[heard], "o", ms=4, mfc="none", color=COLOURS[6],
              label="simulated echo of a pane of glass")  # fmt: skip
    axes.axvline(math.degrees(rule), color="#888888", lw=1, ls="--")
    axes.text(math.degrees(rule) + 0.4, -3, f"0.61 λ/a: {math.degrees(rule):.1f}°",
              color="#555555", fontsize=9, va="top")  # fmt: skip
    threshold_db = -sonar.receiver.dynamic_range_db
    axes.axhline(threshold_db, color="#888888", lw=1, ls=":")
    axes.text(43, threshold_db + 0.8, "threshold at 1 m", color="#555555", fontsize=9, ha="center")
    axes.set(xlim=(0, 60), ylim=(-72, 2), xlabel="angle off the axis, degrees",
             ylabel="level against the axis, dB")  # fmt: skip
    axes.legend(loc="upper right")
    table = context.table(
        "beam",
        ("angle, degrees", "one way, dB", "there and back, dB", "simulated echo, dB"),
        [
            (f"{t:.1f}", f"{theory / 2:.2f}", f"{theory:.2f}", f"{level:.2f}" if ok else "silent")
            for t, theory, level, ok in zip(tilt_deg, theory_db, measured_db, heard, strict=True)
        ],
        "The beam and the levels of simulated echoes",
    )
    return Item(
        "Beam pattern",
        f"A round piston of {1000 * piston.radius_m:.1f} mm at {piston.frequency_hz / 1000:.1f} "
        "kHz: 2 J1(x)/x with x = ka sin t, squared there and back; first null at asin(0.61 λ/a).",
        f"Half-power half-angle {math.degrees(three):.1f} degrees one way (6 dB: "
        f"{math.degrees(six):.1f}); the first null lies at {math.degrees(null):.2f} degrees, "
        f"0.61 λ/a gives {math.degrees(rule):.2f}. Simulated echoes agree with the pattern there "
        f"and back within {max(deviation_db, 0.001):.3f} dB down to -60 dB.",
        (
            context.figure(
                "beam", figure, "The beam of the transducer, and echoes of a tilted pane"
            ),
        ),
        (table,),
    )


def _measured_db(sonar: PhysicalSonar, tilt_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return levels of the mirror echo of a pane 1 m away against that head-on; NaN: silent."""
    receiver = replace(sharp(sonar).receiver, dynamic_range_db=_LOUD_DB)
    # The pane's own scattering would be louder than the far lobes' mirror echo.
    loud = sonar.replace(receiver=receiver, max_bounces=0)
    pane = scene(board("pane", 60.0, material=GLASS))
    places = np.broadcast_to([-1.0, 0.0], (tilt_rad.size, 2))
    heard = echoes(loud, pane, places, tilt_rad, np.random.default_rng(0))
    mirrored = heard.incidence_rad < 1e-6
    return np.where(mirrored, heard.level_db - _LOUD_DB - LOSS_DB, np.nan)
