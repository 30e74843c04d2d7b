"""Forward models: the factor by its sum, both searches against enumeration, and the door."""

import itertools
import math

import numpy as np
import pytest
from noise_free import WIDE, door, door_cells
from support import THREE, make_log, random_log

import sonarmap as sm
from sonarmap.kernels.forward import by_cell, log_likelihood, log_odds, remember
from sonarmap.methods.forward.model import BINS

GRID = sm.GridSpec(0.1, (-1.5, -1.5), (30, 31))
# Few enough cells for every map to be tried: 2 rows ahead of the sonar.
SMALL = sm.GridSpec(0.25, (0.3, -0.25), (2, 6))
NAMES = ["thrun-forward", "forward-bp"]


def cone(method, log, grid, i):
    """Cells of the cone of reading i: flat index, range, h; by plain geometry."""
    x, y = log.sensor_xy_m[i]
    cells = []
    for row in range(grid.rows):
        for col in range(grid.cols):
            cx, cy = grid.centre_of(row, col)
            off = math.remainder(math.atan2(cy - y, cx - x) - log.axis_rad[i], 2 * math.pi)
            share = abs(off) / log.ring.half_angle_rad
            if share <= 1:
                r = math.hypot(cx - x, cy - y)
                h = method.p_hit * (1 - (1 - method.edge) * share**2)
                cells.append((row * grid.cols + col, r, h))
    return cells


