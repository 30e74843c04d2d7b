"""Figure 6.12: from how far an opening of a given width is still seen, and the equation for it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

import sonarmap as sm
import worlds
from sim.sonar.presets import preset
from sim.sonar.protocol import Sonar
from sonarbed.reporting.bench import readings
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Answer, Item, Section
from sonarbed.reporting.setting import Setting
from sonarbed.reporting.statistics import Estimate, mean_of
from worlds import World

__all__ = ["SHARE", "Line", "counts", "derived", "farthest_m", "run", "seeing_half_angle_rad"]

SHARE = 0.6
"""An opening counts as seen while so many of the nearest pass's readings detect it; p. 57."""

_ROOM = "opening-rig"
_SPEED_MPS = 0.1  # of the driver "straight", assumed: the thesis tells no speed
# A reading that is longer than the boards' distance by more than this went through the opening;
# the farthest point of a board that a cone of 30 degrees sees at 2.6 m is 0.09 m longer.
_BEYOND_M = 0.3
# The nearest pass is this much nearer than the sonar's minimum, as in the thesis; readings of the
# boards are then too close to be told, and mean "board".
_TOO_CLOSE_M = 0.015
# Nearer the robot scrapes along the boards.
_NEAREST_ALLOWED_M = 0.09
_THESIS_GAP_M, _THESIS_FARTHEST_M = 0.8, 0.8  # p. 55: a threshold of 800 mm for 80 cm
_NEAR = 0.25  # "near" the thesis: within this share of it
_DRIVEN_M = (0.4, 0.5, 0.6, 0.7, 0.8)
_DRIVEN_SEED = 0


@dataclass(frozen=True)
class Line:
    """``farthest distance = slope * opening + offset_m``."""

    slope: float
    offset_m: float

    def at(self, gap_m: ArrayLike) -> NDArray[np.float64]:
        """Return the distance for openings of the given widths, metres."""
        return self.slope * np.asarray(gap_m, float) + self.offset_m


@dataclass(frozen=True, eq=False)
class _Swept:
    """Counts of readings that detect an opening.

    Parameters
    ----------
    gaps_m, distances_m : ndarray
        Widths of the openings, and distances, the nearest first.
    detected : ndarray of int, shape (seeds, gaps, distances)
        How many readings of a pass detect the opening.
    """

    gaps_m: NDArray[np.float64]
    distances_m: NDArray[np.float64]
    detected: NDArray[np.int64]

    @cached_property
    def farthest_m(self) -> NDArray[np.float64]:
        """The largest distance at which each opening is seen, shape (seeds, gaps)."""
        return np.array(
            [[farthest_m(self.distances_m, n) for n in counted] for counted in self.detected]
        )

    def farthest_at(self, gap_m: float) -> Estimate:
        """Return the largest distance for the opening nearest to `gap_m`."""
        return mean_of(self.farthest_m[:, np.argmin(np.abs(self.gaps_m - gap_m))])

    def share_at(self, gap_m: float, distance_m: float) -> Estimate:
        """Return the share of the nearest pass's readings that still detect the opening."""
        gap = np.argmin(np.abs(self.gaps_m - gap_m))
        distance = np.argmin(np.abs(self.distances_m - distance_m))
        counted = self.detected[:, gap]
        return mean_of(counted[:, distance] / np.where(counted[:, 0] > 0, counted[:, 0], np.nan))

    @cached_property
    def fits(self) -> list[Line]:
        """The line through the points of each seed."""
        return [
            Line(*np.polyfit(self.gaps_m[told], row[told], 1))
            for row in self.farthest_m
            if (told := np.isfinite(row)).sum() >= 2
        ]

    @property
    def slope(self) -> Estimate:
        return mean_of([line.slope for line in self.fits])

    @property
    def offset_m(self) -> Estimate:
        return mean_of([line.offset_m for line in self.fits])


@dataclass(frozen=True)
class _Driven:
    """One pass of the robot at `distance_m`.

    `detected` readings told the opening; on the bench, at the same places, `on_bench` did, and
    `agreeing` of all `readings` tell the same.
    """

    distance_m: float
    detected: int
    on_bench: int
    agreeing: int
    readings: int


