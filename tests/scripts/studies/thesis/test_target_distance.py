"""Figure 6.11: readings at the cone's edge against its arithmetic."""

import math

import numpy as np
import pytest

import sonarbed.studies.thesis.target_distance as study
from sim.sonar.presets import preset
from sonarbed.reporting.bench import board, post, readings, scene
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.target_distance import edge_readings, excess_m, run

PERFECT = preset("thesis").replace(noise_std_m=0, quantum_m=0)
BOARD = scene(board("board", 0.2, material="whiteboard"))


def test_arithmetic_is_that_of_a_right_triangle():
    # 2 m and the thesis's half-angle, 15 degrees; its own 62 mm are those of 14.07 degrees.
    assert excess_m(2.0, PERFECT.ring) == pytest.approx(0.07055, abs=1e-5)
    assert math.degrees(math.acos(2005 / 2067)) == pytest.approx(14.07, abs=0.01)


def test_arithmetic_ends_with_the_range():
    assert excess_m([2.95, 3.0], PERFECT.ring) == pytest.approx([0.05, 0.0])


@pytest.mark.parametrize("distance_m", [0.5, 1.0, 2.0, 2.8])
def test_a_perfect_cone_loses_a_board_where_arithmetic_says(rng, distance_m):
    world = scene(board("board", 0.2, material="whiteboard"))
    # A material's roughness adds to the noise of a range.
    axis_m, edge_m = edge_readings(PERFECT, world, distance_m, rng)
    assert axis_m == pytest.approx(distance_m, abs=2e-3)
    # The last step ends up to 2 mm before the edge, where a ray of the fan may meet it.
    assert edge_m - axis_m == pytest.approx(float(excess_m(distance_m, PERFECT.ring)), abs=3e-3)


def test_a_narrower_cone_reads_a_smaller_difference(rng):
    half = PERFECT.ring.half_angle_rad / 2
    narrow = PERFECT.replace(ring=_with_half_angle(PERFECT.ring, half))
    axis_m, edge_m = edge_readings(narrow, BOARD, 2.0, rng)
    assert edge_m - axis_m == pytest.approx(2 * (1 / math.cos(half) - 1), abs=3e-3)


def test_a_mirror_of_small_critical_angle_is_lost_before_the_edge(rng):
    # Glass returns up to 18 degrees: a cone of 30 to either side sees the board no farther. Rays
    # lie 0.24 degrees apart, and none at 18 itself.
    wide = PERFECT.replace(ring=_with_half_angle(PERFECT.ring, math.radians(30)), rays=249)
    axis_m, edge_m = edge_readings(wide, scene(board("b", 0.2, material="glass")), 1.0, rng)
    assert edge_m - axis_m == pytest.approx(1 / math.cos(math.radians(18)) - 1, abs=3e-3)


def test_what_is_not_seen_on_the_axis_is_nan(rng):
    assert np.isnan(edge_readings(PERFECT, BOARD, 3.5, rng)).all()


def test_bench_puts_the_face_of_things_on_the_axis(rng):
    for solid in (board("it", 0.2, material="glass"), post("it", 0.04, material="glass")):
        (heard,) = readings(PERFECT, scene(solid), np.array([[-1.0, 0.0]]), 0.0, rng)
        assert heard == pytest.approx(1.0, abs=2e-3)


def test_tiny_study_tells_the_thesis_and_ours(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "_DISTANCES_M", np.array([1.0, 2.0]))
    context = StudyContext(tmp_path, quick=True, jobs=1, study="target_distance")
    section = run(context)
    section.save(context.study_folder)
    (item,), (answer,) = section.items, section.answers
    assert "2005 mm" in item.source
    assert "60 mm" in answer.text
    assert "says 70.6 mm" in item.finding
    for file, _ in item.figures + item.tables:
        assert (context.study_folder / file).stat().st_size > 0


def test_findings_follow_the_numbers(tmp_path, monkeypatch):
    flat = np.full((3, 9), 0.060)
    axis = np.broadcast_to(study._DISTANCES_M, flat.shape)
    same = study._Measured("board", axis, axis + flat)
    assert "near for a board, 60.0" in study._answer([same])
    assert "it hardly grows" in study._growth(same)
    far = study._Measured("board", axis, axis * 1.1)
    assert "not near for a board, 200.0" in study._answer([far])
    assert "it grows with the distance" in study._growth(far)
    lost = study._Measured("board", axis * np.nan, axis)
    assert "not seen" in study._answer([lost])
    assert "not seen" in study._growth(lost)


def _with_half_angle(ring, half_angle_rad):
    return type(ring)(
        ring.name,
        ring.x_m,
        ring.y_m,
        ring.heading_rad,
        half_angle_rad,
        ring.range_min_m,
        ring.range_max_m,
    )
