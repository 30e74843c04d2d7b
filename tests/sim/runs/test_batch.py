"""A batch of compiled drives is its drives one by one, to the last bit."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
import pytest

import sim
import sonarmap as sm
import worlds
from sim import InTurn
from sim.robot import drivers
from sim.runs import simulation
from sim.runs.arguments import DriveArguments
from sim.runs.batch.drives import BatchDrive, simulate_batch
from sim.runs.compiled import drive
from sim.runs.compiled.drive import PIECE_SCANS, is_compiled
from sim.runs.plain import plain_log
from sim.sonar import presets
from sim.sonar.carried import with_ring
from sim.sonar.firing import Slot
from sonarmap import InputError

EXACT = {name: presets.preset(name) for name in ("thesis", "aria")}
WIDE = EXACT["aria"].replace(max_bounces=1, threshold=0.5, noise_std_m=0.01)
PHYSICAL = presets.preset("physical")


def single(drive):
    """Return the log of a drive taken step by step."""
    world = drive.world
    if drive.start is not None:
        world = dataclasses.replace(world, start=drive.start)
    return plain_log(
        DriveArguments.of(
            world, scans=drive.scans, seed=drive.seed, driver=drive.driver, sonar=drive.sonar,
            odometry=drive.odometry, engine="segments",
        )
    )  # fmt: skip


def assert_same(one, other):
    for name in one.DTYPES:
        a, b = getattr(one, name), getattr(other, name)
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name
    for name in one.truth.DTYPES:
        a, b = getattr(one.truth, name), getattr(other.truth, name)
        assert np.array_equal(a, b, equal_nan=a.dtype.kind == "f"), name
    assert dict(one.provenance) == dict(other.provenance)
    assert one.ring == other.ring


@dataclass
class InPairs:
    """A person's own schedule, without a hash: other pairs in each scan, and one sonar thrice."""

    period_s: float = 0.3
    listening_s: float = 0.05

    def slots(self, scan, sonars):
        pairs = [((scan + i) % sonars, (scan + i + 4) % sonars) for i in range(2 + scan % 2)]
        pairs.insert(1, (0,))
        return tuple(Slot(0.05 * i, tuple(dict.fromkeys(pair))) for i, pair in enumerate(pairs))

    def check(self, sonars):
        pass


def own_ring(count=3):
    """Return a ring with other places, cones and ranges."""
    heading = np.linspace(-1.2, 1.2, count)
    return sm.SonarRing(
        f"own {count}", 0.1 * np.cos(heading), 0.1 * np.sin(heading), heading,
        math.radians(12), 0.2, 2.5,
    )  # fmt: skip


def physical(**changes):
    """Return a physical sonar; a ring of another size fires in its own order."""
    return with_ring(PHYSICAL.replace(**changes), changes.get("ring"))


CONE_DRIVES = {
    "thesis": ("thesis-exp1", "thesis", EXACT["thesis"]),
    "collides": ("clutter", sim.ConstantSpeeds(0.2, 0.25), EXACT["aria"]),
    "wander": ("clutter", "wander", EXACT["aria"]),
    "wander collides": ("round-room", sim.RandomWander(0.5, 0.2, 3.0), EXACT["thesis"]),
    "follow": ("office", "follow-left", EXACT["aria"]),
    "follow right": ("l-shape", sim.WallFollower(side="right"), WIDE),
    "route": ("office", "route", EXACT["aria"]),
    "route far": ("corridor", "route", EXACT["thesis"]),
}
PHYSICAL_DRIVES = {
    "in turn": ("office", "route", PHYSICAL),
    "images asked for": ("l-shape", "wander", physical(search="images", max_bounces=2)),
    "some left out, some twice": ("clutter", "wander", physical(firing=InTurn(0.03, (3, 0, 3, 7)))),
    "in turn, quickly": ("thesis-exp1", "thesis", physical(firing=InTurn(0.01), max_bounces=0)),
    "at once": ("clutter", sim.ConstantSpeeds(0.5, 0.45), physical(firing=sim.AllAtOnce(0.1))),
    "at once, long": ("corridor", "route", physical(firing=sim.AllAtOnce(0.1), max_bounces=3)),
    "eeruf": ("round-room", sim.RandomWander(0.5, 0.2, 3.0), physical(firing=sim.Eeruf())),
    "a sound outlives scans": (
        "thesis-exp2", "follow-left", physical(firing=sim.Eeruf(), sound_life_s=0.25)
    ),
    "own schedule": ("clutter", "wander", physical(firing=InPairs())),
    "own ring": ("office", "follow-left", with_ring(PHYSICAL, own_ring())),
    "one sonar": ("l-shape", sim.WallFollower(side="right"), with_ring(PHYSICAL, own_ring(1))),
    "another ring, at once": (
        "office", "wander", with_ring(physical(firing=sim.AllAtOnce(0.2)), own_ring(5))
    ),
    "cold and blunt": (
        "thesis-exp1", "wander",
        physical(
            air=sim.Air(5.0), spread=sim.TransducerSpread(3.0, 0.05, seed=4),
            receiver=sim.Receiver(noise_std_m=0.01, dynamic_range_db=60),
        ),
    ),
}  # fmt: skip
DRIVES = CONE_DRIVES | PHYSICAL_DRIVES