def run(setting: Setting) -> Section:
    """Pass openings of many widths at many distances."""
    sonar = preset(setting.sonar)
    near_m = max(round(sonar.ring.range_min_m - _TOO_CLOSE_M, 3), _NEAREST_ALLOWED_M)
    gaps_m, step_m = _sweep(setting)
    # Beyond the last one the boards come near the end of the range, and silence tells nothing.
    far_m = sonar.ring.range_max_m - _BEYOND_M
    distances_m = np.concatenate([[near_m], np.arange(near_m + step_m, far_m, step_m)])
    tasks = [(setting.sonar, tuple(gaps_m), tuple(distances_m), seed) for seed in setting.seeds]
    detected = np.array(setting.map(_passes, tasks, "passing openings"))
    swept = _Swept(gaps_m, distances_m, detected)
    rig = worlds.load(_ROOM)
    theory = derived(seeing_half_angle_rad(sonar, rig), near_m)
    driven = _drive(setting, sonar, near_m)
    return Section(
        "openings",
        "Openings and the sonar's distance (section 6.3)",
        (
            _curve(setting, swept, theory),
            _equation(setting, swept, theory, sonar, rig, near_m),
            _check(setting, driven),
        ),
        (Answer(6, _answer(swept, theory)),),
    )


def derived(half_angle_rad: float, near_m: float) -> Line:
    """Return the equation of the largest distance from which an opening is seen.

    A sonar that looks at the boards squarely hears one of them as soon as the edge of its cone
    touches it, since a ray at the edge meets the board at no more than the critical angle. It
    passes an opening ``g`` wide unheard on a way of ``g - 2 d tan b`` only. The share ``q`` of
    the nearest pass's way, ``g - 2 d_near tan b``, is left at
    ``d = (1 - q) / (2 tan b) g + q d_near``.

    Parameters
    ----------
    half_angle_rad : float
        ``b``, see `seeing_half_angle_rad`.
    near_m : float
        ``d_near``, the distance of the nearest pass, metres.
    """
    return Line((1 - SHARE) / (2 * math.tan(half_angle_rad)), SHARE * near_m)


def seeing_half_angle_rad(sonar: Sonar, rig: World) -> float:
    """Return the largest bearing at which a squarely met board still returns sound, radians.

    Beyond the cone no sound goes; beyond the board's critical incidence none comes back.
    """
    return min(sonar.ring.half_angle_rad, float(rig.critical_incidence_rad.min()))


def counts(
    sonar: Sonar,
    gap_m: float,
    distances_m: NDArray[np.float64],
    first_m: float,
    rng: np.random.Generator,
) -> NDArray[np.int64]:
    """Return how many readings of a pass detect an opening, at each distance.

    Parameters
    ----------
    sonar : Sonar
        Whose acoustics; it reads once a scan period, at the driver's speed.
    gap_m : float
        Width of the opening, metres.
    distances_m : ndarray, shape (n,)
        Distances of the passes from the boards, metres.
    first_m : float
        Where the readings begin, metres along the boards: below one step, at random.
    rng : numpy.random.Generator
        Noise of the readings.
    """
    step_m = _SPEED_MPS * sonar.firing.period_s
    # Before and behind the opening there is nothing but board.
    half = math.ceil(gap_m / 2 / step_m) + 1
    along_m = np.arange(-half, half + 1) * step_m + first_m
    rig = worlds.load(_ROOM, gap_m=gap_m)
    d, x = np.meshgrid(distances_m, along_m, indexing="ij")
    heard = readings(sonar, rig, np.column_stack([x.ravel(), -d.ravel()]), np.pi / 2, rng)
    counted: NDArray[np.int64] = (_detects(heard.reshape(d.shape), d)).sum(axis=1)
    return counted


def farthest_m(distances_m: NDArray[np.float64], detected: NDArray[np.int64]) -> float:
    """Return the largest distance with at least `SHARE` of the nearest pass's readings.

    Between the last distance with enough and the next: their middle. NaN if the nearest pass
    detects nothing, or the farthest still enough.
    """
    enough = detected >= SHARE * detected[0]
    if detected[0] == 0 or enough.all():
        return math.nan
    first_without = int(np.argmin(enough))
    return float(distances_m[first_without - 1 : first_without + 1].mean())


