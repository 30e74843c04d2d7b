"""Figure 6.12: the derived equation of openings against passes by them."""

import math

import numpy as np
import pytest

import sonarbed.studies.thesis.openings.study as study
import worlds
from sim.sonar.presets import preset
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.openings.passes import (
    SHARE,
    Line,
    Passes,
    counts,
    derived,
    farthest_m,
    seeing_half_angle_rad,
)

PERFECT = preset("thesis").replace(noise_std_m=0, quantum_m=0)
# A scan period so short that readings follow each other every millimetre.
DENSE = PERFECT.replace(scan_period_s=0.01)


def test_derived_line_of_the_thesis():
    line = derived(math.radians(15), 0.15)
    assert line.slope == pytest.approx(0.7464, abs=1e-4)
    assert line.offset_m == pytest.approx(0.09)
    assert float(line.at(0.8)) == pytest.approx(0.687, abs=1e-3)


def test_derived_line_leaves_the_share_of_the_way():
    half, near_m, gap_m = math.radians(12), 0.1, 0.7
    d = float(derived(half, near_m).at(gap_m))
    unheard = [gap_m - 2 * distance * math.tan(half) for distance in (d, near_m)]
    assert unheard[0] / unheard[1] == pytest.approx(SHARE)


@pytest.mark.parametrize("gap_m", [0.3, 0.8, 1.6])
def test_dense_passes_count_the_way_on_which_the_cone_is_clear(rng, gap_m):
    distances_m = np.array([0.15, 0.5, 1.0, 2.0])
    counted = counts(DENSE, gap_m, distances_m, 0.0, rng)
    clear_m = np.maximum(gap_m - 2 * distances_m * math.tan(math.radians(15)), 0)
    assert counted * 0.001 == pytest.approx(clear_m, abs=0.0011)


@pytest.mark.parametrize("gap_m", [0.4, 0.8, 1.2])
def test_dense_passes_end_where_the_derived_line_says(rng, gap_m):
    expected_m = float(derived(math.radians(15), 0.15).at(gap_m))
    distances_m = np.array([0.15, *np.linspace(expected_m - 0.06, expected_m + 0.06, 41)])
    found_m = farthest_m(distances_m, counts(DENSE, gap_m, distances_m, 0.0, rng))
    # One reading is 1 mm of way, 1.9 mm of distance.
    assert found_m == pytest.approx(expected_m, abs=0.005)


def test_boards_too_close_to_be_told_count_as_boards(rng):
    assert counts(DENSE, 0.05, np.array([0.1, 0.15]), 0.0, rng).tolist() == [0, 0]


def test_no_opening_is_never_detected(rng):
    assert not counts(PERFECT, 0.0, np.array([0.15, 1.0, 2.5]), 0.0, rng).any()


def test_the_boards_critical_angle_limits_a_wide_cone():
    rig = worlds.load("opening-rig")
    assert math.degrees(seeing_half_angle_rad(PERFECT, rig)) == pytest.approx(15)
    assert math.degrees(float(rig.critical_incidence_rad.min())) == pytest.approx(20)


@pytest.mark.parametrize(
    ("detected", "expected"),
    [
        ([10, 8, 6, 5, 0], 0.35),  # 6 of 10 are just enough
        ([10, 5, 9, 0, 0], 0.15),  # the first time that it falls below counts
        ([10, 10, 9, 8, 7], math.nan),  # never within these distances
        ([0, 0, 0, 0, 0], math.nan),  # nothing to compare with
    ],
)
def test_largest_distance_lies_between_enough_and_too_few(detected, expected):
    distances_m = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    assert farthest_m(distances_m, np.array(detected)) == pytest.approx(expected, nan_ok=True)


@pytest.fixture
def tiny(monkeypatch):
    monkeypatch.setattr(study, "_sweep", lambda context: (np.array([0.4, 0.8]), 0.05))
    monkeypatch.setattr(study, "_DRIVEN_M", (0.7,))


@pytest.mark.engine
def test_tiny_study_tells_the_equation_and_agrees_with_the_driven_robot(tmp_path, tiny):
    context = StudyContext(tmp_path, quick=True, jobs=1, study="openings")
    section = study.run(context)
    section.save(context.study_folder)
    curve, equation, check = section.items
    assert "800 mm" in curve.source
    assert "d_max = 0.746 g + 0.090 m" in equation.finding
    assert "b = 12.7 degrees" in equation.finding
    agreeing, total = (
        int(word) for word in check.finding.split() if word.isdigit() and int(word) > 10
    )
    assert total - agreeing <= 2
    assert section.answers[0].question == 6
    for item in section.items:
        for file, _ in item.figures + item.tables:
            assert (context.study_folder / file).stat().st_size > 0


def test_findings_follow_the_numbers():
    distances_m = np.arange(0.1, 2.0, 0.1)
    theory = Line(0.75, 0.09)
    gaps_m = np.array([0.4, 0.8])
    # Every opening is seen to 0.85 m, then not at all.
    seen = np.where(distances_m < 0.85, 10, 0)
    to_the_rule = Passes(gaps_m, distances_m, np.broadcast_to(seen, (3, 2, seen.size)))
    assert study._answer(to_the_rule, theory).startswith("Openings: near 0.8 m")
    assert to_the_rule.slope.value == pytest.approx(0, abs=1e-9)
    short = np.where(distances_m < 0.35, 10, 0)
    too_near = Passes(gaps_m, distances_m, np.broadcast_to(short, (3, 2, short.size)))
    assert study._answer(too_near, theory).startswith("Openings: not near 0.8 m")
    never = Passes(gaps_m, distances_m, np.zeros((3, 2, seen.size), int))
    assert "no limit" in study._answer(never, theory)
    assert math.isnan(never.slope.value)
