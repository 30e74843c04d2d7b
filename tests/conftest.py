import numpy as np
import pytest


@pytest.fixture
def rng():
    """The one source of randomness of a test: the same numbers in every run."""
    return np.random.default_rng(20060101)
