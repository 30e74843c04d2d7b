"""What the sources print, maps that can be drawn, and parameters that break a rule."""

import math

import numpy as np
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarmap.kernels.arcs import clustered_crossings, median_crossings
from sonarmap.methods.conversion import LOGISTIC_SPACE

# A sonar in a cell's centre that looks along a row of cells: no rounding, borders on the spot.
ROW = sm.GridSpec(0.25, (0, 0), (1, 16))
SEVEN = sm.GridSpec(1.0, (0, 0), (7, 7))
NARROW = sm.SonarRing("narrow", [0], [0], [0], math.radians(2), 0.1, 8.0)
WIDE = sm.SonarRing("wide", [0], [0], [0], math.radians(30), 0.1, 8.0)


def on_row(range_m, *, ring=NARROW, **parameters):
    """Return P(occupied) of a row of cells ahead of a sonar, 0, 0.25, 0.5 ... metres away."""
    name = parameters.pop("name")
    log = make_log(range_m, ring=ring, x_m=0.125, y_m=0.125)
    return sm.method(name, **parameters).map(log, ROW).probability[0]


def log_odds(p):
    return np.log(p / (1 - p))


# --- numbers in print ----------------------------------------------------------------------------


def test_table_9_2_with_the_udacity_constants():
    # 0.4 and -0.4 are 0.599 and 0.401; the arc is 0.2 m thick, its borders excluded.
    p = on_row(1.0, name="thrun-inverse", thickness_m=0.5)
    free, wall = 1 / (1 + math.exp(0.4)), 1 / (1 + math.exp(-0.4))
    np.testing.assert_allclose(p, [free] * 4 + [wall] + [0.5] * 11)


def test_a_reading_of_the_maximum_range_has_no_arc_in_table_9_2():
    p = on_row(2.0, name="thrun-inverse", max_range_m=2.0, thickness_m=0.6)
    assert (p[:9] < 0.5).all()
    assert (p[9:] == 0.5).all()


@pytest.mark.parametrize(
    ("masses", "result"),
    [
        # Murphy 2000, section 11.4: 0.4 and 0.6 for occupied; and in conflict, K = 0.24.
        ([(0.4, 0), (0.6, 0)], (0.76, 0.0, 0.24)),
        ([(0.4, 0), (0, 0.6)], (0.2105, 0.4737, 0.3158)),
    ],
)
def test_dempsters_rule_is_the_books(masses, result):
    from sonarmap.kernels.layers import add_masses

    layers = np.zeros(1), np.zeros(1), np.ones(1)
    for occupied, free in masses:
        # A cell at the sonar, on an arc or before it, whose belief times max_occupied is the mass.
        share = 2 * (1 - (occupied or free))
        add_masses(
            *layers,
            np.array([0, 1]),
            np.array([0]),
            np.zeros(1),
            np.array([share]),
            np.array([0.0 if occupied else 5.0]),
            np.array([True]),
            1.0,
            0.1,
            1.0,
            0,
        )
    assert [float(each[0]) for each in layers] == pytest.approx(result, abs=5e-5)


@pytest.mark.parametrize("no_echo", ["ignore", "clear"])
def test_dempsters_rule_on_relative_plausibilities_is_bayes_rule(no_echo, rng):
    log, grid = random_log(rng, 80), sm.GridSpec(0.1, (-2.5, -2.5), (50, 50))
    bayes = sm.method("bayes-standard", no_echo=no_echo).map(log, grid).probability
    evidence = sm.method("dempster-shafer", matching="plausibility", no_echo=no_echo)
    np.testing.assert_allclose(evidence.map(log, grid).probability, bayes, atol=1e-9)
    pignistic = sm.method("dempster-shafer", no_echo=no_echo).map(log, grid).probability
    assert np.abs(pignistic - bayes).max() > 0.05


