"""Columns are taken for what they are, and what loses its meaning is refused by name and row."""

import datetime
from fractions import Fraction

import numpy as np
import pytest

import sonarmap as sm
from sonarmap.columns import column

FLAGS, WHOLE, NUMBERS, TEXTS = np.bool_, np.int16, np.float64, np.str_


@pytest.mark.parametrize(
    ("values", "dtype", "expected"),
    [
        ([True, False], FLAGS, [True, False]),
        ([1, 0], FLAGS, [True, False]),
        (np.array([1.0, 0.0]), FLAGS, [True, False]),
        (np.array([np.True_, 0], dtype=object), FLAGS, [True, False]),
        ([1, 2], WHOLE, [1, 2]),
        (np.array([1.0, 2.0]), WHOLE, [1, 2]),
        (np.array([1, 2], np.uint64), WHOLE, [1, 2]),
        ([1, 2.5], NUMBERS, [1.0, 2.5]),
        (np.array([1, Fraction(1, 2)], dtype=object), NUMBERS, [1.0, 0.5]),
        (np.array([1, 2], np.float32), NUMBERS, [1.0, 2.0]),
        (["a", "Tür"], TEXTS, ["a", "Tür"]),
        (np.array(["a", "b"], dtype=object), TEXTS, ["a", "b"]),
        (np.ma.masked_array([1.0, 2.0], [False, False]), NUMBERS, [1.0, 2.0]),
    ],
)
def test_what_keeps_its_meaning_is_taken(values, dtype, expected):
    taken = column("x", values, dtype, 2)
    assert taken.tolist() == expected
    assert taken.dtype.kind == np.dtype(dtype).kind
    assert not taken.flags.writeable


@pytest.mark.parametrize("dtype", [FLAGS, WHOLE, NUMBERS, TEXTS])
def test_nothing_at_all_is_a_column_of_anything(dtype):
    assert column("x", [], dtype, 0).shape == (0,)


def test_a_column_is_a_copy():
    values = np.array([1.0, 2.0])
    taken = column("x", values, NUMBERS, 2)
    values[0] = 9
    assert taken.tolist() == [1.0, 2.0]


DAY = datetime.date(2026, 1, 1)


@pytest.mark.parametrize(
    ("values", "dtype", "message"),
    [
        # true and false
        (["False", "True"], FLAGS, "x must be a column of bool"),
        ([b"0", b"1"], FLAGS, "x must be a column of bool"),
        ([0, 2], FLAGS, r"x\[1\] must be true or false, got 2"),
        ([0, 0.5], FLAGS, r"x\[1\] must be true or false, got 0.5"),
        ([np.nan, 1], FLAGS, r"x\[0\] must be true or false, got nan"),
        ([None, True], FLAGS, r"x\[0\] must be a number, got None"),
        # whole numbers
        ([True, False], WHOLE, "x must be a column of int16"),
        (["1", "2"], WHOLE, "x must be a column of int16"),
        ([1, 2.5], WHOLE, r"x\[1\] must be a whole number that fits int16, got 2.5"),
        (np.array([1, 2**40]), WHOLE, r"x\[1\] must be a whole number .*, got 1099511627776"),
        (np.array([2**63, 0], np.uint64), np.int64, r"x\[0\] must be a whole number .*"),
        # numbers
        ([True, False], NUMBERS, "x must be a column of float64"),
        (["1.5", "2"], NUMBERS, "x must be a column of float64"),
        ([1 + 2j, 0], NUMBERS, "x must be a column of float64"),
        (np.array(["2026-01-01"] * 2, "datetime64[s]"), NUMBERS, "x must be a column of float64"),
        (np.array([1, 2], "timedelta64[s]"), NUMBERS, "x must be a column of float64"),
        (np.array([1, DAY], dtype=object), NUMBERS, "x must be a column of float64"),
        (np.array([1, "2"], dtype=object), NUMBERS, r"x\[1\] must be a number, got 2"),
        (np.array([1, None], dtype=object), NUMBERS, r"x\[1\] must be a number, got None"),
        (np.ma.masked_array([1.0, 2.0], [False, True]), NUMBERS, r"x\[1\] must be known, .*"),
        # texts
        ([1, 2], TEXTS, "x must be a column of str"),
        ([b"a", b"b"], TEXTS, "x must be a column of str"),
        (np.array(["a", 1], dtype=object), TEXTS, r"x\[1\] must be a text, got 1"),
        # shapes
        ([1.0], NUMBERS, r"x must have shape \(2,\), got \(1,\)"),
        (1.0, NUMBERS, r"x must have shape \(2,\), got \(\)"),
        ([[1], [1, 2]], NUMBERS, "x must be a column of float64"),
    ],
)
def test_what_would_lose_its_meaning_is_refused(values, dtype, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        column("x", values, dtype, 2)
