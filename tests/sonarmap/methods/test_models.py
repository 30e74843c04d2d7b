import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support import equations

import sonarmap as sm

# The thesis's own settings, in its units (one unit is 0.1 m; here simply 1).
STANDARD = sm.StandardModel(
    beta_rad=math.radians(15), max_range_m=10, max_occupied=0.98, tolerance_m=0.5
)
PARAMETERIZED = sm.ParameterizedModel(p1=0.02, p2=0.15, p3_m=1.0, p4=0.98, p5_rad=math.radians(15))
MODELS = [STANDARD, PARAMETERIZED]
EPS = 1e-12


@st.composite
def parameterized_models(draw):
    p1 = draw(st.floats(0, 0.49))
    p4 = draw(st.floats(0.51, 1))
    return sm.ParameterizedModel(
        p1=p1,
        p2=draw(st.floats(0, 1)) * min(0.5 - p1, p4 - 0.5),
        p3_m=draw(st.floats(0.01, 1)),
        p4=p4,
        p5_rad=draw(st.floats(0.05, math.pi / 3)),
    )


@st.composite
def standard_models(draw):
    return sm.StandardModel(
        beta_rad=draw(st.floats(0.05, math.pi / 3)),
        max_range_m=draw(st.floats(1, 20)),
        max_occupied=draw(st.floats(0.51, 1)),
        tolerance_m=draw(st.floats(0.01, 1)),
    )


# --- values in print -----------------------------------------------------------------------------


def test_book_value_in_region_2():
    # Murphy 2000, figure 11.5, prints 0.83 for P(s|Empty): ((10 - 3.5)/10 + (15 - 0)/15) / 2.
    assert 1 - STANDARD.probability(3.5, 0, 6) == pytest.approx(0.825, abs=EPS)


def test_book_value_in_region_1():
    # Murphy 2000, figure 11.4, prints 0.52: ((10 - 6)/10 + (15 - 5)/15) / 2 * 0.98.
    p = STANDARD.probability(6, math.radians(5), 6)
    assert p == pytest.approx(0.5226666666666667, abs=EPS)


# --- the equations, one cell at a time -----------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("reading", [0.0, 0.3, 0.5, 1.0, 6.0, 9.7, 10.0, 10.4])
def test_probability_is_the_equations_on_a_dense_table(model, reading):
    # Steps of 1/16 unit hit the borders of the regions exactly, on both sides and on the spot.
    ranges = np.arange(0, 12, 1 / 16)
    bearings = np.radians(np.arange(-17, 17.5, 0.5))
    table = model.probability(ranges[:, None], bearings, reading)
    literal = [[equations(model, r, abs(a), reading) for a in bearings] for r in ranges]
    np.testing.assert_allclose(table, literal, rtol=0, atol=EPS)


@given(st.one_of(standard_models(), parameterized_models()), st.data())
@settings(derandomize=True, max_examples=300)
def test_probability_is_the_equations_for_any_parameters(model, data):
    reading = data.draw(st.floats(0, 20))
    r = data.draw(st.floats(0, 22))
    a = data.draw(st.floats(0, 1)) * model.half_angle_rad * 1.1
    p = model.probability(r, a, reading)
    assert p == pytest.approx(equations(model, r, a, reading), abs=1e-9)


# --- the shape of the parameterized model --------------------------------------------------------


@given(parameterized_models(), st.floats(0, 1), st.floats(0, 1), st.floats(0.02, 8))
@settings(derandomize=True, max_examples=300)
def test_region_2_never_says_occupied_nor_region_1_empty(model, along, across, reading):
    near, far = max(reading - model.p3_m, 0), reading + model.p3_m
    bearing = across * model.p5_rad
    if near > 0:
        below = math.nextafter(near, 0) * along
        assert model.probability(below, bearing, reading) <= 0.5 + EPS
    assert model.probability(near + along * (far - near), bearing, reading) >= 0.5 - EPS


