"""Arcs that compete for cells: against plain loops, by hand, and by what must hold."""

import math
from importlib import import_module

import numpy as np
import pytest
from noise_free import WIDE, door, door_cells
from support import ONE, THREE, make_log, random_log

import sonarmap as sm
from sonarmap.methods.arc_competition import shared_votes

GRID = sm.GridSpec(0.1, (-1.5, -1.5), (30, 31))
METHOD = "arc-competition"


def plain(method, log, grid):
    """The same by plain loops over readings and cells, without lists or kernels."""
    log = log.select(log.usable & (log.range_m >= 0))
    limit = log.ring.range_max_m if method.max_range_m is None else method.max_range_m
    votes = shared_votes(log, method.repeat_travel_m, method.repeat_turn_rad)
    arcs, passes = [], []
    for i in range(len(log)):
        arcs.append({})
        passes.append({})
        x, y = log.sensor_xy_m[i]
        reading = log.range_m[i]
        for row in range(grid.rows):
            for col in range(grid.cols):
                cx, cy = grid.centre_of(row, col)
                r = math.hypot(cx - x, cy - y)
                off = math.remainder(math.atan2(cy - y, cx - x) - log.axis_rad[i], 2 * math.pi)
                share = abs(off) / log.ring.half_angle_rad
                if share > 1:
                    continue
                beam = 1 - share**2
                if reading <= limit and abs(r - reading) <= method.tolerance_m:
                    arcs[i][row, col] = beam
                elif r < min(reading, limit):
                    passes[i][row, col] = beam * (1 - r / limit)
    p = np.full(grid.shape, method.prior)
    for _ in range(method.rounds):
        hits, misses = np.zeros(grid.shape), np.zeros(grid.shape)
        for i in range(len(log)):
            odds = {at: beam * p[at] / (1 - p[at]) for at, beam in arcs[i].items()}
            total = sum(odds.values())
            if log.range_m[i] <= limit:
                trust = votes[i] * total / (total + method.unexplained)
            else:
                trust = votes[i] * method.no_echo_weight
            for at, each in odds.items():
                hits[at] += trust * each / total
                misses[at] += trust * (1 - each / total) * arcs[i][at] * method.rival_weight
            for at, strength in passes[i].items():
                misses[at] += trust * strength * method.pass_weight
        s = method.prior_weight
        p = (s * method.prior + hits) / (s + hits + misses)
    return p


@pytest.mark.parametrize(
    "parameters",
    [{}, {"rounds": 1, "max_range_m": 1.2}, {"pass_weight": 1.0, "rival_weight": 0.5}],
)
def test_equals_plain_loops(parameters, rng):
    log = random_log(rng, 40)
    method = sm.method(METHOD, **parameters)
    np.testing.assert_allclose(
        method.map(log, GRID).probability, plain(method, log, GRID), rtol=1e-5
    )


def test_batches_of_readings_change_nothing(rng, monkeypatch):
    log = random_log(rng, 100)
    whole = sm.method(METHOD).map(log, GRID).probability
    monkeypatch.setattr(import_module("sonarmap.methods.arc_competition"), "_BATCH", 7)
    assert sm.method(METHOD).map(log, GRID).probability.tobytes() == whole.tobytes()


def test_one_echo_on_two_cells_is_shared_by_hand():
    # Cells of 1 m: the arc at 2.5 m holds only the cell straight ahead.
    grid = sm.GridSpec(1.0, (0.0, -0.5), (1, 4))
    log = make_log(2.5, x_m=0.0)
    m = sm.method(METHOD, rounds=1, prior=0.2, unexplained=0.25).map(log, grid)
    # Odds 0.2 / 0.8 against 0.25: half believed. One hit of 0.5 on one prior reading.
    assert m.probability[0, 2] == pytest.approx((0.2 + 0.5) / (1 + 0.5))
    # Passed at 0.5 m and 1.5 m of 8 m, a tenth of a reading at most.
    for col, r in ((0, 0.5), (1, 1.5)):
        assert m.probability[0, col] == pytest.approx(0.2 / (1 + 0.5 * 0.1 * (1 - r / 8)))
    assert m.probability[0, 3] == 0.2
    assert m.observed.tolist() == [[True, True, True, False]]


