"""Conflict evaluation: against plain loops, by hand, and in a drawn scene."""

import math

import numpy as np
import pytest
from noise_free import WIDE
from support import make_log, random_log

import sonarmap as sm
from sonarmap.filters.conflict_evaluation import sound_pressure

NAME = "conflict-evaluation-style"


def plain(f, log):
    """(wrong, nearest occupied in the cone) of each usable reading, by loops over cells."""
    rows = [i for i in range(len(log)) if log.usable[i] and log.range_m[i] >= 0]
    size, longest = f.cell_m, log.ring.range_max_m
    cones = {}
    for i in rows:
        x, y = log.sensor_xy_m[i]
        reading = log.range_m[i]
        echo = reading <= longest
        reach = reading + f.thickness_m if echo else longest
        span = int(reach / size) + 3
        cones[i] = {}
        for col in range(math.floor(x / size) - span, math.floor(x / size) + span):
            for row in range(math.floor(y / size) - span, math.floor(y / size) + span):
                dx, dy = (col + 0.5) * size - x, (row + 0.5) * size - y
                r = math.hypot(dx, dy)
                off = math.remainder(math.atan2(dy, dx) - log.axis_rad[i], 2 * math.pi)
                if r > reach or abs(off) > log.ring.half_angle_rad:
                    continue
                arc = echo and r >= reading - f.thickness_m
                away = r / 2 if arc and reading <= f.short_m else r
                t = math.degrees(abs(off))
                loud = -0.00102 * t**2 + 0.00241 * t - math.log10(1000 * away)
                cones[i][col, row] = (r, arc, loud)
    best = {}
    for i in rows:
        for at, (_, arc, loud) in cones[i].items():
            best[at] = max(best.get(at, (-math.inf, False)), (loud, arc))
    for i in rows:
        col, row = (math.floor(value / size) for value in (log.x_m[i], log.y_m[i]))
        for d_col in range(-f.path_cells, f.path_cells + 1):
            for d_row in range(-f.path_cells, f.path_cells + 1):
                best.pop((col + d_col, row + d_row), None)
    verdicts = {}
    for i in rows:
        occupied = [(r, arc) for at, (r, arc, _) in cones[i].items() if best.get(at, (0, False))[1]]
        nearest = min((r for r, _ in occupied), default=math.inf)
        if log.range_m[i] <= longest:
            near = nearest < log.range_m[i] - f.thickness_m
            wrong = near or not any(arc for _, arc in occupied)
        else:
            wrong = bool(occupied)
        verdicts[i] = (wrong, nearest)
    return verdicts


@pytest.mark.parametrize("parameters", [{}, {"path_cells": 0, "thickness_m": 0.15}])
def test_equals_plain_loops(parameters, rng):
    log = random_log(rng, 60)
    f = sm.filter(NAME, **parameters)
    made = f.apply(log)
    for i, (wrong, nearest) in plain(f, log).items():
        if not wrong:
            assert made.predicted_range_m[i] == log.range_m[i]
            assert not made.changed[i]
            assert not made.rejected[i]
        elif nearest < log.range_m[i]:
            assert made.log.range_m[i] == pytest.approx(nearest)
            assert made.changed[i]
            assert not made.rejected[i]
        else:
            assert made.rejected[i]
            assert math.isnan(made.predicted_range_m[i])


def test_the_sound_pressure_is_that_of_the_description():
    # On the axis at 1 m and at 100 mm; at 10 degrees.
    np.testing.assert_allclose(sound_pressure(np.array([1.0, 0.1]), np.zeros(2)), [-3, -2])
    off = sound_pressure(np.array([1.0]), np.array([-math.radians(10)]))
    np.testing.assert_allclose(off, -0.00102 * 100 + 0.00241 * 10 - 3)
    # Half as far away is louder by log10 2, the description's 0.301.
    near = sound_pressure(np.array([0.5]), np.zeros(1))
    np.testing.assert_allclose(near, -3 + 0.301, atol=1e-3)
    assert np.isfinite(sound_pressure(np.zeros(1), np.zeros(1))).all()


