"""Firing schedules and status packets. The room is simple; what matters is when and where."""

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from rooms import closed_room

import sim
from sim import AllAtOnce, ConeSonar, ConstantSpeeds, Eeruf, InTurn, OdometryModel, StatusPackets
from sim.sonar.firing import check_firing, fitted, pings
from sim.sonar.presets import PHYSICAL
from sonarmap import AMIGOBOT, InputError, SonarRing


def times(firing, scan=0):
    return [slot.offset_s for slot in firing.slots(scan, 8)]


def test_all_at_once_is_one_slot():
    (slot,) = AllAtOnce(0.175).slots(3, 8)
    assert (slot.offset_s, slot.sonars) == (0.0, tuple(range(8)))


def test_a_full_ring_in_turn_takes_320_ms():
    assert times(InTurn()) == pytest.approx(np.arange(8) * 0.040)
    assert InTurn().period_s == pytest.approx(0.320)


def test_the_order_may_leave_out_and_repeat():
    firing = InTurn(0.02, order=(3, 0, 3))
    assert [slot.sonars for slot in firing.slots(0, 8)] == [(3,), (0,), (3,)]
    assert firing.period_s == pytest.approx(0.06)


def ring_of(sonars):
    places = np.linspace(0, 0.1, sonars)
    return SonarRing("n", places, places, places, math.radians(15), 0.1, 5.0)


@pytest.mark.parametrize("sonars", [1, 3, 8, 12, 16])
@pytest.mark.parametrize(
    "firing", [InTurn(), InTurn(0.02), Eeruf(0.2), replace(Eeruf(), period_s=0.3), AllAtOnce(0.1)]
)
def test_without_an_order_all_sonars_of_the_ring_fire(firing, sonars):
    ring = ring_of(sonars)
    for sonar in (
        PHYSICAL.replace(ring=ring, firing=firing),
        # Whatever ring it had before.
        PHYSICAL.replace(firing=firing).replace(ring=ring_of(2)).replace(ring=ring),
    ):
        fired = [sonar for ping in pings(sonar.firing, sonars, scans=1) for sonar in ping.sonars]
        assert fired == list(range(sonars))
        last = [slot.offset_s for slot in sonar.firing.slots(0, sonars)][-1]
        assert last < sonar.firing.period_s
        log = sim.simulate(closed_room(1.2), scans=2, seed=0, sonar=sonar, engine="segments")
        assert log.sonar.tolist() == list(range(sonars)) * 2


def test_a_given_order_stays_whatever_the_ring():
    for firing in (InTurn(order=range(8)), Eeruf(order=tuple(range(8)))):
        sonar = PHYSICAL.replace(ring=ring_of(16), firing=firing)
        assert sonar.firing == firing
        assert sonar.firing.order == tuple(range(8))


def test_a_schedule_of_ones_own_needs_no_order():
    class Backwards(AllAtOnce):
        def slots(self, scan, sonars):
            return tuple(reversed(super().slots(scan, sonars)))

    mine = Backwards(0.1)
    assert fitted(mine, 3) is mine


def test_more_sonars_than_the_delays_of_eeruf_allow_are_refused():
    with pytest.raises(InputError, match=r"period_s must be longer than the 15 lags .* got 0.1"):
        PHYSICAL.replace(ring=ring_of(16), firing=Eeruf())


def test_delays_of_eeruf_change_differently_for_each_pair():
    change = np.subtract(times(Eeruf(), scan=1), times(Eeruf(), scan=0))
    shift = np.abs(change[:, None] - change)[~np.eye(8, dtype=bool)]
    assert shift.min() >= 0.005 - 1e-12
    assert times(Eeruf(), scan=2) == times(Eeruf(), scan=0)


@pytest.mark.parametrize(
    ("firing", "offsets_s"),
    [
        (AllAtOnce(0.1), [[0.0], [0.0]]),
        (InTurn(0.02, order=(3, 0)), [[0.0, 0.02], [0.0, 0.02]]),
        (Eeruf(0.1, 0.010, 0.005, order=(2, 1)), [[0.0, 0.010], [0.0, 0.005]]),
    ],
)
def test_pings_are_the_slots_scan_by_scan(firing, offsets_s):
    walked = list(pings(firing, 8, scans=2))
    for scan in (0, 1):
        of_scan = [ping for ping in walked if ping.scan == scan]
        assert [ping.offset_s for ping in of_scan] == offsets_s[scan]
        begin_s = scan * firing.period_s
        assert [ping.time_s for ping in of_scan] == [begin_s + at_s for at_s in offsets_s[scan]]
        slots = firing.slots(scan, 8)
        assert [ping.sonars for ping in of_scan] == [slot.sonars for slot in slots]
    # Without an end they go on alike.
    assert list(islice(pings(firing, 8), len(walked))) == walked