def drives(names, scans):
    for seed, name in enumerate(names):
        room, driver, sonar = DRIVES[name]
        odometry = sim.OdometryModel(slip_std_m=0.003) if seed % 2 else None
        yield BatchDrive(worlds.load(room), scans, seed, driver, sonar, odometry)


# More scans than run in one call.
@pytest.mark.parametrize(
    ("names", "scans"), [(CONE_DRIVES, PIECE_SCANS + 30), (PHYSICAL_DRIVES, 60)]
)
def test_every_log_is_that_of_the_single_drive(names, scans):
    wanted = list(drives(names, scans))
    seen = set()
    for index, log in simulate_batch(wanted, workers=2):
        assert_same(log, single(wanted[index]))
        seen.add(index)
    assert seen == set(range(len(wanted)))


def test_sounds_go_on_from_one_call_to_the_next(monkeypatch):
    # Or a drive of many scans would differ where one call ends.
    wanted = list(drives(["in turn", "a sound outlives scans", "own schedule", "route"], 20))
    monkeypatch.setattr(drive, "PIECE_SCANS", 3)
    for index, log in simulate_batch(wanted, workers=1):
        assert_same(log, single(wanted[index]))


def test_the_physical_drives_meet_what_they_are_for():
    # Or the drives above would not have tried it.
    wanted = zip(PHYSICAL_DRIVES, drives(PHYSICAL_DRIVES, 60), strict=True)
    logs = {name: single(each) for name, each in wanted}
    causes = {name: set(log.truth.cause.tolist()) for name, log in logs.items()}
    assert set().union(*causes.values()) == {cause.value for cause in sm.Cause}
    assert sm.Cause.CROSSTALK in causes["a sound outlives scans"]
    assert logs["at once"].truth.collision.any()
    assert np.diff(logs["in turn"].truth.x_m[:80].reshape(10, 8)).any(axis=1).sum() > 5
    assert len(set(np.bincount(logs["own schedule"].scan).tolist())) > 1


@pytest.mark.parametrize("name", ["follow", "in turn"])
def test_simulate_drives_compiled_where_it_can_and_counts_the_scans(monkeypatch, name):
    (wanted,) = drives([name], 12)
    arguments = {"scans": 12, "seed": 0, "driver": wanted.driver, "sonar": wanted.sonar}
    monkeypatch.setattr(drive, "PIECE_SCANS", 5)
    monkeypatch.setattr(simulation, "plain_log", None)
    seen = []
    log = sim.simulate(wanted.world, engine="segments", on_scan=seen.append, **arguments)
    assert seen == list(range(12))
    assert_same(log, single(wanted))


def test_what_ends_a_drive_ends_it_soon(monkeypatch):
    seen = []

    def stop(scan):
        seen.append(scan)
        raise KeyboardInterrupt

    arguments = {"sonar": "aria", "engine": "segments", "on_scan": stop}
    with pytest.raises(KeyboardInterrupt):
        sim.simulate(worlds.load("office"), scans=10_000, seed=0, **arguments)
    assert seen == [0]


def test_a_batch_that_is_closed_ends_its_drives_soon(monkeypatch):
    calls, run = [], drive.cones.run
    monkeypatch.setattr(drive, "PIECE_SCANS", 1)
    monkeypatch.setattr(drive.cones, "run", lambda *given: calls.append(1) or run(*given))
    room, scans = worlds.load("office"), 20_000
    batch = simulate_batch([BatchDrive(room, 1, 0), BatchDrive(room, scans, 1)], workers=2)
    assert next(batch)[0] == 0
    batch.close()
    assert len(calls) < scans


def test_one_worker_gives_the_same_in_order():
    wanted = list(drives(CONE_DRIVES, 40)) + list(drives(["in turn", "own schedule"], 10))
    told = list(simulate_batch(wanted, workers=1))
    assert [index for index, _ in told] == list(range(len(wanted)))
    for index, log in simulate_batch(wanted, workers=3):
        assert_same(log, told[index][1])


