"""What a key of a spec stands for."""

import numpy as np
import pytest

from sim.datasets.values import Drawn, Each, Fixed, Kind, parse_value
from sonarmap.errors import InputError

NUMBER, WHOLE, TEXT, FLAG = (Kind(name) for name in ("number", "whole", "text", "flag"))


@pytest.mark.parametrize(
    ("given", "kind", "value"),
    [
        (3, NUMBER, Fixed(3)),
        (2.0, WHOLE, Fixed(2)),
        ("office", TEXT, Fixed("office")),
        (True, FLAG, Fixed(True)),
        ([1, 2], WHOLE, Each((1, 2))),
        ({"uniform": [0, 1]}, NUMBER, Drawn("uniform", (0.0, 1.0), NUMBER)),
        (
            {"normal": [48, 3], "within": [40, 56]},
            NUMBER,
            Drawn("normal", (48.0, 3.0), NUMBER, within=(40.0, 56.0)),
        ),
        (
            {"choice": ["a", "b"], "weights": [3, 1]},
            TEXT,
            Drawn("choice", ("a", "b"), TEXT, weights=(3.0, 1.0)),
        ),
    ],
)
def test_what_a_key_stands_for(given, kind, value):
    assert parse_value(given, kind) == value


@pytest.mark.parametrize(
    ("given", "kind", "message"),
    [
        ("x", NUMBER, "must be a finite number, got 'x'"),
        (True, NUMBER, "must be a finite number, got True"),
        (float("nan"), NUMBER, "must be a finite number, got nan"),
        (2.5, WHOLE, "must be a whole number, got 2.5"),
        (3, TEXT, "must be a text, got 3"),
        ("", TEXT, "must be a text, got ''"),
        (1, FLAG, "must be true or false, got 1"),
        ([], NUMBER, "must be a list of values"),
        ([1, 1], NUMBER, "must name no value twice"),
        ({"unifrom": [0, 1]}, NUMBER, "unknown distribution 'unifrom'; did you mean 'uniform'?"),
        ({}, NUMBER, "must be one distribution of"),
        ({"uniform": [0, 1], "normal": [0, 1]}, NUMBER, "must be one distribution of"),
        ({"uniform": [1, 0]}, NUMBER, "uniform must be .low, high. with low < high"),
        ({"uniform": [0, 1, 2]}, NUMBER, "uniform must be a list of two numbers"),
        ({"uniform": ["a", 1]}, NUMBER, "uniform must be a list of two numbers"),
        ({"log_uniform": [0, 1]}, NUMBER, "log_uniform must be .low > 0, high."),
        ({"normal": [0, 0]}, NUMBER, "standard deviation > 0"),
        ({"uniform": [0, 1], "within": [0, 1]}, NUMBER, "within is for a normal"),
        ({"uniform": [0, 1], "weights": [1]}, NUMBER, "weights are for a choice"),
        ({"choice": [1, 2], "weights": [1]}, NUMBER, "weights must be a number >= 0 for each"),
        ({"uniform": [0, 1]}, TEXT, "uniform is for numbers only: use choice"),
    ],
)
def test_bad_values_are_refused(given, kind, message):
    with pytest.raises(InputError, match=message):
        parse_value(given, kind)


def draws(given, kind, rng, n=4000):
    value = parse_value(given, kind)
    return np.array([value.draw(rng) for _ in range(n)])


def test_draws_follow_their_distribution(rng):
    uniform = draws({"uniform": [2, 6]}, NUMBER, rng)
    assert 2 <= uniform.min() < 2.1 < 5.9 < uniform.max() <= 6
    assert abs(uniform.mean() - 4) < 0.1
    whole = draws({"uniform": [2, 4]}, WHOLE, rng)
    assert whole.dtype.kind == "i"
    assert np.abs(np.bincount(whole, minlength=5)[2:] / 4000 - 1 / 3).max() < 0.03
    log = draws({"log_uniform": [0.001, 1]}, NUMBER, rng)
    assert abs(np.median(np.log10(log)) + 1.5) < 0.1
    normal = draws({"normal": [48, 3], "within": [44, 60]}, NUMBER, rng)
    assert normal.min() >= 44
    assert abs(np.median(normal) - 48.3) < 0.4
    far = draws({"normal": [0, 1], "within": [50, 60]}, NUMBER, rng, 3)
    assert (far == 50).all()
    choice = draws({"choice": ["a", "b"], "weights": [3, 1]}, TEXT, rng)
    assert abs((choice == "a").mean() - 0.75) < 0.03