@pytest.mark.parametrize(
    ("firing", "message"),
    [
        (AllAtOnce(0.0333), r"scan_period_s must be a multiple of 0.005 s, got 0.0333"),
        (InTurn(0.0123), "scan_period_s must be a multiple of 0.005 s"),
        (InTurn(0.0075, (0, 1)), r"the time between firings must be a multiple .* got 0.0075"),
        # The lags of odd scans count as well.
        (Eeruf(0.1, 0.010, 0.003), r"the time between firings must be a multiple .* got 0.003"),
        (InTurn(order=(0, 8)), r"order\[1\] must be 0 to 7, got 8"),
    ],
)
def test_firings_between_steps_of_the_physics_are_refused(firing, message):
    check_firing(InTurn(), 8)
    with pytest.raises(InputError, match=message):
        check_firing(firing, 8)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: AllAtOnce(0), r"period_s must be > 0, got 0"),
        (lambda: InTurn(-0.04), r"slot_s must be > 0, got -0.04"),
        (lambda: InTurn(order=()), r"order must name at least one sonar, got none"),
        (lambda: InTurn(order=(0, 1.5)), r"order\[1\] must be a whole number, got 1.5"),
        (lambda: InTurn(order=(True, 1)), r"order\[0\] must be a number, got True"),
        (lambda: InTurn(order="01"), r"order must be the numbers of sonars, got '01'"),
        (lambda: Eeruf(order=3), r"order must be the numbers of sonars, got 3"),
        (lambda: InTurn(order=(0, -1)), r"order\[1\] must be >= 0, got -1"),
        (lambda: InTurn(order=(0, 8)).check(8), r"order\[1\] must be 0 to 7, got 8"),
        (lambda: Eeruf(order=(2, 9)).check(8), r"order\[1\] must be 0 to 7, got 9"),
        (lambda: Eeruf(order=(1, 1)), r"order must name no sonar twice, got \(1, 1\)"),
        (lambda: Eeruf(lag_odd_s=0.01), r"lag_odd_s must differ from lag_even_s, got 0.01"),
        (lambda: Eeruf(period_s=0.07), r"period_s must be longer than the 7 lags .* got 0.07"),
        (lambda: StatusPackets(0), r"period_s must be > 0, got 0"),
        (lambda: StatusPackets(delay_s=-1), r"delay_s must be >= 0, got -1"),
    ],
)
def test_bad_schedules_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


class InTurnCone(ConeSonar):
    """A simple cone that fires in turn: schedules do not depend on the acoustics."""

    @property
    def firing(self):
        return InTurn()

    def array(self, rays, world, rng):
        return _OneByOne(self, rays, world, rng)


class _OneByOne:
    def __init__(self, *parts):
        self.parts, self.heard = parts, []

    def fire(self, time_s, sonars, sensor_xy_m, axis_rad):
        sonar, rays, world, rng = self.parts
        heard = sonar.listen(rays, world, sensor_xy_m, axis_rad, rng)
        self.heard.append([getattr(heard, name)[list(sonars)] for name in vars(heard)])

    def detect(self):
        columns = [np.concatenate(column) for column in zip(*self.heard, strict=True)]
        self.heard = []
        return sim.Echoes(*columns)


def drive(scans=12, **arguments):
    sonar = InTurnCone("turn", AMIGOBOT, scan_period_s=0.32, noise_std_m=0, quantum_m=0)
    arguments = {"driver": ConstantSpeeds(0.1, 0.1), "odometry": OdometryModel.exact()} | arguments
    return sim.simulate(closed_room(1.2), scans=scans, seed=1, sonar=sonar, **arguments)


@pytest.mark.engine
def test_each_reading_has_its_own_time_and_pose():
    log = drive()
    assert log.time_s == pytest.approx(np.arange(96) * 0.040)
    assert log.sonar.tolist() == list(range(8)) * 12
    assert log.scan.tolist() == np.repeat(range(12), 8).tolist()
    # At full speed after 0.1 m/s : 0.3 m/s2 = 0.33 s; then 4 mm a slot.
    assert np.diff(log.truth.x_m)[16:] == pytest.approx(np.full(79, 0.004), rel=0.02)
    assert log.x_m == pytest.approx(log.truth.x_m, abs=1e-3)
    # Sonar 0 looks aside, 3 and 4 ahead: the wall ahead comes nearer as the robot drives.
    ahead = log.sonar == 2
    assert np.diff(log.range_m[ahead])[3:] == pytest.approx(np.full(8, -0.032), abs=2e-3)


@pytest.mark.engine
def test_packets_repeat_what_is_not_new_and_say_so():
    fresh, told = drive(), drive(packets=StatusPackets())
    assert np.unique(np.diff(np.unique(told.time_s))) == pytest.approx(0.1)
    assert np.bincount(told.scan)[-1] == 8
    # A sonar fires every 320 ms and is told every 100 ms.
    late = told.select(told.scan > 3)
    assert late.stale.mean() == pytest.approx(1 - 100 / 320, abs=0.03)
    # The fresh rows of a sonar are the readings of its firings, in their order; the last firings
    # may come too late for a packet.
    for sonar in range(8):
        values = told.range_m[(told.sonar == sonar) & ~told.stale]
        assert values.size >= 11
        assert (values == fresh.range_m[fresh.sonar == sonar][: values.size]).all()
    # What is stale equals the row before of its sonar, with the truth of the same firing.
    for sonar in range(8):
        rows = np.flatnonzero(told.sonar == sonar)
        repeats = np.flatnonzero(told.stale[rows])
        assert (repeats > 0).all()
        for column in (told.range_m, told.truth.x_m, told.truth.cone_range_m):
            assert (column[rows[repeats]] == column[rows[repeats - 1]]).all()
    assert (told.truth.x_m <= told.x_m + 1e-3).all()


@pytest.mark.engine
def test_too_short_a_drive_for_packets_is_refused():
    with pytest.raises(InputError, match="scans must be enough for a packet with a reading"):
        drive(scans=1, packets=StatusPackets(0.1, delay_s=0.4))


@pytest.mark.engine
@pytest.mark.parametrize(
    ("packets", "message"),
    [(StatusPackets(0.0333), r"packets.period_s must be a multiple of 0.005 s, got 0.0333")],
)
def test_times_between_physics_steps_are_refused(packets, message):
    with pytest.raises(InputError, match=message):
        drive(packets=packets)


def test_listening_ends_with_the_slot_or_the_scan():
    assert InTurn(0.04).listening_s == 0.04
    assert Eeruf().listening_s == pytest.approx(0.03)
    assert math.isclose(AllAtOnce(0.1).listening_s, 0.1)
