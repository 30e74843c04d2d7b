"""What became of the readings: all are counted, each once."""

from dataclasses import replace

import numpy as np
import pytest
from support import make_log, random_log

import sonarmap as sm
from sonarmap.account import account_by, account_of, contacts_of


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


def test_accounts_add_up(rng):
    one, other = (account_of(random_log(rng, n)) for n in (40, 30))
    both = one + other
    assert both.readings == 70
    assert both.used == one.used + other.used
    assert both.used + sum(both.unused.values()) == 70


def test_a_method_that_does_not_tell_uses_all_that_is_usable(rng):
    log = random_log(rng)
    assert account_by(log, object()) == account_of(log)
    method = sm.method("bayes-parameterized")
    assert account_by(log, method) == account_of(log, method.uses(log))


def test_contacts_are_counted_by_scans_and_by_packets_that_are_new(rng):
    log = random_log(rng, 12, truth=True).replace(scan=np.repeat(range(4), 3))
    touched, stale = np.zeros((2, 12), bool)
    touched[[0, 1, 4, 9]] = True  # of scan 0 twice, of 1 and of 3
    stale[9] = True
    log = log.replace(stale=stale, truth=replace(log.truth, collision=touched))
    contacts = contacts_of(log)
    assert (contacts.touched, contacts.of, contacts.unit) == (2, 4, "scans")
    assert str(contacts).startswith("In 2 scans the robot touched something (50.0% of the drive)")
    packets = contacts_of(log.replace(provenance={"packets": {"period_s": 0.1}}))
    assert packets.to_dict() == {"collision_packets": 2, "collision_share": 0.5}
    assert (packets + packets).of == 8
    assert contacts_of(log.replace(truth=None)) is None
    free = contacts_of(log.replace(truth=replace(log.truth, collision=np.zeros(12, bool))))
    assert str(free) == ""
