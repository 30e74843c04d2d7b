"""What became of the readings: all are counted, each once."""

import numpy as np
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarmap.account import account_of


def test_each_reading_is_counted_by_its_first_reason():
    log = make_log(
        [1.0, 2.0, 3.0, -np.inf, np.inf, -np.inf],
        stale=[0, 1, 0, 0, 0, 1],
        rejected=[0, 1, 1, 0, 0, 0],
    )
    account = account_of(log)
    assert str(account) == ("2 of 6 readings used; not used: 2 stale, 1 rejected, 1 too close")
    assert account.to_dict() == {
        "in_log": 6,
        "used": 2,
        "unused": {"stale": 2, "rejected": 1, "too_close": 1},
    }
    assert str(account_of(make_log([1.0, 2.0]))) == "2 of 2 readings used"


@pytest.mark.parametrize("no_echo", ["ignore", "clear"])
def test_a_bayes_method_tells_what_it_uses(no_echo, rng):
    log = random_log(rng, 200)
    method = sm.method("bayes-standard", no_echo=no_echo, max_range_m=1.2)
    account = account_of(log, method.uses(log))
    assert account.used + sum(account.unused.values()) == len(log)
    assert ("no echo" in account.unused) == ("too long" in account.unused) == (no_echo == "ignore")
    # What is not used may as well not be there.
    grid = sm.GridSpec(0.1, (-2, -2), (40, 40))
    used = method.map(log.select(method.uses(log)), grid)
    assert used.log_odds.tobytes() == method.map(log, grid).log_odds.tobytes()
