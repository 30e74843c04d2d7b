import math

import numpy as np
import pytest
from support import ONE, THREE, draw, equations, make_log, random_log

import sonarmap as sm
from sonarmap.kernels.fusion import (
    Cone,
    GridCells,
    RegionArrays,
    Sensors,
    _log,
    add_readings,
    bearing_polynomial,
)
from sonarmap.mapping import grid_over

STANDARD = sm.StandardModel(
    beta_rad=math.radians(15), max_range_m=3.0, max_occupied=0.98, tolerance_m=0.1
)
PARAMETERIZED = sm.ParameterizedModel(p1=0.02, p2=0.15, p3_m=0.1, p4=0.98, p5_rad=math.radians(15))
MODELS = [STANDARD, PARAMETERIZED]
GRID = sm.GridSpec(0.1, (-2.5, -2.5), (50, 50))


def model_of(kind, half_angle_deg):
    beta = math.radians(half_angle_deg)
    if kind == "standard":
        return sm.StandardModel(beta, max_range_m=2.5, max_occupied=0.98, tolerance_m=0.13)
    return sm.ParameterizedModel(p1=0.03, p2=0.11, p3_m=0.17, p4=0.95, p5_rad=beta)


def turned(log, angle_rad):
    """Return the log of a world that is turned about the origin."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return log.replace(
        x_m=cos * log.x_m - sin * log.y_m,
        y_m=sin * log.x_m + cos * log.y_m,
        heading_rad=log.heading_rad + angle_rad,
    )


# --- the slow twin -------------------------------------------------------------------------------


def slow_map(log, model, grid, *, no_echo="ignore", limit_m=None):
    """Map a log cell by cell, by the rules and the equations as they are written.

    Returns the log-odds, and which cells are undecided: those whose centre lies within rounding
    of a border between regions for some reading, where two programs may rightly disagree.
    """
    tolerance = model.tolerance_m if isinstance(model, sm.StandardModel) else model.p3_m
    limit_m = min(log.ring.range_max_m, model.range_limit_m) if limit_m is None else limit_m
    log_odds, undecided = np.zeros(grid.shape), np.zeros(grid.shape, bool)
    for i in range(len(log)):
        reading, k = log.range_m[i], log.sonar[i]
        if log.stale[i] or log.rejected[i] or reading == -math.inf:
            continue
        silent = reading > limit_m
        if silent and no_echo == "ignore":
            continue
        reading = limit_m if silent else reading

        heading, ring = log.heading_rad[i], log.ring
        x = log.x_m[i] + math.cos(heading) * ring.x_m[k] - math.sin(heading) * ring.y_m[k]
        y = log.y_m[i] + math.sin(heading) * ring.x_m[k] + math.cos(heading) * ring.y_m[k]
        axis = heading + ring.heading_rad[k]
        borders = [reading - tolerance, reading, reading + tolerance]
        for row in range(grid.rows):
            for col in range(grid.cols):
                dx = grid.origin_xy_m[0] + (col + 0.5) * grid.resolution_m - x
                dy = grid.origin_xy_m[1] + (row + 0.5) * grid.resolution_m - y
                r = math.hypot(dx, dy)
                if r > reading + tolerance + 1e-6:
                    continue
                # A cell whose centre is the sonar's own place is on the axis.
                turn = math.atan2(dy, dx) - axis if r > 0 else 0.0
                a = abs(math.remainder(turn, 2 * math.pi))
                if abs(a - model.half_angle_rad) < 1e-9 or any(abs(r - b) < 1e-9 for b in borders):
                    undecided[row, col] = True
                if silent and r >= reading - tolerance:  # a free cone has no region 1
                    continue
                p = min(max(equations(model, r, a, reading), 1e-6), 1 - 1e-6)
                log_odds[row, col] += math.log(p / (1 - p))
    return log_odds, undecided


def assert_like_the_slow_twin(log, model, grid, **options):
    slow, undecided = slow_map(log, model, grid, **options)
    fast = sm.build_map(log, model, grid, no_echo=options.get("no_echo", "ignore")).log_odds
    decided = ~undecided
    assert (slow[decided] != 0).sum() > 4, "the case says nothing"
    np.testing.assert_allclose(fast[decided], slow[decided], rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", ["standard", "parameterized"])
@pytest.mark.parametrize("no_echo", ["ignore", "clear"])
@pytest.mark.parametrize("half_angle_deg", [2, 15, 41, 60])
@pytest.mark.parametrize("resolution_m", [0.07, 0.1, 0.31])
def test_the_compiled_map_is_the_slow_one(kind, no_echo, half_angle_deg, resolution_m, rng):
    log = random_log(rng, 16, reach_m=1.5, spread_m=0.8)
    # This grid cuts cones off on all four sides.
    grid = sm.GridSpec.covering(-1.1, -0.9, 1.2, 1.0, resolution_m)
    assert_like_the_slow_twin(log, model_of(kind, half_angle_deg), grid, no_echo=no_echo)


@pytest.mark.parametrize("kind", ["standard", "parameterized"])
@pytest.mark.parametrize("half_angle_deg", [15, 30, 45, 60])
@pytest.mark.parametrize(
    "place", ["cell centre", "cell corner", "cell border", "row of centres", "anywhere"]
)
def test_it_is_so_with_headings_along_the_axes(kind, half_angle_deg, place):
    x_m, y_m = {
        "cell centre": (0.0625, -0.0625),
        "cell corner": (0.125, 0.25),
        "cell border": (0.125, 0.1),
        # here a centre lies straight behind the sonar, less than a cell away
        "row of centres": (0.1, -0.0625),
        "anywhere": (0.031, -0.047),
    }[place]
    headings = np.arange(-8, 9) * math.pi / 4
    log = make_log(0.9, heading_rad=headings[0], x_m=x_m, y_m=y_m)
    grid = sm.GridSpec(0.125, (-1.25, -1.25), (20, 20))
    model = model_of(kind, half_angle_deg)
    for heading in headings:
        assert_like_the_slow_twin(log.replace(heading_rad=[heading]), model, grid)


@pytest.mark.parametrize("kind", ["standard", "parameterized"])
@pytest.mark.parametrize(
    "origin_xy_m", [(0.4, -0.2), (-0.5, 0.3), (-0.7, -1.4), (-30.0, 0.0), (30.0, 0.0)]
)
def test_a_sonar_outside_of_the_grid_reaches_into_it_or_not(kind, origin_xy_m, rng):
    log = random_log(rng, 30, reach_m=1.5, spread_m=0.3)
    model, grid = model_of(kind, 25), sm.GridSpec(0.1, origin_xy_m, (8, 9))
    slow, undecided = slow_map(log, model, grid)
    fast = sm.build_map(log, model, grid).log_odds
    np.testing.assert_allclose(fast[~undecided], slow[~undecided], rtol=0, atol=1e-9)
    assert (slow != 0).any() == (abs(origin_xy_m[0]) < 2)


@pytest.mark.parametrize("kind", ["standard", "parameterized"])
def test_readings_shorter_than_the_tolerance_have_no_free_space(kind):
    log = make_log([0.0, 0.05, 0.12], heading_rad=[0.3, 1.0, -2.0])
    grid = sm.GridSpec(0.02, (-0.4, -0.4), (40, 40))
    assert_like_the_slow_twin(log, model_of(kind, 40), grid)


# The borders between regions, where two programs may disagree by rounding: with cells of 1/4 m
# and a sonar on a cell's centre nothing is rounded, and the rule can be read off.
def test_borders_belong_to_the_region_that_the_equations_say():
    model = sm.ParameterizedModel(p1=0.1, p2=0.1, p3_m=0.25, p4=0.9, p5_rad=math.radians(15))
    log = make_log(1.0, x_m=0.125, y_m=0.125)
    p = sm.build_map(log, model, sm.GridSpec(0.25, (0, 0), (1, 8))).probability[0]
    line_1 = [0.1 + 0.3 / 0.75 * r for r in (0, 0.25, 0.5)]
    expected = [*line_1, 0.6, 0.9, 0.6, 0.5, 0.5]
    np.testing.assert_allclose(p, expected, atol=1e-12)


def test_a_cell_that_is_the_sonars_own_place_is_on_the_axis():
    p = sm.build_map(
        make_log(1.0, heading_rad=2.0, x_m=0.05, y_m=0.05), PARAMETERIZED, GRID
    ).probability
    assert p[GRID.cell_of(0.05, 0.05)] == pytest.approx(PARAMETERIZED.p1)


def test_the_loop_stays_within_its_arrays(rng):
    # The same code uncompiled, where an index out of bounds is an error and not a lost byte.
    for _ in range(200):
        n, reach = 3, 10 ** rng.uniform(-9, 0)
        log_odds = np.zeros(rng.integers(1, 12, 2))
        model = model_of("parameterized", rng.uniform(1, 60))
        regions = model.regions(np.full(n, 0.1))
        border = regions.border_m * reach
        add_readings.py_func(
            log_odds,
            GridCells(*log_odds.shape, 0.0, 0.0, 0.1),
            Sensors(rng.integers(-2, 14, (n, 2)) * 0.05, rng.integers(-8, 9, n) * math.pi / 4),
            Cone(model.half_angle_rad, bearing_polynomial(model.half_angle_rad)),
            RegionArrays(border, regions.axis, regions.edge),
            math.inf,
        )
        assert np.isfinite(log_odds).all()


@pytest.mark.parametrize("half_angle_deg", [0.5, 15, 45, 60])
def test_the_polynomial_of_the_bearing_is_exact(half_angle_deg):
    half_angle = math.radians(half_angle_deg)
    bearing = np.linspace(0, half_angle, 1001)
    t = np.tan(bearing / 2)
    share = t * np.polynomial.polynomial.polyval(t * t, bearing_polynomial(half_angle))
    np.testing.assert_allclose(share, bearing / half_angle, rtol=0, atol=1e-12)


@pytest.mark.parametrize("x", [1e-6, 1e-3, 0.5, 0.70710678, 0.7071068, 1.0, 1.5, 2.0, 1e6])
def test_the_kernels_logarithm_is_exact(x):
    assert _log(x) == pytest.approx(math.log(x), rel=1e-15, abs=1e-15)


# --- drawings ------------------------------------------------------------------------------------


def test_a_drawn_cone():
    # A sonar in the middle of the left border looks right; the reading is 4.9 cells long,
    # so that of a row's cells that lie 0.5, 1.5, 2.5 ... ahead one is within half a cell of it.
    model = sm.ParameterizedModel(p1=0.1, p2=0.1, p3_m=0.5, p4=0.9, p5_rad=math.radians(30))
    log = make_log(4.9, x_m=0.0, y_m=3.5)
    m = sm.build_map(log, model, sm.GridSpec(1.0, (0, 0), (7, 7)))
    assert draw(m.log_odds) == (
        "???????\n"
        "???.#??\n"
        "??..#??\n"
        "....#??\n"
        "??..#??\n"
        "???.#??\n"
        "???????\n"
    )  # fmt: skip


def test_a_drawn_cone_that_looks_up_and_left():
    # Rows grow with y: what is ahead of a robot that looks north is drawn above it.
    model = sm.ParameterizedModel(p1=0.1, p2=0.1, p3_m=0.5, p4=0.9, p5_rad=math.radians(25))
    log = make_log(3.9, x_m=6.5, y_m=0.5, heading_rad=math.radians(120))
    m = sm.build_map(log, model, sm.GridSpec(1.0, (0, 0), (7, 7)))
    assert draw(m.log_odds) == (
        "???????\n"
        "???????\n"
        "?????#?\n"
        "???##.?\n"
        "????..?\n"
        "?????.?\n"
        "??????.\n"
    )  # fmt: skip


# --- laws ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
def test_the_order_of_the_readings_does_not_matter(model, rng):
    log = random_log(rng, 60)
    order = rng.permutation(len(log))
    shuffled = log.replace(
        **{
            name: getattr(log, name)[order]
            for name in ("sonar", "x_m", "y_m", "heading_rad", "range_m", "stale", "rejected")
        }
    )
    a, b = (sm.build_map(each, model, GRID).log_odds for each in (log, shuffled))
    assert (a != 0).mean() > 0.1
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_maps_of_parts_add_up(model, rng):
    log = random_log(rng, 60)
    parts = [sm.build_map(log.select(part), model, GRID) for part in (slice(25), slice(25, None))]
    whole = sm.build_map(log, model, GRID).log_odds
    np.testing.assert_allclose(sum(part.log_odds for part in parts), whole, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("quarters", [1, 2, 3, -1])
def test_a_quarter_turn_of_the_log_turns_the_map(model, quarters, rng):
    log = random_log(rng, 60)
    straight = sm.build_map(log, model, GRID).log_odds
    m = sm.build_map(turned(log, quarters * math.pi / 2), model, GRID).log_odds
    # numpy turns an image, whose rows grow downwards: counter-clockwise there is clockwise here.
    np.testing.assert_allclose(m, np.rot90(straight, -quarters), rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_a_mirrored_log_gives_the_mirrored_map(model, rng):
    log = random_log(rng, 60)
    fields = THREE.to_dict()
    for name in ("y_m", "heading_rad"):
        fields[name] = [-value for value in fields[name]]
    mirrored = log.replace(
        ring=sm.SonarRing.from_dict(fields), y_m=-log.y_m, heading_rad=-log.heading_rad
    )
    straight = sm.build_map(log, model, GRID).log_odds
    m = sm.build_map(mirrored, model, GRID).log_odds
    np.testing.assert_allclose(m, straight[::-1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_the_size_of_the_cells_does_not_alter_the_model(model, rng):
    # Of each three by three fine cells the middle one has the centre of the coarse cell.
    log = random_log(rng, 40)
    coarse = sm.build_map(log, model, sm.GridSpec(0.12, (-2.4, -2.4), (40, 40))).log_odds
    fine = sm.build_map(log, model, sm.GridSpec(0.04, (-2.4, -2.4), (120, 120))).log_odds
    np.testing.assert_allclose(fine[1::3, 1::3], coarse, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_whole_turns_of_the_heading_change_nothing(model, rng):
    log = random_log(rng, 40)
    further = log.replace(heading_rad=log.heading_rad + 2 * math.pi * rng.integers(-3, 4, 40))
    a, b = (sm.build_map(each, model, GRID).log_odds for each in (log, further))
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_the_sum_of_log_odds_is_bayes_rule_applied_again_and_again(model, rng):
    # Equation 4.14 with its index slip mended, from the prior 0.5:
    #   P(H|s_n) = P(s_n|H) P(H|s_n-1) / (P(s_n|H) P(H|s_n-1) + P(s_n|not H) P(not H|s_n-1))
    readings = rng.uniform(0.9, 1.5, 12)
    bearings = rng.uniform(-0.2, 0.2, 12)
    cell_m, grid = 1.0, sm.GridSpec(0.1, (0.95, -0.05), (1, 1))
    p = 0.5
    for reading, bearing in zip(readings, bearings, strict=True):
        hit = float(model.probability(cell_m, bearing, reading).clip(1e-6, 1 - 1e-6))
        p = hit * p / (hit * p + (1 - hit) * (1 - p))
    m = sm.build_map(make_log(readings, heading_rad=-bearings), model, grid)
    assert 0.001 < p < 0.999
    assert m.probability[0, 0] == pytest.approx(p, rel=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_repeats_sharpen_the_belief_and_never_reach_certainty(model):
    beliefs = [
        sm.build_map(make_log(np.full(n, 1.0)), model, GRID).log_odds.max() for n in (1, 2, 50)
    ]
    assert beliefs == pytest.approx([beliefs[0], 2 * beliefs[0], 50 * beliefs[0]])
    assert np.isfinite(beliefs[-1])


def test_a_model_that_is_certain_is_clipped():
    certain = sm.ParameterizedModel(p1=0, p2=0.1, p3_m=0.25, p4=1, p5_rad=0.3)
    log = make_log(1.0, x_m=0.125, y_m=0.125)
    m = sm.build_map(log, certain, sm.GridSpec(0.25, (0, 0), (1, 8)))
    bound = math.log((1 - 1e-6) / 1e-6)
    assert m.log_odds[0, 0] == pytest.approx(-bound)  # P1 = 0 at the sonar
    assert m.log_odds[0, 4] == pytest.approx(bound)  # P4 = 1 at the reading


@pytest.mark.parametrize("model", MODELS)
def test_what_no_cone_touches_stays_exactly_unknown(model):
    m = sm.build_map(make_log(1.0), model, GRID)
    _, y_m = GRID.centre_of(*np.indices(GRID.shape))
    x_m, _ = GRID.centre_of(*np.indices(GRID.shape))
    outside = (np.abs(np.arctan2(y_m, x_m)) > math.radians(15)) | (np.hypot(x_m, y_m) > 1.1)
    assert (m.log_odds[outside] == 0).all()
    assert (m.probability[outside] == 0.5).all()
    assert (m.log_odds[~outside] != 0).sum() > 20


# --- which readings are used ---------------------------------------------------------------------


@pytest.mark.parametrize("no_echo", ["ignore", "clear"])
def test_stale_rejected_and_too_close_readings_are_not_used(no_echo, rng):
    log = random_log(rng, 60)
    useless = log.stale | log.rejected | (log.range_m == -np.inf)
    assert useless.sum() > 5
    with_them = sm.build_map(log, PARAMETERIZED, GRID, no_echo=no_echo)
    without = sm.build_map(log.select(~useless), PARAMETERIZED, GRID, no_echo=no_echo)
    np.testing.assert_array_equal(with_them.log_odds, without.log_odds)


def test_no_echo_says_nothing_unless_asked():
    log = make_log([np.inf, np.inf])
    assert (sm.build_map(log, PARAMETERIZED, GRID).log_odds == 0).all()
    cleared = sm.build_map(log, PARAMETERIZED, GRID, no_echo="clear", max_range_m=2.0)
    assert (cleared.log_odds < 0).any()
    assert (cleared.log_odds <= 0).all()
    # Free up to the limit less the tolerance: 1.9 m.
    free_x_m, _ = GRID.centre_of(*np.nonzero(cleared.log_odds))
    assert free_x_m.max() == pytest.approx(1.85)


@pytest.mark.parametrize("model", MODELS)
def test_readings_above_the_limit_are_no_echo(model):
    log, silent = make_log([1.0, 1.51]), make_log([1.0, np.inf])
    for no_echo in ("ignore", "clear"):
        a, b = (
            sm.build_map(each, model, GRID, max_range_m=1.5, no_echo=no_echo)
            for each in (log, silent)
        )
        np.testing.assert_array_equal(a.log_odds, b.log_odds)


def test_a_reading_at_the_limit_counts():
    assert sm.build_map(make_log(1.5), PARAMETERIZED, GRID, max_range_m=1.5).log_odds.max() > 0


def test_by_default_the_limit_is_the_rings_or_the_models():
    beyond_the_model = make_log(3.01)
    assert (sm.build_map(beyond_the_model, STANDARD, GRID).log_odds == 0).all()
    assert (sm.build_map(beyond_the_model, PARAMETERIZED, GRID).log_odds != 0).any()
    beyond_the_ring = make_log(8.01)
    assert (sm.build_map(beyond_the_ring, PARAMETERIZED, GRID).log_odds == 0).all()


def test_the_bound_on_log_odds():
    log = make_log(np.full(9, 1.0))
    free = sm.build_map(log, PARAMETERIZED, GRID).log_odds
    bounded = sm.build_map(log, PARAMETERIZED, GRID, log_odds_limit=3.5).log_odds
    np.testing.assert_allclose(bounded, free.clip(-3.5, 3.5))
    assert np.abs(free).max() > 3.5


def test_the_bound_lets_a_wall_go_that_is_there_no_more():
    # Nine readings at 1 m, then three that pass through: without a bound the past wins.
    log = make_log([1.0] * 9 + [2.0] * 3)
    wall = tuple(GRID.cell_of(1.0, 0.01))
    assert sm.build_map(log, PARAMETERIZED, GRID).log_odds[wall] > 0
    bounded = sm.build_map(log, PARAMETERIZED, GRID, log_odds_limit=1.0).log_odds
    assert bounded[wall] < 0


def test_true_poses_map_what_odometry_would_misplace(rng):
    log = random_log(rng, 30, truth=True)
    m = sm.build_map(log, PARAMETERIZED, GRID, poses="true")
    moved = sm.build_map(log.at_true_poses(), PARAMETERIZED, GRID)
    np.testing.assert_array_equal(m.log_odds, moved.log_odds)
    assert (m.log_odds != sm.build_map(log, PARAMETERIZED, GRID).log_odds).any()


# --- the default grid ----------------------------------------------------------------------------


def test_the_default_grid_holds_every_cone(rng):
    # The half-width of a 15-degree cone at 1.5 m is 0.4 m, the tolerance 0.1 m: within the margin.
    log = random_log(rng, 40, reach_m=1.5)
    m = sm.build_map(log, PARAMETERIZED)
    assert m.grid.resolution_m == 0.05
    wide = sm.GridSpec.covering(-5, -5, 5, 5, 0.05)
    touched = np.count_nonzero(sm.build_map(log, PARAMETERIZED, wide).log_odds)
    assert np.count_nonzero(m.log_odds) == touched > 1000


def test_grid_over_a_log_is_its_points_and_a_margin():
    log = make_log([2.0, np.inf, -np.inf, 9.0], x_m=[0, 0, -1.0, 0], y_m=[0, 0, 0, 0.5])
    # Points from (-1, 0) to (2, 0) and (0, 0.5); that of 9.0 m lies beyond the ring's 8 m.
    assert grid_over(log, resolution_m=0.25, margin_m=0.5) == sm.GridSpec(
        0.25, (-1.5, -0.5), (6, 16)
    )
    assert grid_over(log, resolution_m=0.25, margin_m=0).extent_m == (-1.0, 2.0, 0.0, 0.5)
    assert grid_over(log, resolution_m=0.25, margin_m=0, max_range_m=1.0).extent_m[1] == 0.0


def test_a_log_that_heard_nothing_has_a_map_all_the_same():
    m = sm.build_map(make_log([np.inf, np.inf]), PARAMETERIZED)
    assert m.grid.shape == (20, 20)
    assert (m.probability == 0.5).all()


# --- bad input -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"no_echo": "clera"}, "no_echo 'clera' is unknown; did you mean 'clear'?"),
        ({"poses": "truth"}, "poses 'truth' is unknown; did you mean 'true'?"),
        ({"poses": "true"}, "the log has no truth (a real robot's?), needed for true poses"),
        ({"max_range_m": 0}, "max_range_m must be > 0, got 0"),
        ({"max_range_m": math.nan}, "max_range_m must be > 0, got nan"),
        ({"log_odds_limit": 0}, "log_odds_limit must be > 0, got 0"),
        ({"log_odds_limit": math.nan}, "log_odds_limit must be > 0, got nan"),
    ],
)
def test_bad_arguments_are_refused(options, message):
    with pytest.raises(sm.InputError) as refusal:
        sm.build_map(make_log(1.0), PARAMETERIZED, GRID, **options)
    assert str(refusal.value) == message


def test_an_empty_log_has_no_default_grid():
    empty = make_log(1.0).select(slice(0))
    with pytest.raises(sm.InputError, match="the log is empty: there is nothing to map"):
        sm.build_map(empty, PARAMETERIZED)
    assert (sm.build_map(empty, PARAMETERIZED, GRID).log_odds == 0).all()


def test_the_log_is_left_as_it_was(rng):
    log = random_log(rng, 20)
    before = log.range_m.copy()
    sm.build_map(log, STANDARD, GRID, no_echo="clear")
    np.testing.assert_array_equal(log.range_m, before)
    assert ONE.range_max_m == 8.0