def test_himm_counts_as_the_book_draws_it():
    # Murphy 2000, page 399: two hits are 6; a hit on the next cell is 3 and takes 1 from the first.
    def counts(*readings):
        return 15 * on_row(readings, name="himm")

    near, far = 1.0, 1.25
    assert counts(near, near)[4] == pytest.approx(6)
    assert counts(near, near, far)[4:6] == pytest.approx([5, 3])
    assert counts(*[near] * 6)[4] == 15
    assert counts(near, *[far] * 4)[4] == 0


def test_the_growth_rate_operator_adds_half_of_the_neighbours():
    p = on_row([1.0, 1.25, 1.0], name="himm", growth=0.5)
    # 3; then 3 + (3 - 1) / 2 behind it; then 2 + 3 + 4 / 2.
    assert 15 * p[4:6] == pytest.approx([7, 4])


def test_moravec_and_elfes_cancel_by_what_all_readings_found_empty():
    # The first reading's arc is passed by the second's beam: what is left of it is weaker.
    first, both = (on_row(each, name="moravec-elfes", error_m=0.3) for each in (1.0, [1.0, 3.0]))
    assert first[4] > 0.8
    assert both[4] < first[4]
    emptiness = 1 - ((1.0 - 0.1) / (3.0 - 0.3 - 0.1)) ** 2
    shares = np.array([1 - (0.25 / 0.3) ** 2, 1, 1 - (0.25 / 0.3) ** 2])  # cells 0.75, 1, 1.25 m
    empty = [1 - ((r - 0.1) / 2.6) ** 2 for r in (0.75, 1.0, 1.25)]
    left = shares * (1 - np.array(empty))
    assert emptiness > left[1] / left.sum()
    assert both[4] == pytest.approx((1 - emptiness) / 2)


def test_a_wide_arc_is_weak_in_each_cell_as_it_holds_one_obstacle():
    grid = sm.GridSpec(0.05, (0, -2), (80, 80))
    for reading in (0.5, 1.0, 2.0):
        m = sm.method("moravec-elfes").map(make_log(reading), grid)
        assert (2 * m.probability[m.probability > 0.5] - 1).sum() == pytest.approx(1)


def test_the_profile_of_muriel():
    # D = 2 m, F = 0.1 per metre: log-odds at 0.5, 1, 1.5 and 2 m, and nothing beyond 2.2 m.
    p = on_row(2.0, name="konolige-style", max_range_m=3.0)
    assert log_odds(p[[2, 4, 6, 8]]) == pytest.approx([-1.07, -0.83, -0.63, 3.22], abs=5e-3)
    assert p[9:] == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize(
    ("z", "peak"), [(0.5, 0.971), (1.0, 0.845), (1.5, 0.616), (2.0, 0.520), (3.0, 0.5004)]
)
def test_nav2_believes_less_the_farther(z, peak):
    # On the axis at the reading, where the cell was set to 233 of 254 before the model spoke.
    p = on_row(z, name="nav2-range")[int(z / 0.25)]
    hit, miss = peak * 233, (1 - peak) * (254 - 233)
    assert p == pytest.approx(hit / (hit + miss), abs=1 / 254)


def test_one_half_leaves_every_cost_of_nav2_as_it_is():
    # The compiled loop passes over cells that the model says 1/2 of.
    for cost in range(255):
        p = cost / 254
        assert int(254 * (0.5 * p / (0.5 * p + 0.5 * (1 - p)))) == cost


def test_nav2_gets_stuck_at_zero():
    # cost = floor(254 p): a few free readings, and no number of hits brings the cell back.
    free = on_row([1.5] * 4, name="nav2-range", phi_m=5.0)
    assert free[1] == 0
    again = on_row([*[1.5] * 4, *[0.3] * 50], name="nav2-range", phi_m=5.0)
    # But for the cell of the reading on the axis, which is set and not updated.
    assert again[1] > 0.9
    assert again[0] == 0