@given(parameterized_models(), st.floats(0.02, 8))
@settings(derandomize=True)
def test_the_peak_is_p4_at_the_reading(model, reading):
    ranges = np.linspace(0, reading + 2, 101)
    bearings = np.linspace(-model.p5_rad, model.p5_rad, 9)
    assert model.probability(reading, 0, reading) == pytest.approx(model.p4, abs=EPS)
    assert model.probability(ranges[:, None], bearings, reading).max() <= model.p4 + EPS


@pytest.mark.parametrize(
    ("range_m", "p"),
    [
        # line 1: from P1 at the sonar to 0.5 - P2
        (0.0, 0.02),
        (2.5, (0.02 + 0.35) / 2),
        (math.nextafter(5.0, 0), 0.35),
        # line 3: jumps to 0.5 + P2, rises to P4
        (5.0, 0.65),
        (5.5, (0.65 + 0.98) / 2),
        (6.0, 0.98),
        # line 4: falls to 0.5 + P2, then silence
        (6.5, (0.65 + 0.98) / 2),
        (7.0, 0.65),
        (math.nextafter(7.0, 8), 0.5),
        (9.0, 0.5),
    ],
)
def test_the_lines_on_the_axis(range_m, p):
    assert PARAMETERIZED.probability(range_m, 0, 6.0) == pytest.approx(p, abs=1e-9)


def test_off_the_axis_belief_fades_linearly_to_nothing_at_the_edge():
    half_way, edge = math.radians(7.5), math.radians(15)
    for r in (1.0, 4.0, 5.5, 6.0, 6.9):
        on_axis = PARAMETERIZED.probability(r, 0, 6) - 0.5
        assert PARAMETERIZED.probability(r, half_way, 6) - 0.5 == pytest.approx(on_axis / 2)
        assert PARAMETERIZED.probability(r, edge, 6) == pytest.approx(0.5, abs=EPS)


def test_a_reading_within_p3_has_no_region_2():
    # S = 0.4 < P3 = 1: the sonar itself lies on line 3.
    assert PARAMETERIZED.probability(0, 0, 0.4) == pytest.approx(0.65 + 0.33 * 0.6)


def test_p2_may_be_as_large_as_its_bound_reads():
    # 0.7 - 0.5 is 0.19999999999999996.
    assert sm.ParameterizedModel(p1=0.3, p2=0.2, p3_m=1, p4=0.7, p5_rad=0.2).p2 == 0.2


# --- the shape of the standard model -------------------------------------------------------------


