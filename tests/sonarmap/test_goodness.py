"""Goodness without truth: oracles by arithmetic, and a twin that keeps every probability."""

import json
import math

import numpy as np
import pytest

import sonarmap as sm
from sonarmap import goodness
from sonarmap.methods.bayes import spread as bayes_spread

RING = sm.SonarRing("pointer", [0.0], [0.0], [0.0], math.radians(15), 0.165, 3.0)
PARAMETERIZED = sm.ParameterizedModel(0.03, 0.1, 0.08, 0.97, math.radians(15))
GRID = sm.GridSpec(0.1, (-1.5, -1.5), (30, 31))


def readings(*rows, ring=RING):
    """Log of rows (x, y, heading in degrees, range)."""
    x_m, y_m, heading_deg, range_m = np.array(rows, dtype=float).T
    n = len(rows)
    return sm.SonarLog(
        ring=ring,
        scan=np.arange(n),
        sonar=np.arange(n) % len(ring),
        time_s=np.arange(n) * 0.175,
        x_m=x_m,
        y_m=y_m,
        heading_rad=np.deg2rad(heading_deg),
        range_m=range_m,
    )


def random_log(n=40, seed=1):
    rng = np.random.default_rng(seed)
    range_m = rng.uniform(0.2, 1.5, n)
    range_m[::9] = np.inf
    log = readings(
        *zip(
            rng.uniform(-1, 1, n),
            rng.uniform(-1, 1, n),
            rng.uniform(-180, 180, n),
            range_m,
            strict=True,
        ),
        ring=sm.AMIGOBOT,
    )
    return log.replace(stale=np.arange(n) % 11 == 5, rejected=np.arange(n) % 13 == 5)


def map_of(rows):
    """Map of 1 m cells drawn as P(occupied), the first row the lowest."""
    p = np.array(rows, dtype=float)
    return sm.OccupancyMap(sm.GridSpec(1.0, (0, 0), p.shape), np.log(p / (1 - p)))


def slow_values(log, model, grid, max_range_m):
    """Return what each reading says of each cell, (rows, cols, N); NaN where it is silent."""
    x_m, y_m = grid.centre_of(*np.indices(grid.shape))
    limit_m = min(max_range_m, model.range_limit_m)
    values = np.full((*grid.shape, len(log)), np.nan)
    for i in range(len(log)):
        reading = log.range_m[i]
        if log.stale[i] or log.rejected[i] or not 0 <= reading <= limit_m:
            continue
        dx, dy = x_m - log.sensor_xy_m[i, 0], y_m - log.sensor_xy_m[i, 1]
        distance = np.hypot(dx, dy)
        bearing = np.arctan2(dy, dx) - log.axis_rad[i]
        bearing = np.arctan2(np.sin(bearing), np.cos(bearing))
        reach = model.regions(np.array([reading])).reach_m[0]
        speaks = (np.abs(bearing) <= model.half_angle_rad) & (distance <= reach)
        p = model.probability(distance, bearing, reading)
        values[speaks, i] = p.clip(1e-6, 1 - 1e-6)[speaks]
    return values


MODELS = [
    PARAMETERIZED,
    sm.ParameterizedModel(0.05, 0.2, 0.025, 0.95, math.radians(15)),
    sm.ParameterizedModel(0.02, 0.05, 0.15, 0.98, math.radians(40)),
    sm.StandardModel(math.radians(15), 1.2, 0.98, 0.05),
]