def test_nav2_marks_above_and_clears_below_its_thresholds():
    # In costs: 0.8 is 203 and 0.2 is 50, and neither counts.
    m = sm.method("nav2-range").map(make_log(1.0), ROW)
    assert 203 < 254 * m.occupied_from < 204
    assert 49 < 254 * m.free_up_to < 50


def test_nav2_drops_no_echo_and_what_is_out_of_range():
    assert (on_row([np.inf, 0.05, 9.0], name="nav2-range") == 0.5).all()
    assert (on_row([np.inf], name="nav2-range", no_echo="clear")[:8] == 0).all()


def test_fuzzy_sets_on_the_axis():
    seen = 1 - (1 + math.tanh(2 * (1.0 - 1.2))) / 2
    p = on_row(1.0, name="fuzzy", thickness_m=0.2)
    assert p[4] == pytest.approx((1 + 0.25 * seen) / 2)
    assert p[1] == pytest.approx((1 - 0.1 * (1 - (1 + math.tanh(2 * (0.25 - 1.2))) / 2)) / 2)
    assert (p[5:] == 0.5).all()


def test_the_sparse_kernel_is_one_at_its_middle():
    # An arc of less than a cell weighs 1; prior 0.001 each.
    p = on_row(1.0, name="bki")
    assert p[4] == pytest.approx(1.001 / 1.002)
    assert p[1] == pytest.approx(0.001 / 1.002)
    # Half of l away: (2 + cos pi) / 6 + sin(pi) / (2 pi).
    p = on_row(1.1, name="bki", prior=1.0)
    assert p[4] == pytest.approx((1 + 1 / 6) / (2 + 1 / 6 + 1 / 6))


def test_the_loudest_reading_of_a_cell_decides():
    # A far reading passes through where a near one heard a wall: the near one is louder there.
    log = make_log([1.0, 3.0], ring=NARROW, y_m=0.125, x_m=[0.625, 0.125])
    m = sm.method("conflict-evaluation-style", path_cells=0)
    p = m.map(log, ROW).probability[0]
    # The far one is wrong and cut to the wall at 1.625 m: nothing is said behind it.
    assert p[6] == 1
    assert (p[:6] == 0).all()
    assert (p[7:] == 0.5).all()


def test_short_readings_are_louder_on_their_arcs_in_conflict_evaluation():
    # At cell 3 the first has -log10(0.75) and log10(2), the second, free there, -log10(0.5).
    log = make_log([0.75, 2.0], ring=NARROW, y_m=0.125, x_m=[0.125, 0.375])
    for short_m, p in ((0.8, 1), (0.7, 0)):
        m = sm.method("conflict-evaluation-style", path_cells=0, short_m=short_m).map(log, ROW)
        assert m.probability[0, 3] == p


@pytest.mark.parametrize("readings", [[1.0, 3.0], [3.0, 1.0]])
def test_of_equally_loud_readings_the_wall_wins_in_conflict_evaluation(readings):
    p = on_row(readings, name="conflict-evaluation-style", path_cells=0)
    assert (p[4:6] == [1, 0.5]).all()


def test_an_arc_that_nothing_explains_is_wrong_in_conflict_evaluation():
    # From cell 1 one reads 3 m and one, 0.25 m, the wall in cell 2 that makes the first wrong; from
    # cell 6 one looks back at cell 3, where the first was louder. Nobody is left to tell of cell 3.
    log = make_log(
        [3.0, 0.25, 0.75],
        ring=NARROW,
        y_m=0.125,
        x_m=[0.375, 0.375, 1.625],
        heading_rad=[0, 0, math.pi],
    )
    m = sm.method("conflict-evaluation-style", path_cells=0).map(log, ROW)
    assert draw(m.probability) == "?.#?...?????????\n"


def test_a_ghost_close_by_wins_its_cells():
    # The weak spot: one short ghost, and ten readings that pass through it, all from one place.
    p = on_row([0.5, *[2.0] * 10], name="conflict-evaluation-style", path_cells=0)
    assert p[2] == 1