@given(standard_models(), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
@settings(derandomize=True)
def test_the_standard_model_never_exceeds_max_occupied_in_region_1(model, across, along, share):
    reading = share * model.max_range_m
    near = max(reading - model.tolerance_m, 0)
    r = near + along * (reading + model.tolerance_m - near)
    p = model.probability(r, across * model.beta_rad, reading)
    assert p <= model.max_occupied + EPS


def test_the_standard_models_known_blemishes_are_kept():
    # Section 5.1 of the thesis: the corners of region 2 say occupied, those of region 1 empty.
    edge = STANDARD.beta_rad
    assert STANDARD.probability(5.0, edge, 6) == pytest.approx(1 - 0.25)
    assert STANDARD.probability(6.0, edge, 6) == pytest.approx(0.2 * 0.98)


def test_the_standard_model_is_silent_for_readings_beyond_its_range():
    assert STANDARD.probability(3.0, 0, 10.0) != 0.5
    assert STANDARD.probability(3.0, 0, math.nextafter(10.0, 11)) == 0.5


# --- both ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", MODELS)
def test_left_and_right_are_alike(model):
    r, a = np.linspace(0, 8, 33)[:, None], np.linspace(0, 0.3, 13)
    assert np.array_equal(model.probability(r, a, 6), model.probability(r, -a, 6))


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("reading", [math.inf, -math.inf, math.nan, -1.0])
def test_what_is_no_range_says_nothing(model, reading):
    assert (model.probability(np.linspace(0, 8, 9), 0, reading) == 0.5).all()


@pytest.mark.parametrize("model", MODELS)
def test_outside_of_the_cone_is_silence(model):
    just_outside = math.nextafter(model.half_angle_rad, 4)
    bearings = [just_outside, math.pi / 2, math.pi, -math.pi, -just_outside]
    assert (model.probability(3.0, bearings, 6) == 0.5).all()


@pytest.mark.parametrize("model", MODELS)
def test_arguments_broadcast(model):
    r, a, s = np.ones((4, 1, 1)), np.zeros((3, 1)), np.full(2, 6.0)
    p = model.probability(r, a, s)
    assert p.shape == (4, 3, 2)
    assert (p == model.probability(1.0, 0.0, 6.0)).all()
    assert model.probability(1.0, 0.0, 6.0).shape == ()
    assert model.probability([], 0.0, 6.0).shape == (0,)


@given(st.one_of(standard_models(), parameterized_models()), st.floats(0, 20))
@settings(derandomize=True)
def test_regions_lie_one_behind_the_other(model, reading):
    regions = model.regions(np.array([reading]))
    assert (np.diff(regions.border_m) >= 0).all()
    assert (regions.border_m >= 0).all()
    assert regions.reach_m == regions.border_m[:, -1]


@pytest.mark.parametrize(("model", "tolerance"), [(STANDARD, 0.5), (PARAMETERIZED, 1.0)])
def test_a_free_cone_is_region_2_alone(model, tolerance):
    heard, free = model.regions(np.array([6.0])), model.free_regions(np.array([6.0]))
    assert free.reach_m == [6.0 - tolerance]
    np.testing.assert_array_equal(free.axis[:, 0], heard.axis[:, 0])
    np.testing.assert_array_equal(free.edge[:, 0], heard.edge[:, 0])
    # Its far border itself belongs to the next region, which is silent.
    assert (free.axis[:, 1:] == [0.5, 0]).all()
    assert (free.edge[:, 1:] == [0.5, 0]).all()


@pytest.mark.parametrize("model", MODELS)
def test_both_are_sensor_models(model):
    assert isinstance(model, sm.SensorModel)
    assert model.half_angle_rad == math.radians(15)
    assert hash(model) == hash(type(model)(**vars(model)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"beta_rad": 0}, r"beta_rad must be in \(0, pi/3\], got 0"),
        ({"beta_rad": 15}, r"beta_rad must be in \(0, pi/3\], got 15"),
        ({"beta_rad": math.nan}, r"beta_rad must be in \(0, pi/3\], got nan"),
        ({"max_range_m": 0}, "max_range_m must be > 0, got 0"),
        ({"max_range_m": math.inf}, "max_range_m must be > 0, got inf"),
        ({"max_occupied": 0.5}, r"max_occupied must be in \(0\.5, 1\], got 0\.5"),
        ({"max_occupied": 1.01}, r"max_occupied must be in \(0\.5, 1\], got 1\.01"),
        ({"tolerance_m": 0}, "tolerance_m must be > 0, got 0"),
    ],
)
def test_bad_standard_models_are_refused(change, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.StandardModel(**(vars(STANDARD) | change))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"p1": -0.01}, r"p1 must be in \[0, 0\.5\), got -0\.01"),
        ({"p1": 0.5}, r"p1 must be in \[0, 0\.5\), got 0\.5"),
        ({"p1": math.nan}, r"p1 must be in \[0, 0\.5\), got nan"),
        ({"p2": -0.1}, r"p2 must be within \[0, 0\.48\], got -0\.1"),
        # limited by P1 and by P4
        ({"p1": 0.4, "p2": 0.11}, r"p2 must be within \[0, 0\.1\], got 0\.11"),
        ({"p4": 0.6, "p2": 0.11}, r"p2 must be within \[0, 0\.1\], got 0\.11"),
        ({"p2": math.nan}, r"p2 must be within \[0, 0\.48\], got nan"),
        ({"p3_m": 0}, "p3_m must be > 0, got 0"),
        ({"p4": 0.5}, r"p4 must be in \(0\.5, 1\], got 0\.5"),
        ({"p4": 1.1}, r"p4 must be in \(0\.5, 1\], got 1\.1"),
        ({"p5_rad": math.pi / 2}, r"p5_rad must be in \(0, pi/3\], got 1\.57\d*"),
    ],
)
def test_bad_parameterized_models_are_refused(change, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.ParameterizedModel(**(vars(PARAMETERIZED) | change))
