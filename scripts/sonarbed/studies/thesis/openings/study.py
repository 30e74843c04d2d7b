"""Figure 6.12: from how far an opening of a given width is still seen, and the equation for it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

import worlds
from sim.sonar.presets import preset
from sim.sonar.protocol import Sonar
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.thesis.openings.driven import DrivenPass, drive_past
from sonarbed.studies.thesis.openings.figures import draw_passes
from sonarbed.studies.thesis.openings.passes import (
    BEYOND_M,
    RIG,
    SHARE,
    Line,
    Passes,
    derived,
    passes_of_seed,
    seeing_half_angle_rad,
)
from sonarbed.studies.thesis.questions import Answer, ThesisSection
from worlds import World

__all__ = ["run"]

# The nearest pass is this much nearer than the sonar's minimum, as in the thesis; readings of the
# boards are then too close to be given, and mean "board".
_TOO_CLOSE_M = 0.015
# Nearer the robot scrapes along the boards.
_NEAREST_ALLOWED_M = 0.09
_THESIS_GAP_M, _THESIS_FARTHEST_M = 0.8, 0.8  # p. 55: a threshold of 800 mm for 80 cm
_NEAR = 0.25  # "near" the thesis: within this share of it
_DRIVEN_M = (0.4, 0.5, 0.6, 0.7, 0.8)


def run(context: StudyContext) -> ThesisSection:
    """Pass openings of many widths at many distances."""
    sonar = preset(context.sonar)
    near_m = max(round(sonar.ring.range_min_m - _TOO_CLOSE_M, 3), _NEAREST_ALLOWED_M)
    gaps_m, step_m = _sweep(context)
    # Beyond the last one the boards come near the end of the range, and silence means nothing.
    far_m = sonar.ring.range_max_m - BEYOND_M
    distances_m = np.concatenate([[near_m], np.arange(near_m + step_m, far_m, step_m)])
    tasks = [(context.sonar, tuple(gaps_m), tuple(distances_m), seed) for seed in context.seeds]
    detected = np.array(context.map(passes_of_seed, tasks, "passing openings"))
    passes = Passes(gaps_m, distances_m, detected)
    rig = worlds.load(RIG)
    theory = derived(seeing_half_angle_rad(sonar, rig), near_m)
    driven_m = (near_m, *(_DRIVEN_M[::2] if context.quick else _DRIVEN_M))
    driven = drive_past(context, sonar, _THESIS_GAP_M, driven_m)
    return ThesisSection(
        "openings",
        "Openings and the sonar's distance (section 6.3)",
        (
            _curve(context, passes, theory),
            _equation(context, passes, theory, sonar, rig, near_m),
            _check(context, driven),
        ),
        (Answer(6, _answer(passes, theory)),),
    )


def _sweep(context: StudyContext) -> tuple[NDArray[np.float64], float]:
    """Return the openings' widths and the step between distances, metres."""
    if context.quick:
        return np.round(np.arange(0.2, 1.61, 0.2), 3), 0.02
    return np.round(np.arange(0.2, 1.61, 0.1), 3), 0.01


def _curve(context: StudyContext, passes: Passes, theory: Line) -> Item:
    seen = passes.farthest_at(_THESIS_GAP_M)
    share = passes.share_at(_THESIS_GAP_M, _THESIS_FARTHEST_M)
    if math.isfinite(seen.value):
        finding = (
            f"An opening of {_THESIS_GAP_M:g} m is seen in {SHARE:.0%} of the readings up to "
            f"{seen.text(3)} m, {_off(seen.value)} against the thesis's {_THESIS_FARTHEST_M:g} m. "
            f"At {_THESIS_FARTHEST_M:g} m {share.text(1, factor=100)} % of the readings are left."
        )
    else:
        finding = (
            f"An opening of {_THESIS_GAP_M:g} m never falls below {SHARE:.0%} of the readings "
            "within the range, or is never seen."
        )
    return Item(
        "Figure 6.12",
        "The largest distance at which an opening between two smooth boards is still detected by "
        "60 % of the readings of the nearest pass (below 165 mm), against its width. The rule "
        "drawn from it: a threshold of 800 mm for an opening of 80 cm.",
        finding,
        (
            context.figure(
                "openings",
                draw_passes(passes, theory, (_THESIS_GAP_M, _THESIS_FARTHEST_M)),
                "Readings left with distance, and the largest distance by the width",
            ),
        ),
        (_table(context, passes, theory),),
    )


