"""Parameters of parts: from text, and what may be searched."""

import dataclasses
import math
from typing import Literal

import pytest

import sonarmap as sm
from sonarmap.parameters import Choice, Real, Whole, from_text


@dataclasses.dataclass(frozen=True)
class Part:
    size_m: float = 1.0
    angle_rad: float | None = None
    passes: int = 1
    word: Literal["a", "b"] = "a"
    name: str = "x"
    loud: bool = False
    either: int | float = 0
    values: tuple[float, ...] = ()


def parsed(**texts):
    return from_text("part 'p'", Part, texts)


def test_text_becomes_what_the_field_holds():
    assert parsed(
        size_m="2", angle_deg="90", passes="3", word="b", name="7", loud="yes", either="0.5"
    ) == {
        "size_m": 2.0,
        "angle_rad": math.pi / 2,
        "passes": 3,
        "word": "b",
        "name": "7",
        "loud": True,
        "either": 0.5,
    }
    assert parsed(angle_rad="none", loud="off") == {"angle_rad": None, "loud": False}


def test_a_class_of_unknown_types_gets_numbers_where_they_are_numbers():
    assert from_text("part", dict, {"a": "1", "b": "0.5", "c": "x"}) == {"a": 1, "b": 0.5, "c": "x"}


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ({"size": "1"}, "part 'p' has no parameter 'size'; did you mean 'size_m'\\?"),
        ({"angle_dag": "1"}, "part 'p' has no parameter 'angle_dag'; did you mean 'angle_deg'\\?"),
        ({"angle_deg": "1", "angle_rad": "1"}, "part 'p': 'angle_rad' is given twice"),
        ({"size_m": "wide"}, "part 'p': size_m must be a number, got 'wide'"),
        ({"size_m": "none"}, "part 'p': size_m must be a number, got 'none'"),
        ({"passes": "1.5"}, "part 'p': passes must be a whole number, got '1.5'"),
        ({"word": "c"}, "part 'p': word 'c' is unknown; known: a, b"),
        ({"loud": "maybe"}, "part 'p': loud must be true or false, got 'maybe'"),
        ({"values": "1"}, "part 'p': values cannot be given as text"),
    ],
)
def test_bad_text_is_refused(texts, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        parsed(**texts)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Real(1, 1), "low must be < high, got 1 and 1"),
        (lambda: Real(0, 1, log=True), "low must be > 0 for a logarithmic range, got 0"),
        (lambda: Real(math.nan, 1), "low must be a finite number, got nan"),
        (lambda: Whole(3, 2), "low must be < high, got 3 and 2"),
        (lambda: Choice(("a",)), r"values must be at least two, got \('a',\)"),
    ],
)
def test_bad_ranges_are_refused(make, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        make()
