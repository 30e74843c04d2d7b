"""The gamma-variance test: by hand, along drawn walls, and what it keeps quiet about."""

import math

import numpy as np
import pytest
from scipy.stats import chi2
from support import make_log, random_log

import sonarmap as sm

NAME = "gamma-variance"
SIDE = sm.SonarRing("side", [0], [0], [math.pi / 2], math.radians(15), 0.1, 5.0)


def past_a_wall(rng, n=30, *, angle_rad=0.1, sigma_m=0.005):
    """A straight drive to the left of a wall at an angle; 6 cm a reading."""
    x_m = 0.06 * np.arange(n)
    range_m = 1.0 + math.sin(angle_rad) * x_m + rng.normal(0, sigma_m, n)
    return make_log(range_m, ring=SIDE, x_m=x_m)


def test_the_test_is_the_chi_squared_test_of_the_slopes(rng):
    f = sm.filter(NAME, alpha=0.3)
    s, r = np.cumsum(rng.uniform(0.05, 0.1, 8)), rng.normal(1, 0.02, 8)
    gamma = [(r[j + 1] - r[j]) / (s[j + 1] - s[j]) for j in range(7)]
    mean = sum(gamma) / 7
    sample = sum((each - mean) ** 2 for each in gamma) / 6
    explained = [
        (2 * 0.015**2 + mean**2 * 0.05**2 * (s[j + 1] - s[j])) / (s[j + 1] - s[j]) ** 2
        for j in range(7)
    ]
    limit = chi2.ppf(0.7, 6)
    assert f._excess(r, s) == pytest.approx(6 * sample / (sum(explained) / 7) / limit)


def test_a_wall_is_recognised_and_the_wrong_readings_along_it(rng):
    log = past_a_wall(rng)
    range_m = log.range_m.copy()
    range_m[8], range_m[20] = 2.5, math.inf
    made = sm.filter(NAME).apply(log.replace(range_m=range_m))
    assert np.flatnonzero(made.rejected).tolist() == [8, 20]
    assert made.likely_cause[[8, 20]].tolist() == [sm.Cause.BOUNCE, sm.Cause.DROPOUT]
    assert (np.delete(made.likely_cause, [8, 20]) == -1).all()
    np.testing.assert_allclose(made.predicted_range_m, 1.0 + math.sin(0.1) * log.x_m, atol=0.02)
    assert (made.doubt[[8, 20]] > 0.999).all()
    assert (np.delete(made.doubt, [8, 20]) < 0.1).all()
    assert not made.changed.any()


def test_mending_puts_readings_on_the_line(rng):
    log = past_a_wall(rng)
    range_m = log.range_m.copy()
    range_m[8] = 2.5
    made = sm.filter(NAME, action="mend").apply(log.replace(range_m=range_m))
    assert np.flatnonzero(made.changed).tolist() == [8]
    assert made.log.range_m[8] == pytest.approx(1.0 + math.sin(0.1) * 0.48, abs=0.02)
    assert not made.rejected.any()


@pytest.mark.parametrize(
    "change",
    [
        lambda log: log.replace(heading_rad=0.2 * np.arange(30)),  # turning all the time
        lambda log: log.replace(x_m=np.zeros(30)),  # standing
        lambda log: log.replace(range_m=1 + np.arange(30) * 37 % 11 / 10),  # clutter
        lambda log: log.replace(range_m=np.full(30, math.inf)),
        lambda log: log.replace(range_m=np.full(30, -math.inf)),
        lambda log: log.select(slice(0, 4)),  # fewer than four slopes
        lambda log: log.select([]),
    ],
)
def test_it_says_nothing_where_no_wall_is(change, rng):
    made = sm.filter(NAME).apply(change(past_a_wall(rng)))
    assert np.isnan(made.doubt).all()
    assert np.isnan(made.predicted_range_m).all()
    assert not made.rejected.any()


def test_a_reading_between_the_steps_is_judged_too(rng):
    x_m = 0.02 * np.arange(90)
    range_m = 1 + 0.1 * x_m
    range_m[40] = 3.0
    made = sm.filter(NAME).apply(make_log(range_m, ring=SIDE, x_m=x_m))
    assert np.flatnonzero(made.rejected).tolist() == [40]


def test_it_needs_no_walls_direction(rng):
    log = past_a_wall(rng)
    range_m = log.range_m.copy()
    range_m[12] = 2.0
    log = log.replace(range_m=range_m)
    expected = sm.filter(NAME).apply(log)
    turned = log.replace(x_m=-log.y_m, y_m=log.x_m, heading_rad=log.heading_rad + math.pi / 2)
    mirrored = log.replace(y_m=-log.y_m, heading_rad=-log.heading_rad)
    reversing = log.replace(x_m=-log.x_m)
    for other in (turned, mirrored, reversing):
        made = sm.filter(NAME).apply(other)
        np.testing.assert_allclose(made.doubt, expected.doubt, rtol=1e-6)
        np.testing.assert_array_equal(made.rejected, expected.rejected)


def test_doubts_lie_where_probabilities_do(rng):
    made = sm.filter(NAME, alpha=0.001, sigma_m=0.05).apply(random_log(rng, 500, spread_m=0.2))
    known = made.doubt[~np.isnan(made.doubt)]
    assert ((known >= 0) & (known <= 1)).all()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"buffer": 4}, "buffer must be >= 5, got 4"),
        ({"least_slopes": 1}, "least_slopes must be >= 2, got 1"),
        ({"step_m": 0}, "step_m must be > 0, got 0"),
        ({"turn_rad": 0}, "turn_rad must be > 0, got 0"),
        ({"alpha": 1}, r"alpha must be in \(0, 1\), got 1"),
        ({"sigma_m": 0}, "sigma_m must be > 0, got 0"),
        ({"way_factor": -1}, "way_factor must be >= 0, got -1"),
        ({"gate": 0}, "gate must be > 0, got 0"),
        ({"wrong_share": 0}, r"wrong_share must be in \(0, 1\), got 0"),
        ({"action": "keep"}, "action 'keep' is unknown.*"),
    ],
)
def test_bad_parameters_are_refused(parameters, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.filter(NAME, **parameters)