def test_the_gaussian_models_peak_and_its_two_sides():
    m = sm.method("bayes-gaussian", sigma_m=0.05, density_per_m=0.3, detection=0.9)
    p = on_row(1.0, name="bayes-gaussian")
    # v = lambda sigma = 0.015: Phi + phi / 0.015 = 27.1 at the reading.
    v = 0.015
    phi = math.exp(-v * v / 2) / math.sqrt(2 * math.pi)
    ratio = 0.1 + 0.9 * ((1 + math.erf(v / math.sqrt(2))) / 2 + phi / 0.015)
    assert log_odds(p[4]) == pytest.approx(math.log(ratio))
    assert p[1] == pytest.approx(0.1 / 1.1)
    assert (p[6:] == 0.5).all()
    assert m.longest_reading_m(NARROW) == 8


# --- arcs ----------------------------------------------------------------------------------------


def two_arcs(at=(2.0, 1.0)):
    """Return places, axes and readings of two sonars that look up and right at one point."""
    xy = np.array([[at[0], 0.0], [0.0, at[1]]])
    along = np.array([[0.0, 1.0], [1.0, 0.0]])
    return xy, along, np.array([at[1], at[0]])


def test_two_arcs_cross_at_the_point_that_both_saw():
    bearing = median_crossings(*two_arcs(), math.cos(0.2), math.cos(0.5))
    np.testing.assert_allclose(bearing, [0, 0], atol=1e-12)
    # They cross at a right angle: no threshold below it drops them.
    assert np.isfinite(median_crossings(*two_arcs(), math.cos(0.2), math.cos(1.57))).all()


def test_arcs_along_each_other_are_not_transversal():
    xy, along = np.array([[0.0, 0.0], [0.1, 0.0]]), np.array([[0.0, 1.0], [0.0, 1.0]])
    reading = np.array([1.0, 1.0])
    assert np.isnan(median_crossings(xy, along, reading, math.cos(0.3), math.cos(0.5))).all()
    bearing = median_crossings(xy, along, reading, math.cos(0.3), 1.0)
    np.testing.assert_allclose(bearing, [-math.asin(0.05), math.asin(0.05)])


def test_the_median_is_not_moved_by_one_stray_arc():
    # Four sonars see the point (2, 1), a fifth reads 30 cm short.
    angles = np.radians([-90, -40, 0, 40, 85])
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    reading = np.array([1.0, 1.1, 0.9, 1.3, 0.7])
    xy = np.array([2.0, 1.0]) - along * np.where(np.arange(5) == 4, 1.0, reading)[:, None]
    bearing = median_crossings(xy, along, reading, math.cos(0.4), math.cos(0.3))
    assert np.abs(bearing[:4]).max() < 1e-9


def test_the_median_of_two_crossings_is_their_mean():
    # One looks up; two look right, at its arc 0.1 to the left and 0.05 to the right of its axis.
    bearing = np.array([0.1, -0.05])
    ends = np.column_stack([-np.sin(bearing), np.cos(bearing)])
    xy = np.vstack([[0.0, 0.0], ends - [1.0, 0.0]])
    along = np.array([[0.0, 1.0], [1.0, 0.0], [1.0, 0.0]])
    found = median_crossings(xy, along, np.ones(3), math.cos(0.2), math.cos(0.5))
    assert found[0] == pytest.approx(0.025)
    assert found[1:] == pytest.approx([0, 0])


def test_a_triangulation_point_needs_its_votes():
    angles = np.radians([-90, -60, -30, 0])
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    reading = np.array([1.0, 1.2, 0.8, 1.5])
    xy = np.array([2.0, 1.0]) - along * reading[:, None]
    options = (xy, along, reading, math.cos(0.2), 1.0)
    for least, found in ((1, 3), (2, 2), (3, 1), (4, 0)):
        bearing = clustered_crossings(*options, 10, 0.05, least)
        # Only older arcs vote.
        assert np.isfinite(bearing).tolist() == [i >= 4 - found for i in range(4)]
        np.testing.assert_allclose(bearing[np.isfinite(bearing)], 0, atol=1e-9)
    assert np.isfinite(clustered_crossings(*options, 2, 0.05, 3)).sum() == 0  # a short memory


