import math
import re

import numpy as np
import pytest

from sonarmap.errors import (
    InputError,
    did_you_mean,
    finite,
    first_row,
    flag,
    instance,
    non_negative,
    positive,
    whole,
    within,
)


def unit(name, value):
    return within(name, value, 0, 1)


def least_one(name, value):
    return whole(name, value, least=1)


def at_most_nine(name, value):
    return whole(name, value, most=9)


def a_text(name, value):
    return instance(name, value, str, "quote it")


@pytest.mark.parametrize("value", [True, np.True_, np.array(True)])
def test_what_is_true_is_true_whatever_its_type(value):
    assert flag("quick", value) is True


@pytest.mark.parametrize("value", [3, 3.0, np.int16(3), np.float32(3), np.array(3)])
def test_a_whole_number_is_an_int_whatever_its_type(value):
    number = whole("count", value, least=3)
    assert number == 3
    assert type(number) is int


@pytest.mark.parametrize("value", [np.float32(2), np.int8(2), np.array(2.0)])
def test_numbers_of_numpy_are_numbers(value):
    assert positive("speed", value) == 2.0


@pytest.mark.parametrize(
    ("check", "value"),
    [(finite, -2), (finite, 0), (positive, 1e-300), (non_negative, 0), (unit, 0), (unit, 1)],
)
def test_what_keeps_the_rule_is_returned_as_a_float(check, value):
    checked = check("speed", value)
    assert checked == value
    assert isinstance(checked, float)


@pytest.mark.parametrize(
    ("check", "value", "rule"),
    [
        (finite, math.nan, "speed must be a finite number, got nan"),
        (finite, math.inf, "speed must be a finite number, got inf"),
        (positive, 0, "speed must be > 0, got 0"),
        (positive, -0.1, "speed must be > 0, got -0.1"),
        (positive, math.inf, "speed must be > 0, got inf"),
        (positive, math.nan, "speed must be > 0, got nan"),
        (non_negative, -1e-9, "speed must be >= 0, got -1e-09"),
        (non_negative, math.nan, "speed must be >= 0, got nan"),
        (unit, 1.1, "speed must be within [0, 1], got 1.1"),
        (unit, math.nan, "speed must be within [0, 1], got nan"),
        (finite, "fast", "speed must be a number, got 'fast'"),
        (positive, None, "speed must be a number, got None"),
        # What float() would take for a number.
        (positive, "3", "speed must be a number, got '3'"),
        (positive, b"3", "speed must be a number, got b'3'"),
        (finite, True, "speed must be a number, got True"),
        (finite, np.True_, "speed must be a number, got np.True_"),
        (finite, 1j, "speed must be a number, got 1j"),
        (finite, [1.0], "speed must be a number, got [1.0]"),
        (finite, np.array([1.0]), "speed must be a number, got array([1.])"),
        (whole, 1.5, "speed must be a whole number, got 1.5"),
        (whole, math.nan, "speed must be a whole number, got nan"),
        (whole, "2", "speed must be a number, got '2'"),
        (least_one, 0, "speed must be >= 1, got 0"),
        (at_most_nine, 10, "speed must be <= 9, got 10"),
        (finite, 10**400, "speed must be a number that fits 64 bits, got a larger one"),
        (flag, "False", "speed must be True or False, got 'False'"),
        (flag, 1, "speed must be True or False, got 1"),
        (flag, None, "speed must be True or False, got None"),
        (a_text, 3, "speed must be a str, got 3: quote it"),
    ],
)
def test_what_breaks_the_rule_is_refused_with_name_rule_and_value(check, value, rule):
    with pytest.raises(InputError, match=f"^{re.escape(rule)}$"):
        check("speed", value)


def test_first_row_names_the_first_bad_row():
    values = np.array([1.0, -2.0, -3.0])
    with pytest.raises(InputError, match=r"^range_m\[1\] must be >= 0, got -2\.0$"):
        first_row("range_m", values < 0, values, ">= 0")
    first_row("range_m", values < -9, values, ">= 0")


@pytest.mark.parametrize(
    ("unknown", "hint"),
    [
        ("amigobt", "; did you mean 'amigobot'?"),
        ("xyz", "; known: amigobot, pioneer"),
    ],
)
def test_did_you_mean_names_the_nearest_or_all(unknown, hint):
    assert did_you_mean(unknown, ["pioneer", "amigobot"]) == hint


def test_an_input_error_is_a_value_error():
    assert issubclass(InputError, ValueError)