def test_what_others_saw_through_loses_the_echo():
    # An echo at 2 m, whose arc is 1 m wide, and ten cones that see through its left half.
    y_m = np.linspace(0.3, 0.5, 10)
    log = make_log([2.0, *[3.5] * 10], ring=WIDE, y_m=[0, *y_m], x_m=[0, *[1.0] * 10])
    grid = sm.GridSpec(0.05, (-0.5, -1.5), (60, 110))
    left, col = grid.cell_of(2 * math.cos(0.15), 2 * math.sin(0.15))
    right, _ = grid.cell_of(2 * math.cos(0.15), -2 * math.sin(0.15))
    method = sm.method(METHOD, pass_weight=1.0)
    alone = method.map(log.select([0]), grid).probability
    both = method.map(log, grid).probability
    assert alone[left, col] == pytest.approx(alone[right, col])
    assert both[left, col] < 0.3 * alone[left, col]
    # What is gained is counted from what is believed of a cell that nothing spoke of.
    assert both[right, col] - method.prior > 1.3 * (alone[right, col] - method.prior)


def test_no_door_is_closed_that_was_seen_through():
    log, grid = door()
    m = sm.method(METHOD, pass_weight=0.5).map(log, grid)
    assert (m.probability[door_cells(grid)] < m.occupied_from).all()
    jamb = [grid.cell_of(2.0, y) for y in (0.32, -0.32)]
    for row, col in jamb:
        assert m.probability[row - 1 : row + 2, col - 1 : col + 2].max() >= m.occupied_from


def test_a_thousand_repeats_say_what_one_reading_says():
    method = sm.method(METHOD)
    one = method.map(make_log(1.0), GRID).probability
    thousand = method.map(make_log(np.full(1000, 1.0)), GRID).probability
    np.testing.assert_allclose(thousand, one, atol=1e-9)


def test_a_sonar_has_one_vote_a_stretch():
    log = make_log(np.ones(6), ring=THREE, sonar=[0, 0, 1] * 2, x_m=[0, 0, 0, 0.1, 0.1, 0.1])
    assert shared_votes(log, 0.05, 1.0).tolist() == [0.5, 0.5, 1, 0.5, 0.5, 1]
    turning = make_log(np.ones(3), heading_rad=[3.1, -3.1, -3.0])
    assert shared_votes(turning, 1.0, 0.1).tolist() == [0.5, 0.5, 1]
    assert shared_votes(turning.select([]), 1.0, 0.1).tolist() == []


def test_quarter_turns_and_mirrors_of_the_log_turn_and_mirror_the_map(rng):
    grid = sm.GridSpec(0.1, (-1.5, -1.5), (30, 30))
    log = random_log(rng, 80, ring=ONE)
    method = sm.method(METHOD)
    expected = method.map(log, grid).probability
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    mirrored = log.replace(y_m=-log.y_m, heading_rad=-log.heading_rad)
    np.testing.assert_allclose(method.map(turned, grid).probability, np.rot90(expected, -1), 1e-5)
    np.testing.assert_allclose(method.map(mirrored, grid).probability, expected[::-1], 1e-5)


@pytest.mark.parametrize("readings", [[], [-math.inf], [math.inf], [0.0]])
def test_logs_that_say_little_give_maps(readings):
    m = sm.method(METHOD).map(make_log(readings), GRID)
    assert (m.probability <= 0.06).all()
    assert m.observed.any() == (readings == [math.inf])


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"rounds": 0}, "rounds must be >= 1, got 0"),
        ({"prior": 0}, r"prior must be in \(0, 0.5\], got 0"),
        ({"prior": 0.6}, r"prior must be in \(0, 0.5\], got 0.6"),
        ({"prior_weight": 0}, "prior_weight must be > 0, got 0"),
        ({"tolerance_m": -1}, "tolerance_m must be > 0, got -1"),
        ({"unexplained": 0}, "unexplained must be > 0, got 0"),
        ({"pass_weight": -1}, "pass_weight must be >= 0, got -1"),
        ({"rival_weight": -1}, "rival_weight must be >= 0, got -1"),
        ({"no_echo_weight": 2}, r"no_echo_weight must be within \[0, 1\], got 2"),
        ({"repeat_travel_m": 0}, "repeat_travel_m must be > 0, got 0"),
        ({"repeat_turn_rad": 0}, "repeat_turn_rad must be > 0, got 0"),
        ({"max_range_m": 0}, "max_range_m must be > 0, got 0"),
        ({"free_up_to": 0.5}, "free_up_to must be < occupied_from, got 0.5 and 0.2"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.method(METHOD, **parameters)