@pytest.mark.parametrize("name", ["atm", "tbf"])
def test_no_echo_ends_nowhere_not_even_in_a_cell_at_the_limit(name):
    p = on_row(np.inf, name=name, no_echo="clear", max_range_m=2.0)
    assert (p[:9] < 0.5).all()
    assert (p[9:] == 0.5).all()


# --- drawings ------------------------------------------------------------------------------------

CONE = (
    "???????\n"
    "???.#??\n"
    "??..#??\n"
    "....#??\n"
    "??..#??\n"
    "???.#??\n"
    "???????\n"
)  # fmt: skip
AXIS = (
    "???????\n"
    "???????\n"
    "???????\n"
    "....#??\n"
    "???????\n"
    "???????\n"
    "???????\n"
)  # fmt: skip
# The standard model's, empty on the arc and occupied before it but near the axis: a cell off it
# has ((8 - 4.61) / 8 + (30 - 12.5) / 30) / 2 * 0.98 = 0.4935.
STANDARD_MODEL = (
    "???????\n"
    "???#.??\n"
    "??#..??\n"
    "....#??\n"
    "??#..??\n"
    "???#.??\n"
    "???????\n"
)  # fmt: skip
PICTURES = {
    "bayes-gaussian": ({"sigma_m": 0.2}, CONE),
    "bki": ({"length_m": 0.5, "spread": 0.0}, CONE),
    "conflict-evaluation-style": ({"thickness_m": 0.5, "path_cells": 0}, CONE),
    "dempster-shafer": ({"tolerance_m": 0.5}, STANDARD_MODEL),
    "fuzzy": ({"thickness_m": 0.5, "visible_m": 9}, CONE),
    "himm": ({"up": 9.0}, AXIS),
    "konolige-style": ({"sigma_m": 0.15, "sigma_slope": 0, "detection_reach_m": 9}, CONE),
    "moravec-elfes": ({"error_m": 0.5}, CONE),
    "thrun-inverse": ({"thickness_m": 1.0}, CONE),
}


def draw(p):
    """Return the drawing of a map; what is unknown but for a trace counts as unknown."""
    signs = np.where(np.abs(p - 0.5) < 1e-4, "?", np.where(p > 0.5, "#", "."))
    return "\n".join("".join(row) for row in signs[::-1]) + "\n"


@pytest.mark.parametrize("name", list(PICTURES))
def test_a_drawn_cone(name):
    # A sonar in the middle of the left border looks right; the reading is 4.6 cells long.
    parameters, picture = PICTURES[name]
    log = make_log(4.6, ring=WIDE, x_m=0.0, y_m=3.5)
    assert draw(sm.method(name, **parameters).map(log, SEVEN).probability) == picture


def test_nav2_draws_a_cone_where_its_cells_are_small():
    # The blur of the reading is the resolution as a fraction of it: cells of a metre have no cone.
    log = make_log(0.46, ring=WIDE, x_m=0.0, y_m=0.35)
    p = sm.method("nav2-range").map(log, sm.GridSpec(0.1, (0, 0), (7, 7))).probability
    assert draw(p) == CONE


def test_two_drawn_arcs_meet_in_a_point():
    # One looks right from the left border, one up from the bottom: both 4.5 cells long.
    log = make_log([4.5, 3.5], ring=WIDE, x_m=[0, 4.5], y_m=[3.5, 0], heading_rad=[0, math.pi / 2])
    for name, parameters in (("atm", {}), ("tbf", {"least": 1})):
        method = sm.method(name, tolerance_m=0.9, point_weight=9, **parameters)
        p = method.map(log, SEVEN).probability
        assert draw(p) == (
            "???????\n"
            "???????\n"
            "??.????\n"
            "....#??\n"
            "??.?.??\n"
            "????.??\n"
            "????.??\n"
        )  # fmt: skip