@pytest.mark.parametrize("max_range_m", [1.0, 3.0])
def test_equals_the_twin_that_keeps_every_probability(max_range_m):
    log = random_log()
    results = goodness.map_and_spread(log, MODELS, GRID, max_range_m=max_range_m)
    for model, (m, spread) in zip(MODELS, results, strict=True):
        values = slow_values(log, model, GRID, max_range_m)
        count = np.isfinite(values).sum(axis=2)
        log_odds = np.nansum(np.log(values / (1 - values)), axis=2)
        twice = count > 1
        deviation = np.zeros(GRID.shape)
        deviation[twice] = np.nanstd(values[twice], axis=1, ddof=1)
        assert twice.sum() > 40
        np.testing.assert_array_equal(spread.readings, count)
        np.testing.assert_array_equal(spread.updated, count > 0)
        np.testing.assert_allclose(m.log_odds, log_odds, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(spread.standard_deviation, deviation, rtol=1e-9, atol=1e-12)
        assert spread.vsdns == pytest.approx(deviation[deviation > 1e-9].mean(), rel=1e-12)


@pytest.mark.parametrize("no_echo", ["ignore", "clear"])
@pytest.mark.parametrize("most_cells", [None, 500, 1])
def test_map_is_build_maps_also_when_listed_part_by_part(monkeypatch, no_echo, most_cells):
    log = random_log(80, seed=2)
    if most_cells is not None:
        monkeypatch.setattr(bayes_spread, "_MOST_CELLS", most_cells)
    results = goodness.map_and_spread(log, MODELS, GRID, max_range_m=1.2, no_echo=no_echo)
    for model, (m, _) in zip(MODELS, results, strict=True):
        expected = sm.build_map(log, model, GRID, max_range_m=1.2, no_echo=no_echo)
        np.testing.assert_allclose(m.log_odds, expected.log_odds, rtol=1e-12, atol=1e-12)


def test_a_shared_list_changes_nothing():
    log = random_log()
    together = [spread.vsdns for _, spread in goodness.map_and_spread(log, MODELS, GRID)]
    alone = [next(goodness.map_and_spread(log, [model], GRID))[1].vsdns for model in MODELS]
    assert together == alone


def test_a_cone_partly_or_wholly_off_the_grid():
    log = readings((1.55, 0.05, 0, 1.0), (1.3, 1.05, 10, 1.0), (40, 40, 0, 1.0))
    ((m, spread),) = goodness.map_and_spread(log, [PARAMETERIZED], GRID)
    np.testing.assert_allclose(m.log_odds, sm.build_map(log, PARAMETERIZED, GRID).log_odds)
    assert spread.readings.max() == 1
    assert math.isnan(spread.vsdns)


def test_two_readings_of_one_cell_by_hand():
    # One cell, its centre 1 m ahead of the sonar: at the reading P4 = 0.97, and on line 1 of the
    # reading of 1.58 m: P1 + (0.5 - P1 - P2) / (S - P3) * r = 0.03 + 0.37 / 1.5.
    grid = sm.GridSpec(0.02, (0.99, -0.01), (1, 1))
    log = readings((0, 0, 0, 1.0), (0, 0, 0, 1.58))
    ((_, spread),) = goodness.map_and_spread(log, [PARAMETERIZED], grid)
    a, b = 0.97, 0.03 + 0.37 / 1.5
    assert spread.readings.item() == 2
    assert spread.mean.item() == pytest.approx((a + b) / 2)
    assert spread.vsdns == pytest.approx(abs(a - b) / math.sqrt(2))


def test_repeated_readings_have_no_spread_and_do_not_count():
    one = (0, 0, 20, 1.0)
    ((_, still),) = goodness.map_and_spread(readings(*[one] * 7), [PARAMETERIZED], GRID)
    assert still.readings.max() == 7
    assert math.isnan(still.vsdns)
    # Two other readings decide the mean alone, far from the seven.
    others = ((0, 0, 200, 1.0), (0, 0, 200, 1.2))
    ((_, alone),) = goodness.map_and_spread(readings(*others), [PARAMETERIZED], GRID)
    ((_, mixed),) = goodness.map_and_spread(readings(*[one] * 7, *others), [PARAMETERIZED], GRID)
    assert mixed.vsdns == pytest.approx(alone.vsdns, rel=1e-12)


def test_true_poses_are_used_when_asked():
    log = readings((0, 0, 0, 1.0), (0.1, 0, 5, 1.0))
    with pytest.raises(sm.InputError, match="no truth"):
        goodness.map_and_spread(log, [PARAMETERIZED], GRID, poses="true")


# Derivative.


def test_derivative_of_one_cell_by_hand():
    # The middle cell differs from its 8 neighbours by 0.4 each: D = 0.4; one updated cell.
    assert goodness.map_derivative(
        map_of([[0.5, 0.5, 0.5], [0.5, 0.9, 0.5], [0.5, 0.5, 0.5]])
    ) == pytest.approx(0.4)


def test_derivative_of_a_step_by_hand():
    # Columns 0.1 0.1 0.9 0.9: each of the 2 x 2 inner cells has 3 neighbours across the step.
    m = map_of([[0.1, 0.1, 0.9, 0.9]] * 4)
    assert goodness.map_derivative(m) == pytest.approx(4 * (3 * 0.8 / 8) / 16)
    half = np.arange(4) < 2
    assert goodness.map_derivative(m, updated=np.tile(half, (4, 1))) == pytest.approx(1.2 / 8)


@pytest.mark.parametrize("shape", [(3, 3), (5, 9), (20, 7)])
def test_derivative_equals_the_papers_loop(shape):
    rng = np.random.default_rng(4)
    m = map_of(rng.uniform(0.05, 0.95, shape))
    w = m.probability
    total = 0.0
    for x in range(1, shape[0] - 1):
        for y in range(1, shape[1] - 1):
            s = sum(
                abs(w[i, j] - w[x, y]) for i in range(x - 1, x + 2) for j in range(y - 1, y + 2)
            )
            total += s / (3 * 3 - 1)
    updated = rng.random(shape) < 0.6
    assert goodness.map_derivative(m, updated=updated) == pytest.approx(total / updated.sum())


def test_derivative_of_maps_without_an_inner_or_an_updated_cell():
    assert goodness.map_derivative(map_of([[0.9, 0.1, 0.9]])) == 0
    assert math.isnan(goodness.map_derivative(map_of(np.full((4, 4), 0.5))))


# Two runs.


def test_two_runs_by_hand():
    #        both occupied, both free x 2, differing x 2, one-sided x 2, both unknown
    a = map_of([[0.9, 0.1, 0.35, 0.9, 0.2, 0.9, 0.5, 0.5]])
    b = map_of([[0.65, 0.3, 0.1, 0.1, 0.7, 0.5, 0.2, 0.4]])
    found = goodness.compare_runs(a, b)
    assert found == goodness.RunComparison(1, 2, 2, 2)
    assert (found.positive, found.negative, found.agreement) == (3, 2, 0.6)
    assert goodness.compare_runs(b, a) == found
    # With a stricter threshold the cells of 0.65, 0.35, 0.3 and 0.7 become unknown.
    assert goodness.compare_runs(a, b, occupied_from=0.75) == goodness.RunComparison(0, 0, 1, 6)


def test_two_runs_equal_a_loop_over_the_cells():
    rng = np.random.default_rng(5)
    a, b = (map_of(rng.uniform(0.01, 0.99, (12, 15))) for _ in range(2))

    def state(p):
        return "occupied" if p >= 0.65 else "free" if p <= 0.35 else None

    counts = [0, 0, 0, 0]
    for p, q in zip(a.probability.flat, b.probability.flat, strict=True):
        pair = (state(p), state(q))
        if pair == ("occupied", "occupied"):
            counts[0] += 1
        elif pair == ("free", "free"):
            counts[1] += 1
        elif None not in pair:
            counts[2] += 1
        elif pair != (None, None):
            counts[3] += 1
    assert goodness.compare_runs(a, b) == goodness.RunComparison(*counts)


def test_comparisons_add_up_and_tell_themselves():
    total = goodness.RunComparison(1, 2, 3, 4) + goodness.RunComparison(10, 20, 30, 40)
    assert total == goodness.RunComparison(11, 22, 33, 44)
    assert json.loads(json.dumps(total.to_dict()))["agreement"] == 0.5
    assert goodness.RunComparison(0, 0, 0, 5).to_dict()["agreement"] is None


# The thesis's search.


def test_the_1440_sets_of_the_thesis():
    sets = goodness.thesis_parameter_sets()
    assert len(set(sets)) == len(sets) == 1440
    # Table 5.1: minimum and maximum of each parameter, 2 P3 in units of 0.1 m.
    for values, low, high in [
        ([s.p1 for s in sets], 0.02, 0.05),
        ([s.p2 for s in sets], 0.05, 0.2),
        ([2 * s.p3_m for s in sets], 0.05, 0.3),
        ([s.p4 for s in sets], 0.95, 0.98),
        ([math.degrees(s.p5_rad) for s in sets], 6, 40),
    ]:
        assert (min(values), max(values)) == pytest.approx((low, high))
    assert all(s.p1 + s.p4 == pytest.approx(1) for s in sets)
    # Sets of one half-angle stand together, or nothing would be shared.
    half_angles = [s.p5_rad for s in sets]
    assert half_angles == sorted(half_angles)
    assert len(set(half_angles)) == 15


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda log, m: goodness.map_and_spread(log, [], GRID, no_echo="x"), "no_echo 'x' is unk"),
        (lambda log, m: goodness.map_and_spread(log, [], GRID, poses="x"), "poses 'x' is unknown"),
        (
            lambda log, m: goodness.map_and_spread(log, [], GRID, max_range_m=0),
            "max_range_m must be > 0, got 0",
        ),
        (
            lambda log, m: goodness.map_derivative(m, updated=np.ones((2, 2), bool)),
            r"updated must have the grid's shape \(3, 3\), got \(2, 2\)",
        ),
        (
            lambda log, m: goodness.compare_runs(m, map_of([[0.5]])),
            "both maps must have the same grid",
        ),
        (
            lambda log, m: goodness.compare_runs(m, m, occupied_from=0.5),
            r"occupied_from must be in \(0\.5, 1\), got 0\.5",
        ),
    ],
)
def test_bad_input(call, message):
    with pytest.raises(sm.InputError, match=message):
        call(random_log(), map_of(np.full((3, 3), 0.7)))