def likelihood(method, log, grid, occupied, i):
    """P(reading i | map) by the sum of the docstring, over bins of cells in order of range."""
    limit = log.ring.range_max_m if method.max_range_m is None else method.max_range_m
    z = log.range_m[i]
    cells = cone(method, log, grid, i)
    if z > limit:
        silent = math.prod(1 - h for c, r, h in cells if occupied[c] and r <= limit)
        return method.p_no_echo + (1 - method.p_no_echo) * silent
    sigma = math.sqrt(method.sigma_m**2 + grid.resolution_m**2 / 12)
    width = 6 * sigma / BINS
    near = math.prod(1 - h for c, r, h in cells if occupied[c] and r < z - 3 * sigma)
    total = 0.0
    for b in range(BINS):
        low = z - 3 * sigma + b * width
        here = [h for c, r, h in cells if occupied[c] and low <= r < low + width]
        silent = math.prod(1 - h for h in here)
        middle = (b - BINS // 2) * width
        normal = math.exp(-((middle / sigma) ** 2) / 2) / (sigma * math.sqrt(2 * math.pi))
        total += near * (1 - silent) * normal
        near *= silent
    return method.p_random / limit + (1 - method.p_random) * total


def plain_log_posterior(method, log, grid, occupied, votes):
    """ln P(Z | m) + l0 * number of occupied cells."""
    total = method.prior_log_odds * occupied.sum()
    for i in range(len(log)):
        total += votes[i] * math.log(likelihood(method, log, grid, occupied, i))
    return total


def usable(log):
    return log.select(log.usable & (log.range_m >= 0))


def test_the_factor_is_the_sum_over_the_cells_of_the_cone(rng):
    log = usable(random_log(rng, 30))
    method = sm.method("thrun-forward", prior=0.5, max_range_m=1.5)
    f = method.factors(log, GRID)
    occupied = rng.random(GRID.rows * GRID.cols) < 0.1
    near, opened, window = np.empty(len(log)), np.empty((len(log), BINS)), np.empty(len(log))
    remember(
        occupied,
        f.first,
        f.cell,
        f.zone,
        f.answers,
        f.density,
        f.beyond,
        near,
        opened,
        window,
    )
    expected = [likelihood(method, log, GRID, occupied, i) for i in range(len(log))]
    np.testing.assert_allclose(f.floor + f.scale * near * window, expected, rtol=1e-5)
    assert log_likelihood(f.floor, f.scale, f.vote, near, window) == pytest.approx(
        plain_log_posterior(method, log, GRID, occupied, f.vote), rel=1e-5
    )


def test_the_gain_of_a_flip_is_the_difference_of_both_maps(rng):
    log = usable(random_log(rng, 12))
    method = sm.method("thrun-forward", max_range_m=1.5, edge=0.2)
    f = method.factors(log, GRID)
    cells = GRID.rows * GRID.cols
    occupied = rng.random(cells) < 0.1
    memory = np.empty(len(log)), np.empty((len(log), BINS)), np.empty(len(log))
    remember(occupied, f.first, f.cell, f.zone, f.answers, f.density, f.beyond, *memory)
    got = log_odds(
        occupied,
        method.prior_log_odds,
        *by_cell(f.first, f.cell, cells),
        f.zone,
        f.answers,
        f.floor,
        f.scale,
        f.density,
        f.beyond,
        f.vote,
        *memory,
    )
    for c in [*rng.choice(f.cell, 20), *f.cell[f.zone >= 0][:20]]:
        heights = []
        for state in (False, True):
            occupied[c], before = state, occupied[c]
            heights.append(plain_log_posterior(method, log, GRID, occupied, f.vote))
            occupied[c] = before
        assert got[c] == pytest.approx(heights[1] - heights[0], abs=1e-4)


def every_map(cells):
    for bits in itertools.product([False, True], repeat=cells):
        yield np.array(bits)


def small_log():
    return make_log([0.9, 1.3, math.inf], x_m=[0, 0.1, 0], y_m=[0, 0.12, -0.1], heading_rad=0.1)


def test_climbing_finds_the_most_probable_of_all_maps():
    method = sm.method("thrun-forward", prior=0.3, p_hit=0.8, starts=5)
    log, cells = small_log(), SMALL.rows * SMALL.cols
    votes = method.factors(log, SMALL).vote
    height = {tuple(m): plain_log_posterior(method, log, SMALL, m, votes) for m in every_map(cells)}
    best = np.array(max(height, key=height.get))
    assert best.any()
    m = method.map(log, SMALL)
    for c in range(cells):
        flipped = [tuple(np.where(np.arange(cells) == c, state, best)) for state in (0, 1)]
        expected = height[flipped[1]] - height[flipped[0]]
        assert m.log_odds.ravel()[c] == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("rows", [[0], [1], [2]])
def test_propagation_of_one_reading_gives_the_exact_marginals(rows):
    method = sm.method("forward-bp", prior=0.3, p_hit=0.8, rounds=60, tolerance=1e-9)
    log, cells = small_log().select(rows), SMALL.rows * SMALL.cols
    weights = {
        tuple(m): math.exp(plain_log_posterior(method, log, SMALL, m, [1.0]))
        for m in every_map(cells)
    }
    total = sum(weights.values())
    for c in range(cells):
        expected = sum(w for m, w in weights.items() if m[c]) / total
        assert method.map(log, SMALL).probability.ravel()[c] == pytest.approx(expected, abs=1e-4)


def test_propagation_of_readings_that_share_cells_is_near_the_exact_marginals():
    method = sm.method("forward-bp", prior=0.3, p_hit=0.8, rounds=60, tolerance=1e-9)
    log, cells = small_log(), SMALL.rows * SMALL.cols
    votes = method.factors(log, SMALL).vote
    maps = list(every_map(cells))
    weights = np.exp([plain_log_posterior(method, log, SMALL, m, votes) for m in maps])
    expected = weights @ np.array(maps) / weights.sum()
    np.testing.assert_allclose(method.map(log, SMALL).probability.ravel(), expected, atol=0.05)


@pytest.mark.parametrize(
    ("name", "parameters"),
    [*(("thrun-forward", {"seed": seed}) for seed in range(4)), ("forward-bp", {})],
)
def test_two_wide_cones_through_one_door_do_not_close_it(name, parameters):
    log, grid = door()
    p = sm.method(name, **parameters).map(log, grid).probability
    closed = p[door_cells(grid)].max()
    assert closed < 0.35
    # Both jambs stand out; which cell of an arc it is remains open.
    for row, col in (grid.cell_of(2.0, y) for y in (0.32, -0.32)):
        jamb = p[row - 1 : row + 2, col - 1 : col + 2].max()
        assert jamb > 2 * closed


@pytest.mark.parametrize("name", ["bayes-parameterized", "bayes-standard"])
def test_an_inverse_model_closes_the_door(name):
    log, grid = door()
    assert sm.method(name).map(log, grid).probability[door_cells(grid)].max() > 0.65


def test_the_same_seed_gives_the_same_map_and_more_starts_a_better_one(rng):
    log = random_log(rng, 150)
    once, again = (sm.method("thrun-forward", seed=3).map(log, GRID) for _ in range(2))
    assert once.probability.tobytes() == again.probability.tobytes()
    clean = usable(log)
    heights = []
    for starts in (1, 6):
        method = sm.method("thrun-forward", starts=starts)
        votes = method.factors(clean, GRID).vote
        best = method.map(log, GRID).probability.ravel() > 0.5
        heights.append(plain_log_posterior(method, clean, GRID, best, votes))
    assert heights[1] >= heights[0] - 1e-6


def test_tempering_scales_the_evidence_and_not_the_prior(rng):
    log = random_log(rng, 80)
    full, half = (sm.method("thrun-forward", temper=t).map(log, GRID) for t in (1.0, 0.5))
    l0 = sm.method("thrun-forward").prior_log_odds
    sure = np.abs(full.log_odds) < 10  # the map's log-odds are clipped
    expected = l0 + 0.5 * (full.log_odds - l0)
    np.testing.assert_allclose(half.log_odds[sure], expected[sure], rtol=1e-6)


def test_turning_and_mirroring_the_log_turns_and_mirrors_the_marginals(rng):
    grid = sm.GridSpec(0.1, (-1.5, -1.5), (30, 30))
    log = random_log(rng, 80, ring=WIDE)
    method = sm.method("forward-bp")
    expected = method.map(log, grid).probability
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    mirrored = log.replace(y_m=-log.y_m, heading_rad=-log.heading_rad)
    for other, m in ((turned, np.rot90(expected, -1)), (mirrored, expected[::-1])):
        np.testing.assert_allclose(method.map(other, grid).probability, m, atol=1e-3)


def test_a_thousand_repeats_move_the_most_probable_map_no_more_than_one():
    method = sm.method("thrun-forward")
    one = method.map(make_log(1.0), GRID).probability
    thousand = method.map(make_log(np.full(1000, 1.0)), GRID).probability
    np.testing.assert_allclose(thousand, one, atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("readings", [[], [-math.inf], [math.inf], [0.0]])
def test_logs_that_say_little_give_maps(name, readings):
    m = sm.method(name).map(make_log(readings, ring=THREE), GRID)
    assert (m.probability < 0.2).all()
    assert m.observed.any() == (readings in ([math.inf], [0.0]))


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        *(
            (name, parameters, message)
            for name in NAMES
            for parameters, message in (
                ({"prior": 0}, r"prior must be in \(0, 0.5\], got 0"),
                ({"p_hit": 1}, r"p_hit must be in \(0, 1\), got 1"),
                ({"edge": -0.1}, r"edge must be within \[0, 1\], got -0.1"),
                ({"p_random": 0}, r"p_random must be in \(0, 1\), got 0"),
                ({"p_no_echo": 1.5}, r"p_no_echo must be in \(0, 1\), got 1.5"),
                ({"sigma_m": 0}, "sigma_m must be > 0, got 0"),
                ({"repeat_travel_m": -1}, "repeat_travel_m must be > 0, got -1"),
                ({"max_range_m": 0}, "max_range_m must be > 0, got 0"),
            )
        ),
        ("thrun-forward", {"starts": 0}, "starts must be >= 1, got 0"),
        ("thrun-forward", {"max_sweeps": 0.5}, "max_sweeps must be a whole number, got 0.5"),
        ("thrun-forward", {"seed": -1}, "seed must be >= 0, got -1"),
        ("thrun-forward", {"temper": 2}, r"temper must be within \[0, 1\], got 2"),
        ("forward-bp", {"rounds": 0}, "rounds must be >= 1, got 0"),
        ("forward-bp", {"damping": 1}, r"damping must be in \[0, 1\), got 1"),
        ("forward-bp", {"tolerance": -1}, "tolerance must be >= 0, got -1"),
    ],
)
def test_bad_parameters_are_refused(name, parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.method(name, **parameters)