def test_a_drawn_drive():
    # A robot of 0.9 m radius drives along the middle row: what its body covered.
    log = make_log([1.0] * 3, x_m=[1.5, 2.5, 3.5], y_m=3.5)
    p = sm.method("free-space", radius_m=1.1).map(log, SEVEN).probability
    assert draw(np.where(p == 0.06, 0.5, p)) == (
        "???????\n"
        "???????\n"
        "?...???\n"
        ".....??\n"
        "?...???\n"
        "???????\n"
        "???????\n"
    )  # fmt: skip


# --- conversion ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [n for n in sm.methods() if hasattr(sm.methods()[n], "scale")])
def test_the_logistic_has_two_numbers_and_orders_cells_alike(name, rng):
    log, grid = random_log(rng, 60), sm.GridSpec(0.1, (-2.5, -2.5), (50, 50))
    plain, fitted = sm.method(name).map(log, grid), sm.method(name, scale=3.0, offset=-2.0)
    p = fitted.map(log, grid).probability
    unseen = plain.probability == 0.5
    # A cell of which nothing is known gets the share of walls.
    assert p[unseen] == pytest.approx(1 / (1 + math.exp(2)))
    assert (np.diff(p.ravel()[np.argsort(plain.probability.ravel())]) >= -1e-12).all()
    assert set(LOGISTIC_SPACE).isdisjoint(sm.methods()[name].space())


def test_the_logistic_is_of_support_or_of_log_odds():
    # HIMM: a count of 3 of 15 is a support of -0.6. Thrun's model: log-odds of 0.4.
    p = on_row(1.0, name="himm", scale=2.0, offset=-1.0)
    assert log_odds(p[4]) == pytest.approx(-1 + 2 * -0.6)
    p = on_row(1.0, name="thrun-inverse", scale=2.0)
    assert log_odds(p[4]) == pytest.approx(2 * 0.4)
    p = on_row(1.0, name="thrun-inverse", offset=-2.0)
    assert log_odds(p[4]) == pytest.approx(0.4 - 2)


@pytest.mark.parametrize("name", [n for n in sm.methods() if hasattr(sm.methods()[n], "scale")])
def test_observed_are_the_cells_that_a_reading_speaks_of(name, rng):
    log, grid = random_log(rng, 30), sm.GridSpec(0.1, (-3.5, -3.5), (70, 70))
    m = sm.method(name).map(log, grid)
    assert m.observed is not None
    assert 0.01 < m.observed.mean() < 0.9
    assert (m.probability[~m.observed] == 0.5).all()


