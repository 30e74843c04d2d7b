"""What environments say, compared to the last bit and type."""

import numpy as np


def assert_same(one, other, place=""):
    """Assert that two infos, observations or the like are the same to the last bit and type."""
    assert type(one) is type(other), place
    if isinstance(one, dict):
        assert one.keys() == other.keys(), place
        for key, values in one.items():
            assert_same(values, other[key], f"{place}/{key}")
    elif isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape), place
        if one.dtype == object:
            for i, part in enumerate(one):
                assert_same(part, other[i], f"{place}[{i}]")
        else:
            assert np.array_equal(one, other), place
    elif isinstance(one, tuple | list):
        assert len(one) == len(other), place
        for i, part in enumerate(one):
            assert_same(part, other[i], f"{place}[{i}]")
    else:
        assert one == other, place