def _detects(
    heard_m: NDArray[np.float64], distance_m: NDArray[np.float64] | float
) -> NDArray[np.bool_]:
    """Return which readings are clearly beyond the boards; too close (-inf) means a board."""
    return heard_m > distance_m + _BEYOND_M


def _sweep(setting: Setting) -> tuple[NDArray[np.float64], float]:
    """Return the openings' widths and the step between distances, metres."""
    if setting.quick:
        return np.round(np.arange(0.2, 1.61, 0.2), 3), 0.02
    return np.round(np.arange(0.2, 1.61, 0.1), 3), 0.01


def _passes(task: tuple[str, tuple[float, ...], tuple[float, ...], int]) -> NDArray[np.int64]:
    """Return the counts of one seed, shape (gaps, distances)."""
    name, gaps_m, distances_m, seed = task
    sonar, rng = preset(name), np.random.default_rng(seed)
    # The robot's scans know nothing of the opening's edges, so the first lies anywhere.
    step_m = _SPEED_MPS * sonar.firing.period_s
    distances = np.array(distances_m)
    return np.array([counts(sonar, gap, distances, rng.uniform(0, step_m), rng) for gap in gaps_m])


def _drive(setting: Setting, sonar: Sonar, near_m: float) -> list[_Driven]:
    """Pass the thesis's opening with the robot, and again on the bench from the same places."""
    rig = worlds.load(_ROOM, gap_m=_THESIS_GAP_M)
    way_m = _THESIS_GAP_M / 2 + 0.2 - rig.start.x_m
    scans = math.ceil(way_m / (_SPEED_MPS * sonar.firing.period_s))
    left = int(np.argmin(np.abs(sonar.ring.heading_rad - np.pi / 2)))
    passed = []
    for distance_m in (near_m, *(_DRIVEN_M[::2] if setting.quick else _DRIVEN_M)):
        parameters = {"gap_m": _THESIS_GAP_M, "distance_m": distance_m}
        (log,) = setting.logs(
            _ROOM, driver="straight", scans=scans, seeds=[_DRIVEN_SEED], parameters=parameters
        )
        xy_m, axis_rad = _true_places(log, left)
        again = readings(sonar, rig, xy_m, axis_rad, np.random.default_rng(_DRIVEN_SEED))
        by_robot = _detects(log.range_m[log.sonar == left], distance_m)
        on_bench = _detects(again, distance_m)
        passed.append(
            _Driven(
                distance_m,
                int(by_robot.sum()),
                int(on_bench.sum()),
                int((by_robot == on_bench).sum()),
                by_robot.size,
            )
        )
    return passed