# --- bad parameters ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("sheet", {"share": 0}, r"share must be in \(0, 1\), got 0"),
        ("sheet", {"share": math.nan}, "share must be a finite number, got nan"),
        ("free-space", {"radius_m": 0}, "radius_m must be > 0, got 0"),
        ("free-space", {"driven": 0.1}, "driven must be <= share 0.06, got 0.1"),
        # of every method of evidence
        ("himm", {"no_echo": "clera"}, "no_echo 'clera' is unknown; did you mean 'clear'.*"),
        ("himm", {"max_range_m": -1}, "max_range_m must be > 0, got -1"),
        ("himm", {"scale": math.inf}, "scale must be a finite number, got inf"),
        ("himm", {"offset": "a"}, "offset must be a number, got 'a'"),
        ("himm", {"half_angle_rad": 0.2}, "method 'himm' has no parameter 'half_angle_rad'.*"),
        ("bki", {"half_angle_rad": 0}, r"half_angle_rad must be in \(0, pi/2\), got 0"),
        ("bki", {"half_angle_rad": 15}, r"half_angle_rad must be in \(0, pi/2\), got 15"),
        # of one
        ("thrun-inverse", {"thickness_m": 0}, "thickness_m must be > 0, got 0"),
        ("thrun-inverse", {"occupied_log_odds": -1}, "occupied_log_odds must be > 0, got -1"),
        ("thrun-inverse", {"free_log_odds": 0}, "free_log_odds must be < 0, got 0"),
        ("bayes-gaussian", {"sigma_m": 0}, "sigma_m must be > 0, got 0"),
        ("bayes-gaussian", {"sigma_rad": -0.1}, "sigma_rad must be > 0, got -0.1"),
        ("bayes-gaussian", {"detection": 1}, r"detection must be in \(0, 1\), got 1"),
        ("bayes-gaussian", {"density_per_m": 0}, "density_per_m must be > 0, got 0"),
        ("dempster-shafer", {"matching": "pignsitic"}, "matching 'pignsitic' is .*'pignistic'.*"),
        ("dempster-shafer", {"max_occupied": 0.5}, r"max_occupied must be in \(0.5, 1\], got 0.5"),
        ("dempster-shafer", {"tolerance_m": 0}, "tolerance_m must be > 0, got 0"),
        ("himm", {"up": 0}, "up must be > 0, got 0"),
        ("himm", {"down": -1}, "down must be >= 0, got -1"),
        ("himm", {"top": 0}, "top must be > 0, got 0"),
        ("himm", {"growth": -0.5}, "growth must be >= 0, got -0.5"),
        ("moravec-elfes", {"error_m": 0}, "error_m must be > 0, got 0"),
        ("nav2-range", {"phi_m": 0}, "phi_m must be > 0, got 0"),
        ("nav2-range", {"inflate_cone": 2}, r"inflate_cone must be within \[0, 1\], got 2"),
        ("nav2-range", {"mark_threshold": 0.1}, r"mark_threshold must be within \[0.2, 1\].*"),
        ("fuzzy", {"most_empty": 1}, r"most_empty must be in \(0, 1\), got 1"),
        ("fuzzy", {"most_occupied": 0}, r"most_occupied must be in \(0, 1\), got 0"),
        ("fuzzy", {"power": 0}, "power must be > 0, got 0"),
        ("fuzzy", {"reading": "safe"}, "reading 'safe' is unknown.*"),
        ("konolige-style", {"detection": 1}, r"detection must be in \(0, 1\), got 1"),
        ("konolige-style", {"false_share": 0.4}, r"false_share must be in \(0, 1 - .* 0.6\).*0.4"),
        ("konolige-style", {"bucket_m": 0}, "bucket_m must be > 0, got 0"),
        ("konolige-style", {"specular": 1.1}, r"specular must be within \[0, 1\], got 1.1"),
        ("atm", {"crossing_rad": 2}, "crossing_rad must be < pi/2, got 2"),
        ("atm", {"lonely": "center"}, "lonely 'center' is unknown; did you mean 'centre'.*"),
        ("atm", {"point_weight": 0}, "point_weight must be > 0, got 0"),
        ("tbf", {"window_scans": 0}, "window_scans must be >= 1, got 0"),
        ("tbf", {"least": 1.5}, "least must be a whole number, got 1.5"),
        ("tbf", {"cluster_m": 0}, "cluster_m must be > 0, got 0"),
        ("bki", {"length_m": 0}, "length_m must be > 0, got 0"),
        ("bki", {"spread": -0.1}, r"spread must be within \[0, 1\], got -0.1"),
        ("bki", {"prior": 0}, "prior must be > 0, got 0"),
        ("conflict-evaluation-style", {"thickness_m": 0}, "thickness_m must be > 0, got 0"),
        ("conflict-evaluation-style", {"short_m": -1}, "short_m must be >= 0, got -1"),
        ("conflict-evaluation-style", {"path_cells": -1}, "path_cells must be >= 0, got -1"),
    ],
)
def test_bad_parameters_are_refused(name, parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.method(name, **parameters)
