"""Means with their interval, and rank correlations."""

import math

import numpy as np
import pytest

from sonarbed.reporting.statistics import Estimate, mean_of, rank_correlation


def test_interval_is_students():
    # 1 to 5: standard deviation sqrt(2.5), t(0.975, 4) = 2.776445 from a table.
    half = 2.776445 * math.sqrt(2.5 / 5)
    estimate = mean_of([1, 2, 3, 4, 5])
    assert estimate.value == 3
    assert estimate.low == pytest.approx(3 - half, abs=1e-5)
    assert estimate.high == pytest.approx(3 + half, abs=1e-5)


def test_equal_values_have_no_width():
    assert mean_of([2.0] * 4) == Estimate(2, 2, 2)


@pytest.mark.parametrize("unknown", [math.nan, math.inf])
def test_what_is_not_a_number_does_not_count(unknown):
    estimate, known = mean_of([1, unknown, 3, 2]), mean_of([1, 3, 2])
    assert (estimate.value, estimate.low, estimate.high) == (known.value, known.low, known.high)
    assert (estimate.left_out, known.left_out) == (1, 0)
    assert estimate.text(1) == f"{known.text(1)}, 1 undefined left out"


def test_one_value_has_no_interval_and_none_has_no_mean():
    one, none = mean_of([7]), mean_of([math.nan])
    assert one.value == 7
    assert math.isnan(one.low)
    assert math.isnan(one.high)
    assert math.isnan(none.value)
    assert one.text(1, "m") == "7.0 m"


@pytest.mark.parametrize(
    ("low", "high", "sign"),
    [(0.1, 0.3, 1), (-0.3, -0.1, -1), (-0.1, 0.1, 0), (0.0, 0.2, 0), (math.nan, math.nan, 0)],
)
def test_only_an_interval_beside_zero_decides(low, high, sign):
    assert Estimate((low + high) / 2, low, high).sign == sign


def test_text_tells_value_interval_and_unit():
    assert Estimate(0.5, 0.25, 0.75).text(2, "cm", factor=100) == "50.00 (25.00 to 75.00) cm"


@pytest.mark.parametrize(
    ("y", "expected"),
    [
        ([1, 8, 27, 64], 1),  # rising, however bent
        ([4, 3, 2, 1], -1),
        ([2, 1, 4, 3], 0.6),  # 1 - 6 (1 + 1 + 1 + 1) / (4 (16 - 1))
        ([5, 5, 5, 5], 0),  # flat: ranks nothing
        ([1, math.nan, 2, 3], 1),  # what is not known is left out
        ([1, math.nan, math.nan, 3], 0),  # two are too few
    ],
)
def test_rank_correlation(y, expected):
    assert rank_correlation([1, 2, 3, 4], y) == pytest.approx(expected)
    assert rank_correlation(y, np.arange(4)) == pytest.approx(expected)