def test_collisions_and_whims_were_met():
    # Or the drives above would not have tried them.
    wanted = list(drives(["wander collides", "collides"], 250))
    for _, log in simulate_batch(wanted):
        assert log.truth.collision.any()


def test_logs_are_handed_out_while_others_are_still_to_come():
    begun = 0

    def endless():
        nonlocal begun
        while True:
            begun += 1
            yield BatchDrive(worlds.load("thesis-exp1"), 5, begun)

    batch = simulate_batch(endless(), workers=2)
    assert len({next(batch)[0] for _ in range(20)}) == 20
    assert begun <= 24
    batch.close()


@pytest.mark.parametrize("sonar", ["thesis", "physical"])
def test_a_start_of_its_own(sonar):
    start = worlds.Pose(2.5, 3.0, 0.4)
    wanted = BatchDrive(worlds.load("office"), 3, 0, sonar=sonar, start=start)
    ((_, log),) = simulate_batch([wanted])
    assert (log.truth.x_m[0], log.truth.y_m[0], log.truth.heading_rad[0]) == (2.5, 3.0, 0.4)
    assert_same(log, single(wanted))


class Own:
    """A driver that is no numbers."""

    def begin(self, rng):
        return lambda sensed: (0.1, 0.1)


class Silent(sim.ConeSonar):
    """A cone whose author changed what it detects, and not what it says of its compiled form."""

    def listen(self, *arguments):
        echoes = super().listen(*arguments)
        return dataclasses.replace(echoes, range_m=np.full_like(echoes.range_m, np.inf))


class Hasty(sim.Waypoints):
    """A driver likewise."""

    def begin(self, rng):
        return lambda sensed: (0.3, 0.3)


class Renamed(sim.PhysicalSonar):
    """A sonar whose author changed nothing."""


INTERFERER = sim.Interferer(1.0, 0.0, period_s=0.1)


def test_drivers_and_sonars_say_whether_they_are_compiled():
    room = worlds.load("office")
    renamed = Renamed("mine", PHYSICAL.ring)
    for name in drivers.names():
        for sonar in (EXACT["aria"], PHYSICAL, physical(firing=InPairs()), renamed):
            assert is_compiled(drivers.driver(name, room), sonar)
    driver = drivers.driver("wander", room)
    for sonar in (
        EXACT["aria"].replace(rays=31),
        presets.preset("webots"),
        physical(search="rays"),
        physical(interferers=(INTERFERER,)),
        Silent("silent", sm.AMIGOBOT, 0.1),
    ):
        assert not is_compiled(driver, sonar)
    for own in (Own(), Hasty(((1.0, 1.0),))):
        assert not is_compiled(own, EXACT["aria"])


@pytest.mark.parametrize(
    "changes",
    [
        {"sonar": Silent("silent", sm.AMIGOBOT, 0.1)},
        {"sonar": physical(search="rays")},
        {"sonar": physical(interferers=(INTERFERER,))},
        {"packets": sim.StatusPackets()},
        {"driver": Hasty(((1.0, 1.0),))},
    ],
)
def test_what_cannot_be_compiled_goes_step_by_step(monkeypatch, changes):
    monkeypatch.setattr(simulation, "compiled_log", None)
    log = sim.simulate(worlds.load("office"), scans=3, seed=0, engine="segments", **changes)
    if isinstance(changes.get("sonar"), Silent):
        assert np.isinf(log.range_m).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scans": 0}, r"scans must be >= 1, got 0"),
        ({"seed": -1}, r"seed must be >= 0, got -1"),
        (
            {"sonar": physical(search="rays")},
            r"sonar 'physical' must be an exact simple cone, or a physical sonar without rays and",
        ),
        ({"driver": Own()}, r"driver must be one that is compiled, got <.*Own"),
        ({"driver": "wandr"}, r"driver 'wandr' is unknown; did you mean 'wander'\?"),
        ({"start": worlds.Pose(0, 0, 0)}, r"start of \(0, 0\) m.* must leave the robot"),
    ],
)
def test_bad_drives_are_refused(changes, message):
    arguments = {"world": worlds.load("office"), "scans": 3, "seed": 0} | changes
    for workers in (1, 2):
        with pytest.raises(InputError, match=message):
            list(simulate_batch([BatchDrive(**arguments)], workers=workers))
    with pytest.raises(InputError, match=r"workers must be >= 1, got 0"):
        list(simulate_batch([], workers=0))