def past_a_wall():
    """Three near looks at a wall 1 m ahead, one from afar that says 3 m, and one without echo."""
    return make_log(
        [1.0, 1.0, 1.0, 3.0, math.inf],
        ring=WIDE,
        x_m=[0, 0, 0, -0.5, -0.5],
        y_m=[-0.1, 0, 0.1, 0, 0],
    )


def test_what_would_pass_through_a_wall_is_mended_to_it():
    made = sm.filter(NAME).apply(past_a_wall())
    assert made.changed.tolist() == [False, False, False, True, True]
    np.testing.assert_allclose(made.log.range_m[3:], 1.5, atol=0.15)
    np.testing.assert_array_equal(made.predicted_range_m, made.log.range_m)
    causes = [-1, -1, -1, sm.Cause.BOUNCE, sm.Cause.DROPOUT]
    assert made.likely_cause.tolist() == causes
    assert not made.rejected.any()
    rejecting = sm.filter(NAME, action="reject").apply(past_a_wall())
    assert rejecting.rejected.tolist() == [False, False, False, True, True]
    assert not rejecting.changed.any()


def test_an_arc_that_nearer_sonars_saw_through_is_rejected():
    # Three cones that pass through the whole arc of a wrong, far echo: none of it is left.
    log = make_log(
        [2.0, 3.5, 3.5, 3.5],
        ring=WIDE,
        x_m=[0, 1.0, 1.0, 1.0],
        y_m=[0, -0.35, 0, 0.35],
    )
    made = sm.filter(NAME).apply(log)
    assert made.rejected.tolist() == [True, False, False, False]
    assert not made.changed.any()


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_a_tie_goes_to_occupied(order):
    # Two readings from one place are equally loud everywhere: the nearer arc stands.
    made = sm.filter(NAME).apply(make_log(np.array([1.0, 1.5])[order], ring=WIDE))
    assert made.changed.tolist() == np.array([False, True])[order].tolist()


def test_a_loud_ghost_keeps_its_cells_the_weak_spot():
    ghost = make_log([0.5, *[1.5] * 20], ring=WIDE, x_m=[0, *[-0.4] * 20])
    made = sm.filter(NAME).apply(ghost)
    assert not made.changed[0]
    assert made.changed[1:].all()


def test_order_turns_and_mirrors_change_nothing(rng):
    log = random_log(rng, 80, ring=WIDE)
    f = sm.filter(NAME)
    expected = f.apply(log)
    names = ("range_m", "x_m", "y_m", "heading_rad", "stale", "rejected")
    backwards = {name: getattr(log, name)[::-1] for name in names}
    reverse = f.apply(make_log(backwards.pop("range_m"), ring=WIDE, **backwards))
    np.testing.assert_array_equal(reverse.log.range_m[::-1], expected.log.range_m)
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    mirrored = log.replace(y_m=-log.y_m, heading_rad=-log.heading_rad)
    for other in (turned, mirrored):
        made = f.apply(other)
        np.testing.assert_allclose(made.log.range_m, expected.log.range_m, rtol=1e-9)
        np.testing.assert_array_equal(made.rejected, expected.rejected)


@pytest.mark.parametrize("readings", [[], [-math.inf], [math.inf], [0.0]])
def test_logs_that_say_little(readings):
    made = sm.filter(NAME).apply(make_log(readings))
    assert not made.changed.any()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"cell_m": 0}, "cell_m must be > 0, got 0"),
        ({"thickness_m": 0}, "thickness_m must be > 0, got 0"),
        ({"short_m": -1}, "short_m must be >= 0, got -1"),
        ({"path_cells": -1}, "path_cells must be >= 0, got -1"),
        ({"path_cells": 0.5}, "path_cells must be a whole number, got 0.5"),
        ({"action": "keep"}, "action 'keep' is unknown.*"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.filter(NAME, **parameters)
