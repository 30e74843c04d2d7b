import numpy as np
import pytest
from drives import by_odometry, log_of, way


@pytest.fixture(scope="session")
def drive():
    """True poses of two laps, and its log by an odometer that slips, with its seed's numbers."""
    rng = np.random.default_rng(1)
    true = way(2)
    told = by_odometry(true, rng, scale=1.003, turn=0.996, slip=0.006)
    return true, log_of(true, told, rng)
