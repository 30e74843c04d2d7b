"""Figure 6.11: how far readings of one distance differ between the axis and the cone's edge."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sim.sonar.presets import preset
from sim.sonar.protocol import Sonar
from sonarbed.reporting.bench import board, post, readings, scene
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item
from sonarbed.reporting.statistics import Estimate, mean_of
from sonarbed.studies.thesis.questions import Answer, ThesisSection
from sonarmap import SonarRing
from worlds import World

__all__ = ["edge_readings", "excess_m", "run"]

# What the thesis measured with its target 2 m away, and what it settled on; pp. 55 and 56.
_THESIS_AT_M, _THESIS_R1_M, _THESIS_R2_M, _THESIS_TDTH_M = 2.0, 2.005, 2.067, 0.060
# The distances that it averaged over.
_AVERAGED_M = (1.0, 3.0)
_NEAR = 0.25  # "near" a number of the thesis: within this share of it

_DISTANCES_M = np.round(np.arange(0.5, 3.0, 0.3), 3)
# The target is moved sideways in such steps; 2 mm at the edge of a 30 degree cone are 0.5 mm of
# range. Each seed begins its steps elsewhere.
_STEP_M = 0.002
# As many readings at each place: seen is what most of them see.
_FIRINGS = 5


def _targets() -> dict[str, World]:
    # Both wider than the space between two rays of the simple cone's fan at 3 m, 52 mm; of the
    # post that is the part that does not mirror the sound away.
    return {
        "flat board of 0.2 m": scene(board("board", 0.2, material="smooth-cardboard")),
        "round post of 80 mm": scene(post("post", 0.04, material="brick")),
    }


@dataclass(frozen=True, eq=False)
class _Measured:
    """Readings of one target, each array of shape (seeds, distances); NaN where it is not seen."""

    target: str
    axis_m: NDArray[np.float64]
    edge_m: NDArray[np.float64]

    @property
    def excess_m(self) -> NDArray[np.float64]:
        return self.edge_m - self.axis_m

    def excess_at(self, distance_m: float) -> Estimate:
        """Return the difference at the distance of the series that is nearest."""
        return mean_of(self.excess_m[:, np.argmin(np.abs(_DISTANCES_M - distance_m))])

    @property
    def averaged(self) -> Estimate:
        """The mean over the distances that the thesis averaged over."""
        low_m, high_m = _AVERAGED_M
        inside = [low_m <= d <= high_m for d in _DISTANCES_M]
        return mean_of(self.excess_m[:, inside].mean(axis=1))

    @property
    def per_metre(self) -> Estimate:
        """The difference as a share of the distance."""
        return mean_of((self.excess_m / _DISTANCES_M).mean(axis=1))


def run(context: StudyContext) -> ThesisSection:
    """Move targets to the edge of the cone at several distances."""
    sonar = preset(context.sonar)
    tasks = [
        (context.sonar, target, tuple(_DISTANCES_M), seed)
        for target in _targets()
        for seed in context.seeds
    ]
    found = iter(context.map(_measured, tasks, "moving targets to the edge"))
    measured = []
    for target in _targets():
        pairs = np.array([next(found) for _ in context.seeds])
        measured.append(_Measured(target, pairs[:, 0], pairs[:, 1]))
    expected_m = excess_m(_DISTANCES_M, sonar.ring)
    return ThesisSection(
        "target_distance",
        "The target distance threshold (section 6.2)",
        (_item(context, sonar, measured, expected_m),),
        (Answer(6, _answer(measured)),),
    )


def excess_m(distance_m: ArrayLike, ring: SonarRing) -> NDArray[np.float64]:
    """Return how much longer than its distance a target at the cone's edge is read, metres.

    It stands in the plane at that distance: ``d (1 / cos(half angle) - 1)``, as long as the way
    to it is within the sonar's range.
    """
    d = np.asarray(distance_m, float)
    way_m = np.minimum(d / math.cos(ring.half_angle_rad), ring.range_max_m)
    excess: NDArray[np.float64] = way_m - d
    return excess


def edge_readings(
    sonar: Sonar, world: World, distance_m: float, rng: np.random.Generator
) -> tuple[float, float]:
    """Return what is read on the axis and at the farthest place across where it is still seen.

    The target touches x = 0 in the origin. Instead of it the sonar is moved, `distance_m` before
    that plane. "Still seen" is from the axis outwards to the first place where most firings are
    silent: a side lobe beyond does not count.

    Returns
    -------
    axis_m, edge_m : float
        Mean readings, metres; both NaN if the target is not even seen on the axis.
    """
    widest_m = distance_m * math.tan(min(2 * sonar.ring.half_angle_rad, math.radians(80))) + 0.2
    steps = np.arange(0.0, widest_m, _STEP_M) + rng.uniform(0, _STEP_M)
    across_m = np.concatenate([[0.0], steps])
    xy_m = np.column_stack([np.full(across_m.size, -distance_m), -across_m])
    fired = readings(sonar, world, np.repeat(xy_m, _FIRINGS, axis=0), 0.0, rng)
    fired = fired.reshape(-1, _FIRINGS)
    seen = np.isfinite(fired).mean(axis=1) > 0.5
    if not seen[0]:
        return math.nan, math.nan
    last = seen.size - 1 if seen.all() else int(np.argmin(seen)) - 1
    axis, edge = fired[0], fired[last]
    return float(axis[np.isfinite(axis)].mean()), float(edge[np.isfinite(edge)].mean())


def _measured(task: tuple[str, str, tuple[float, ...], int]) -> NDArray[np.float64]:
    """Return readings on the axis and at the edge, shape (2, distances), of one seed."""
    sonar, target, distances_m, seed = task
    rng = np.random.default_rng(seed)
    world = _targets()[target]
    return np.array([edge_readings(preset(sonar), world, d, rng) for d in distances_m]).T


def _item(
    context: StudyContext, sonar: Sonar, measured: list[_Measured], expected_m: NDArray[np.float64]
) -> Item:
    thesis_m = _THESIS_R2_M - _THESIS_R1_M
    at_m = [f"{one.excess_at(_THESIS_AT_M).text(1, factor=1e3)} mm" for one in measured]
    means = [f"{one.averaged.text(1, factor=1e3)} mm" for one in measured]
    names = [one.target for one in measured]
    arithmetic = float(excess_m(_THESIS_AT_M, sonar.ring))
    implied_deg = math.degrees(math.acos(_THESIS_R1_M / _THESIS_R2_M))
    finding = (
        f"At {_THESIS_AT_M:g} m the edge is read {_each(names, at_m)} longer than the axis, where "
        f"the thesis measured {thesis_m * 1e3:.0f} mm; the cone's arithmetic, d (1/cos b - 1) with "
        f"b = {math.degrees(sonar.ring.half_angle_rad):.1f} degrees, says {arithmetic * 1e3:.1f} "
        f"mm. Averaged over {_AVERAGED_M[0]:g} to {_AVERAGED_M[1]:g} m it is {_each(names, means)} "
        f"against {_THESIS_TDTH_M * 1e3:.0f} mm. {_shape(*measured)}"
        f"{_growth(measured[0])} The thesis's own pair is that of a cone of "
        f"{implied_deg:.1f} degrees to either side."
    )
    return Item(
        "Figure 6.11",
        "A target 2 m away is read as 2005 mm on the axis and as 2067 mm at the farthest place "
        "across where it is still seen: 62 mm. The mean over distances from 1 to 3 m gives "
        "TDTh = 60 mm.",
        finding,
        (_figure(context, measured, sonar.ring),),
        (_table(context, measured, expected_m),),
    )


def _shape(flat: _Measured, round_: _Measured) -> str:
    if mean_of((round_.excess_m - flat.excess_m).mean(axis=1)).sign <= 0:
        return ""
    return "A round target reads longer still: last of it, its receding side is in the cone. "


def _growth(one: _Measured) -> str:
    share = one.per_metre
    first, last = (mean_of(one.excess_m[:, i]).value for i in (0, -1))
    if not math.isfinite(share.value):
        return "It is not seen at every distance, so nothing is said of its growth."
    # One threshold fits all distances only if the difference does not grow with them.
    if last > 1.5 * first:
        verdict = "it grows with the distance, so one threshold for all ranges is a compromise"
    else:
        verdict = "it hardly grows with the distance, so one threshold does for all ranges"
    return (
        f"From {_DISTANCES_M[0]:g} to {_DISTANCES_M[-1]:g} m it goes from {first * 1e3:.0f} to "
        f"{last * 1e3:.0f} mm ({one.target}; {share.text(2, factor=100)} % of the distance): "
        f"{verdict}."
    )


def _answer(measured: list[_Measured]) -> str:
    clauses = [_near(one.target, one.averaged) for one in measured]
    return (
        f"TDTh against the thesis's {_THESIS_TDTH_M * 1e3:.0f} mm, averaged over "
        f'{_AVERAGED_M[0]:g} to {_AVERAGED_M[1]:g} m: {"; ".join(clauses)}. "Near" is within '
        f"{_NEAR:.0%}."
    )


def _near(target: str, mean: Estimate) -> str:
    if not math.isfinite(mean.value):
        return f"the {target} is not seen at every distance"
    off = mean.value / _THESIS_TDTH_M - 1
    verdict = "near" if abs(off) <= _NEAR else "not near"
    return f"{verdict} for a {target}, {mean.text(1, factor=1e3)} mm ({off:+.0%})"


def _each(names: list[str], texts: list[str]) -> str:
    return " and ".join(f"{text} ({name})" for name, text in zip(names, texts, strict=True))


def _table(
    context: StudyContext, measured: list[_Measured], expected_m: NDArray[np.float64]
) -> tuple[str, str]:
    rows = []
    for one in measured:
        for i, d in enumerate(_DISTANCES_M):
            r1, r2, excess = (
                mean_of(values[:, i]) for values in (one.axis_m, one.edge_m, one.excess_m)
            )
            numbers = (r1.value, r2.value, excess.value, excess.low, excess.high, expected_m[i])
            rows.append((one.target, f"{d:g}", *(f"{number * 1e3:.1f}" for number in numbers)))
    return context.table(
        "target_distance",
        ("target", "d, m", "r1, mm", "r2, mm", "r2 - r1, mm", "low", "high", "arithmetic, mm"),
        rows,
        f"Readings on the axis (r1) and at the edge (r2), {len(context.seeds)} seeds, 95 % "
        "interval of the difference",
    )


def _figure(context: StudyContext, measured: list[_Measured], ring: SonarRing) -> tuple[str, str]:
    figure, (axes,) = figure_with(width=7.5, height=4.6)
    d = np.linspace(0, 3, 301)
    axes.plot(
        d,
        excess_m(d, ring) * 1e3,
        color="#888888",
        label=f"d (1/cos {math.degrees(ring.half_angle_rad):.0f}° - 1), within the range",
    )
    for one, colour, shift_m in zip(measured, COLOURS, (-0.012, 0.012), strict=False):
        means = [mean_of(one.excess_m[:, i]) for i in range(_DISTANCES_M.size)]
        value = np.array([mean.value for mean in means]) * 1e3
        bars = [
            [(mean.value - mean.low) * 1e3 for mean in means],
            [(mean.high - mean.value) * 1e3 for mean in means],
        ]
        axes.errorbar(
            _DISTANCES_M + shift_m, value, bars, fmt="o", ms=4, color=colour, label=one.target
        )
    axes.axhline(_THESIS_TDTH_M * 1e3, color=COLOURS[2], ls="--", label="the thesis's TDTh, 60 mm")
    axes.plot(
        _THESIS_AT_M,
        (_THESIS_R2_M - _THESIS_R1_M) * 1e3,
        "*",
        ms=13,
        color=COLOURS[4],
        label="the thesis at 2 m, 62 mm",
    )
    axes.set_xlabel("distance d, m")
    axes.set_ylabel("r2 - r1, mm")
    axes.set_xlim(0, 3.05)
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=9)
    return context.figure(
        "target_distance", figure, "Difference of the readings at the cone's edge and on its axis"
    )
