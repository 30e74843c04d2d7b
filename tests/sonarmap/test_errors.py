import math
import re

import numpy as np
import pytest

from sonarmap.errors import (
    InputError,
    did_you_mean,
    finite,
    first_row,
    non_negative,
    positive,
    within,
)


def unit(name, value):
    return within(name, value, 0, 1)


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