def _equation(
    context: StudyContext, passes: Passes, theory: Line, sonar: Sonar, rig: World, near_m: float
) -> Item:
    slope, offset_m = passes.slope, passes.offset_m
    half_deg = math.degrees(seeing_half_angle_rad(sonar, rig))
    limit = (
        "the cone's own"
        if half_deg < math.degrees(float(rig.critical_incidence_rad.min()))
        else "the boards' critical incidence"
    )
    equation = (
        f"d_max = (1 - q) / (2 tan b) g + q d_near, with q = {SHARE:g}, d_near = {near_m:g} m and "
        f"b = {half_deg:.1f} degrees, {limit}: d_max = {theory.slope:.3f} g + "
        f"{theory.offset_m:.3f} m"
    )
    if not math.isfinite(slope.value):
        finding = f"Derived: {equation}. Too few openings have an end to fit a line."
    else:
        fitted_deg = math.degrees(math.atan((1 - SHARE) / (2 * slope.value)))
        finding = (
            f"Derived: {equation}. Fitted to the simulated points: slope {slope.text(3)}, "
            f"{slope.value / theory.slope - 1:+.1%} of the derived one, and offset "
            f"{offset_m.text(3)} m; the slope is that of a cone of {fitted_deg:.1f} degrees to "
            f"either side. {_contains(slope, theory.slope)}"
        )
    implied = math.atan((1 - SHARE) * _THESIS_GAP_M / (2 * (_THESIS_FARTHEST_M - SHARE * near_m)))
    finding += (
        f" The thesis's rule, {_THESIS_FARTHEST_M:g} m for {_THESIS_GAP_M:g} m, is this "
        f"equation with b = {math.degrees(implied):.1f} degrees."
    )
    rows = [
        ("slope", f"{theory.slope:.4f}", *_numbers(slope, 4)),
        ("offset, m", f"{theory.offset_m:.4f}", *_numbers(offset_m, 4)),
        (
            f"d_max at {_THESIS_GAP_M:g} m, m",
            f"{float(theory.at(_THESIS_GAP_M)):.4f}",
            *_numbers(mean_of([line.at(_THESIS_GAP_M) for line in passes.fits]), 4),
        ),
    ]
    table = context.table(
        "equation",
        ("of the line", "derived", "fitted", "low", "high"),
        rows,
        f"d_max = slope * g + offset, a fit for each of {len(context.seeds)} seeds, 95 % interval",
    )
    return Item(
        "Section 6.5, future work 5",
        "The relation between openings and distances should become an equation, instead of a "
        "curve to interpolate.",
        finding,
        tables=(table,),
    )


def _check(context: StudyContext, driven: list[DrivenPass]) -> Item:
    agreeing = sum(one.agreeing for one in driven)
    total = sum(one.readings for one in driven)
    nearest = driven[0].detected
    enough = [one.distance_m for one in driven if one.detected >= SHARE * nearest > 0]
    lost = [one.distance_m for one in driven if one.detected < SHARE * nearest]
    between = (
        f"Its {SHARE:.0%} limit lies between {max(enough):g} and {min(lost):g} m."
        if enough and lost
        else f"Its {SHARE:.0%} limit lies outside these distances."
    )
    table = context.table(
        "driven",
        ("distance, m", "readings", "detect it", "of nearest", "bench detects", "agree"),
        [
            (
                f"{one.distance_m:g}",
                one.readings,
                one.detected,
                f"{one.detected / nearest:.0%}" if nearest else "-",
                one.on_bench,
                one.agreeing,
            )
            for one in driven
        ],
        f"Passes of the robot by an opening of {_THESIS_GAP_M:g} m, and the bench at its places",
    )
    return Item(
        "Section 6.3, the experiment itself",
        "The robot drives straight along the boards, one sonar perpendicular to them.",
        f"The curve is made by a sonar set beside the boards step by step. Driven in the physics "
        f"engine past the {_THESIS_GAP_M:g} m opening at {len(driven)} distances, {agreeing} of "
        f"{total} readings tell opening from board as the bench does at the same places. {between}",
        tables=(table,),
    )


def _answer(passes: Passes, theory: Line) -> str:
    seen = passes.farthest_at(_THESIS_GAP_M)
    if not math.isfinite(seen.value):
        return f"Openings: no limit of a {_THESIS_GAP_M:g} m opening was found within the range."
    near = abs(seen.value / _THESIS_FARTHEST_M - 1) <= _NEAR
    share = passes.share_at(_THESIS_GAP_M, _THESIS_FARTHEST_M)
    return (
        f"Openings: {'near' if near else 'not near'} {_THESIS_FARTHEST_M:g} m (within "
        f"{_NEAR:.0%}): a {_THESIS_GAP_M:g} m opening is seen in {SHARE:.0%} of the readings up to "
        f"{seen.text(3)} m ({_off(seen.value)}); at {_THESIS_FARTHEST_M:g} m "
        f"{share.text(1, factor=100)} % are left. Derived: d_max = {theory.slope:.3f} g + "
        f"{theory.offset_m:.3f} m; fitted: {passes.slope.text(3)} g + {passes.offset_m.text(3)} m."
    )


def _off(distance_m: float) -> str:
    return f"{distance_m / _THESIS_FARTHEST_M - 1:+.0%}"


def _contains(fitted: Estimate, value: float) -> str:
    if math.isnan(fitted.low):
        return "One seed gives no interval."
    verdict = "contains" if fitted.low <= value <= fitted.high else "does not contain"
    return f"Its interval {verdict} the derived {value:.3f}."


def _numbers(estimate: Estimate, digits: int) -> tuple[str, str, str]:
    value, low, high = (
        f"{number:.{digits}f}" for number in (estimate.value, estimate.low, estimate.high)
    )
    return value, low, high


def _table(context: StudyContext, passes: Passes, theory: Line) -> tuple[str, str]:
    rows = [
        (
            f"{gap:g}",
            *_numbers(mean_of(passes.farthest_m[:, i]), 3),
            f"{float(theory.at(gap)):.3f}",
            f"{mean_of(passes.detected[:, i, 0]).value:.1f}",
        )
        for i, gap in enumerate(passes.gaps_m)
    ]
    return context.table(
        "openings",
        ("opening g, m", "d_max, m", "low", "high", "derived, m", "n, nearest pass"),
        rows,
        f"Largest distance at which {SHARE:.0%} of the readings detect the opening, "
        f"{len(context.seeds)} seeds, 95 % interval",
    )
