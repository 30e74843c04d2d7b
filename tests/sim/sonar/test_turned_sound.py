"""Pillars and edges that turn the sound of one sonar to another."""

import math

import numpy as np
import pytest
from rooms import MIRROR, box, pillar, world
from scipy.optimize import minimize_scalar

from sim import AllAtOnce, PhysicalSonar, Receiver, TransducerSpread
from sim.sonar.physical.turning import pillar_share_db, turning_place
from sonarmap import Cause, SonarRing

# Two sonars side by side, the first nearer to what is ahead.
PAIR = SonarRing("pair", [0.3, 0.0], [0.1, -0.1], [0.0, 0.0], math.radians(15), 0.1, 5.0)
LOUD = Receiver(70.0, 1.0, 1e-9, 0.0, noise_std_m=0, weak_noise_std_m=0, quantum_m=0)
SONAR = PhysicalSonar(
    "pair", PAIR, AllAtOnce(0.1), receiver=LOUD, spread=TransducerSpread(0.0, 0.0)
)
BY_SEARCH = pytest.mark.parametrize("search", ["images", "rays"])


def heard(room, search, ring=PAIR):
    array = SONAR.replace(search=search, ring=ring).array(
        room.faces, room, np.random.default_rng(0)
    )
    array.fire(0.0, (0, 1), np.column_stack([ring.x_m, ring.y_m]), ring.heading_rad)
    return array.detect()


@BY_SEARCH
@pytest.mark.parametrize("radius_m", [0.03, 0.2])
@pytest.mark.parametrize("y_m", [-0.15, 0.0, 0.1])
def test_pillar_turns_sound_by_the_shortest_way(radius_m, y_m, search):
    centre = np.array([1.5, y_m])
    echoes = heard(world(pillar("post", *centre, radius_m, MIRROR)), search)
    places = np.column_stack([PAIR.x_m, PAIR.y_m])

    def way_m(angle):
        place = centre + radius_m * np.array([math.cos(angle), math.sin(angle)])
        return np.hypot(*(places - place).T).sum()

    # Fermat: a mirror's way is the shortest.
    shortest = minimize_scalar(way_m, bounds=(math.pi / 2, 3 * math.pi / 2), method="bounded",
                               options={"xatol": 1e-10})  # fmt: skip
    assert echoes.source[1] == 0
    assert echoes.cause[1] == Cause.CROSSTALK
    assert echoes.range_m[1] == pytest.approx(shortest.fun / 2, abs=1e-6)
    assert echoes.bounces[1] == 0


@BY_SEARCH
def test_edge_turns_sound_as_a_point_does(search):
    room = world(box("edge", 1.5, 0, 3.5, 2, MIRROR, turned_deg=-45, about=(1.5, 0)))
    echoes = heard(room, search)
    ways_m = [math.hypot(1.5 - x, y) for x, y in zip(PAIR.x_m, PAIR.y_m, strict=True)]
    assert echoes.source[1] == 0
    assert echoes.range_m[1] == pytest.approx(sum(ways_m) / 2, abs=3e-4)
    own = SONAR.replace(search=search).listen(
        room.faces, room, np.array([[0.0, -0.1]]), np.zeros(1), np.random.default_rng(0)
    )
    # The gain takes the spreading of a mirror's path back; an edge's falls with both ways.
    sent_db = SONAR.piston.level_db(math.atan2(-0.1, 1.2)) - SONAR.piston.level_db(
        math.atan2(0.1, 1.5)
    )
    expected_db = 20 * math.log10(sum(ways_m) / 2 / ways_m[0]) + sent_db
    assert echoes.level_db[1] - own.level_db[0] == pytest.approx(expected_db, abs=0.1)


@BY_SEARCH
def test_hidden_pillar_turns_nothing(search):
    post = pillar("post", 1.5, 0.0, 0.05, MIRROR)
    assert heard(world(post), search).source[1] == 0
    # A screen before the far sonar.
    screen = box("screen", 0.3, -0.4, 0.31, -0.05, MIRROR)
    assert heard(world(post, screen), search).source[1] != 0


def test_there_and_back_are_as_loud(rng):
    for _ in range(50):
        one, other = rng.uniform(-1, 1, (2, 2))
        radius_m = rng.uniform(0.02, 0.3)
        there = turning_place(3.0, 0.5, radius_m, *one, *other)
        back = turning_place(3.0, 0.5, radius_m, *other, *one)
        assert there == pytest.approx(back, abs=1e-9)
        x, y, cos = there
        ways_m = [math.hypot(x - a, y - b) for a, b in (one, other)]
        assert pillar_share_db(radius_m, cos, *ways_m) == pytest.approx(
            pillar_share_db(radius_m, cos, *ways_m[::-1])
        )


@pytest.mark.parametrize("radius_m", [0.01, 0.1, 1.0])
def test_share_of_a_pillar_met_head_on_is_that_of_kuc_and_siegel(radius_m):
    for half_m in (0.3, 1.0, 4.0):
        expected_db = 10 * math.log10(radius_m / (radius_m + half_m))
        assert pillar_share_db(radius_m, 1.0, half_m, half_m) == pytest.approx(expected_db)
