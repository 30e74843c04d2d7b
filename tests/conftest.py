import signal

import numpy as np
import pytest

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # As in a job that a script began in the background: the tests of Ctrl-C could not press it.
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng():
    """The one source of randomness of a test: the same numbers in every run."""
    return np.random.default_rng(20060101)
