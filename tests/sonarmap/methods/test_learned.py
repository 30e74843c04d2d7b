"""The learned mapper: what must hold whatever it has learned."""

import math
import tracemalloc

import numpy as np
import pytest
from support import ONE, make_log, random_log

import sonarmap as sm
from sonarmap.errors import InputError


def learned(log, grid):
    return sm.method("learned").map(log, grid)


def test_an_empty_log_has_the_share_of_walls_and_nothing_observed():
    m = learned(make_log([1.0]).select(slice(0)), sm.GridSpec(0.05, (0, 0), (20, 30)))
    assert np.unique(m.probability).size == 1
    assert 0.02 < m.probability[0, 0] < 0.3
    assert not m.observed.any()


@pytest.mark.parametrize("range_m", [[1.0], [np.inf], [np.inf] * 20])
def test_a_few_readings_say_a_little(range_m):
    grid = sm.GridSpec(0.05, (-2, -2), (80, 80))
    m = learned(make_log(range_m, x_m=-1.0, ring=ONE), grid)
    assert ((m.probability > 0) & (m.probability < 1)).all()
    # Behind the robot, where no cone was, the share of walls is that of a common room.
    assert 0.005 < m.probability[5:15, 5:12].mean() < 0.4
    assert not m.observed[:10, :10].any()


@pytest.mark.parametrize("sonars", [1, 3, 16, 24])
@pytest.mark.parametrize("resolution_m", [0.025, 0.05, 0.1])
def test_any_ring_maps_at_any_resolution(sonars, resolution_m, rng):
    heading = np.linspace(-math.pi, math.pi, sonars, endpoint=False)
    ring = sm.SonarRing("any", 0.1 * np.cos(heading), 0.1 * np.sin(heading), heading, 0.2, 0.1, 4.0)
    n = max(4 * sonars, 20)
    log = random_log(rng, n, ring=ring, reach_m=1.5, spread_m=0.2)
    shape = (round(3 / resolution_m), round(3.2 / resolution_m))
    m = learned(log, sm.GridSpec(resolution_m, (-1.5, -1.6), shape))
    assert m.probability.shape == shape
    assert np.isfinite(m.probability).all()
    assert m.observed.any()


def test_the_memory_of_a_long_log_is_that_of_its_area(rng):
    def most(n):
        log = random_log(rng, n, ring=sm.AMIGOBOT, reach_m=2.0, spread_m=0.3)
        tracemalloc.start()
        learned(log, sm.GridSpec(0.05, (-2, -2), (80, 80)))
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak / 1e6

    most(1000)  # compiled
    # Ten times the readings on the same floor: what grows is their own columns.
    assert most(100_000) < 1.5 * most(10_000) + 50


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"occupied_from": 1.5}, r"occupied_from must be within \[0, 1\], got 1.5"),
        ({"free_up_to": -0.1}, r"free_up_to must be within \[0, 1\], got -0.1"),
        ({"weights": 3}, r"weights must be the path of a file, got 3"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(InputError, match=message):
        sm.method("learned", **parameters)


def test_a_robot_that_stands_is_looked_at_again():
    state = sm.method("learned").begin(ONE, sm.GridSpec(0.05, (-1, -1), (40, 40)))
    state.add(make_log([1.0]))
    once = state.map
    state.add(make_log(np.linspace(0.9, 1.1, 99)))
    assert state.map is once
    state.add(make_log([1.0]))
    assert state.map is not once
