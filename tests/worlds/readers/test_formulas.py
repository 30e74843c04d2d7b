import pytest

from sonarmap import InputError
from worlds.readers.toml.formulas import evaluate

PARAMETERS = {"gap_m": 0.5, "distance_m": 2.0}


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("=1", 1.0),
        ("= gap_m", 0.5),
        ("=-gap_m / 2", -0.25),
        ("=1 - 2 - 3", -4.0),
        ("=2 + gap_m * 4", 4.0),
        ("=(2 + gap_m) * 4", 10.0),
        ("=--distance_m", 2.0),
        ("=1e-3 / distance_m", 0.0005),
    ],
)
def test_arithmetic(formula, value):
    assert evaluate(formula, PARAMETERS) == value


@pytest.mark.parametrize(
    "formula",
    [
        "=",
        "= 1 +",
        "= 2 ** 3",
        "= 7 // 2",
        "= 7 % 2",
        "= +1",
        "= abs(gap_m)",
        "= gap_m.real",
        "= [1]",
        "= 'a'",
        "= True",
        "= 1j",
        "= 1 if gap_m else 2",
        "= (x := 1)",
        "= __import__('os')",
        "= 1; 2",
        "= \0",
        "=" + "(" * 5000,
        "=" + "-" * 50_000 + "1",
    ],
)
def test_only_arithmetic_is_read(formula):
    with pytest.raises(InputError, match=r"bad formula .*: only numbers, parameters and \+ - \* /"):
        evaluate(formula, PARAMETERS)


@pytest.mark.parametrize("formula", ["= 1 / 0", "= 1e999", "= 1e200 * 1e200", "= 1e999 - 1e999"])
def test_a_value_is_finite(formula):
    with pytest.raises(InputError, match="it has no finite value"):
        evaluate(formula, PARAMETERS)


def test_a_number_too_great_for_a_float_is_refused():
    with pytest.raises(InputError, match="it has no finite value"):
        evaluate("= 1" + "0" * 400, PARAMETERS)


def test_unknown_parameters_are_named_with_the_nearest_known():
    with pytest.raises(InputError, match=r"unknown parameter 'gap'; did you mean 'gap_m'\?"):
        evaluate("= gap / 2", PARAMETERS)
    with pytest.raises(InputError, match="unknown parameter 'gap'; the room has none"):
        evaluate("= gap / 2", {})