def _true_places(log: sm.SonarLog, sonar: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where a sonar truly was at its readings, (n, 2), and its axis, (n,)."""
    rows, truth, ring = log.sonar == sonar, log.truth, log.ring
    assert truth is not None  # a simulated log has it
    heading = truth.heading_rad[rows]
    cos, sin = np.cos(heading), np.sin(heading)
    x_m = truth.x_m[rows] + cos * ring.x_m[sonar] - sin * ring.y_m[sonar]
    y_m = truth.y_m[rows] + sin * ring.x_m[sonar] + cos * ring.y_m[sonar]
    return np.column_stack([x_m, y_m]), heading + ring.heading_rad[sonar]


def _curve(setting: Setting, swept: _Swept, theory: Line) -> Item:
    seen = swept.farthest_at(_THESIS_GAP_M)
    share = swept.share_at(_THESIS_GAP_M, _THESIS_FARTHEST_M)
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
        (_figure(setting, swept, theory),),
        (_table(setting, swept, theory),),
    )


def _equation(
    setting: Setting, swept: _Swept, theory: Line, sonar: Sonar, rig: World, near_m: float
) -> Item:
    slope, offset_m = swept.slope, swept.offset_m
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
            *_numbers(mean_of([line.at(_THESIS_GAP_M) for line in swept.fits]), 4),
        ),
    ]
    table = setting.table(
        "equation",
        ("of the line", "derived", "fitted", "low", "high"),
        rows,
        f"d_max = slope * g + offset, a fit for each of {len(setting.seeds)} seeds, 95 % interval",
    )
    return Item(
        "Section 6.5, future work 5",
        "The relation between openings and distances should become an equation, instead of a "
        "curve to interpolate.",
        finding,
        tables=(table,),
    )


def _check(setting: Setting, driven: list[_Driven]) -> Item:
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
    table = setting.table(
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


def _answer(swept: _Swept, theory: Line) -> str:
    seen = swept.farthest_at(_THESIS_GAP_M)
    if not math.isfinite(seen.value):
        return f"Openings: no limit of a {_THESIS_GAP_M:g} m opening was found within the range."
    near = abs(seen.value / _THESIS_FARTHEST_M - 1) <= _NEAR
    share = swept.share_at(_THESIS_GAP_M, _THESIS_FARTHEST_M)
    return (
        f"Openings: {'near' if near else 'not near'} {_THESIS_FARTHEST_M:g} m (within "
        f"{_NEAR:.0%}): a {_THESIS_GAP_M:g} m opening is seen in {SHARE:.0%} of the readings up to "
        f"{seen.text(3)} m ({_off(seen.value)}); at {_THESIS_FARTHEST_M:g} m "
        f"{share.text(1, factor=100)} % are left. Derived: d_max = {theory.slope:.3f} g + "
        f"{theory.offset_m:.3f} m; fitted: {swept.slope.text(3)} g + {swept.offset_m.text(3)} m."
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


def _table(setting: Setting, swept: _Swept, theory: Line) -> tuple[str, str]:
    rows = [
        (
            f"{gap:g}",
            *_numbers(mean_of(swept.farthest_m[:, i]), 3),
            f"{float(theory.at(gap)):.3f}",
            f"{mean_of(swept.detected[:, i, 0]).value:.1f}",
        )
        for i, gap in enumerate(swept.gaps_m)
    ]
    return setting.table(
        "openings",
        ("opening g, m", "d_max, m", "low", "high", "derived, m", "n, nearest pass"),
        rows,
        f"Largest distance at which {SHARE:.0%} of the readings detect the opening, "
        f"{len(setting.seeds)} seeds, 95 % interval",
    )


def _figure(setting: Setting, swept: _Swept, theory: Line) -> tuple[str, str]:
    figure, (left, right) = figure_with(1, 2)
    for gap_m, colour in zip((0.4, 0.8, 1.2, 1.6), COLOURS, strict=False):
        gap = int(np.argmin(np.abs(swept.gaps_m - gap_m)))
        counted = swept.detected[:, gap]
        share = (counted / np.maximum(counted[:, :1], 1)).mean(axis=0)
        left.plot(swept.distances_m, share, color=colour, label=f"g = {swept.gaps_m[gap]:g} m")
    left.axhline(SHARE, color="#888888", ls="--", lw=1)
    left.set_xlabel("distance from the boards, m")
    left.set_ylabel("readings that detect it, of the nearest pass")
    left.set_xlim(0, 2.6)
    left.set_ylim(bottom=0)
    left.legend(fontsize=9)

    gaps = np.array([0.0, 1.7])
    right.plot(gaps, theory.at(gaps), color="#888888", label="derived from the cone")
    if swept.fits:
        fit = Line(swept.slope.value, swept.offset_m.value)
        right.plot(gaps, fit.at(gaps), ls="--", color=COLOURS[1], label="fitted")
    means = [mean_of(swept.farthest_m[:, i]) for i in range(swept.gaps_m.size)]
    right.errorbar(
        swept.gaps_m,
        [mean.value for mean in means],
        [[mean.value - mean.low for mean in means], [mean.high - mean.value for mean in means]],
        fmt="o",
        ms=4,
        color=COLOURS[0],
        label=f"simulated, {SHARE:.0%} of the readings",
    )
    right.plot(
        _THESIS_GAP_M, _THESIS_FARTHEST_M, "*", ms=13, color=COLOURS[4], label="the thesis's rule"
    )
    right.set_xlabel("opening g, m")
    right.set_ylabel("largest distance d_max, m")
    right.set_xlim(0, 1.7)
    right.set_ylim(bottom=0)
    right.legend(fontsize=9)
    return setting.figure(
        "openings", figure, "Readings left with distance, and the largest distance by the width"
    )
