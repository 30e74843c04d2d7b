"""Faces small for a Fresnel zone, against Fresnel's integrals and against each other."""

import itertools
import math

import numpy as np
import pytest
from rooms import MIRROR, box, world
from scipy.special import fresnel

from sim import AllAtOnce, PhysicalSonar, Receiver, TransducerSpread
from sonarmap import SonarRing

AHEAD = SonarRing("ahead", [0], [0], [0], math.radians(15), 0.1, 5.0)
# No side lobes, no noise, no late crossing, no edges.
SONAR = PhysicalSonar(
    "plain",
    AHEAD,
    AllAtOnce(0.1),
    receiver=Receiver(34.0, 1.0, 1e-9, 0.58e-3, noise_std_m=0, weak_noise_std_m=0, quantum_m=0),
    spread=TransducerSpread(0.0, 0.0),
    edge_db=-200,
)
WAVELENGTH_M = SONAR.acoustics.wavelength_m
BY_SEARCH = pytest.mark.parametrize(("search", "within_db"), [("images", 0.02), ("rays", 1.3)])


def heard(room, *, search="images", axis_deg=0.0, sonar=SONAR):
    array = sonar.replace(search=search).array(room.faces, room, np.random.default_rng(0))
    array.fire(0.0, (0,), np.zeros((1, 2)), np.radians([axis_deg]))
    return array.detect()


def level_db(room, **arguments):
    return heard(room, **arguments).level_db[0]


def wall(distance_m=2.0, low_m=-30.0, high_m=30.0):
    return box("wall", distance_m, low_m, distance_m + 0.01, high_m, MIRROR)


def theory_db(low_m, high_m, distance_m):
    """Return the level of a strip of a plane, there and back, against that of the plane."""
    u = np.array([low_m, high_m]) * 2 / math.sqrt(WAVELENGTH_M * distance_m)
    sine, cosine = fresnel(u)
    return 10 * math.log10((np.diff(sine)[0] ** 2 + np.diff(cosine)[0] ** 2) / 2)


@BY_SEARCH
@pytest.mark.parametrize("distance_m", [1.0, 2.0, 3.0])
@pytest.mark.parametrize("width_m", [0.05, 0.1, 0.2, 0.4, 0.6])
def test_plate_is_as_loud_as_fresnels_integrals_say(width_m, distance_m, search, within_db):
    plate = world(wall(distance_m, -width_m / 2, width_m / 2))
    lost_db = level_db(plate, search=search) - level_db(world(wall(distance_m)), search=search)
    expected_db = theory_db(-width_m / 2, width_m / 2, distance_m)
    # Of plates of more than 8 arguments' width ripples are left out.
    if width_m / math.sqrt(WAVELENGTH_M * distance_m) > 6:
        expected_db = 0.0
        within_db += 0.5
    assert lost_db == pytest.approx(expected_db, abs=within_db)
    assert heard(plate, search=search).range_m[0] == pytest.approx(distance_m, abs=1e-6)


def test_small_plate_loses_six_decibels_with_half_its_width():
    levels = [level_db(world(wall(3.0, -w / 2, w / 2))) for w in (0.04, 0.02, 0.01)]
    assert np.diff(levels) == pytest.approx([-6.02, -6.02], abs=0.1)


@BY_SEARCH
def test_wall_that_ends_at_the_foot_is_half_as_high(search, within_db):
    lost_db = level_db(world(wall(low_m=0.0)), search=search) - level_db(world(wall()))
    assert lost_db == pytest.approx(-6.02, abs=within_db)


@pytest.mark.parametrize("parts", [2, 5, 40])
def test_wall_of_flush_parts_is_one_wall(parts):
    cuts = np.linspace(-1, 1, parts + 1)
    solids = [
        box(f"part {k}", 2.0, low, 2.3, high, MIRROR)
        for k, (low, high) in enumerate(itertools.pairwise(cuts))
    ]
    whole = world(box("whole", 2.0, -1, 2.3, 1, MIRROR))
    for axis_deg in (-6, 0, 3.3):
        one, other = heard(world(*solids), axis_deg=axis_deg), heard(whole, axis_deg=axis_deg)
        assert one.level_db[0] == pytest.approx(other.level_db[0], abs=1e-6)
        assert one.range_m[0] == other.range_m[0]


@pytest.mark.parametrize("depth_m", [0.02, 0.1, 0.5])
def test_back_of_a_recess_ends_where_its_opening_throws_a_shadow(depth_m):
    """The walls of a recess mirror its back on as far as a way through the opening goes."""
    back_m, half_m = 2.0, 0.05
    room = world(
        box("back", back_m, -1, back_m + 0.1, 1, MIRROR),
        box("left", back_m - depth_m, half_m, back_m, 1, MIRROR),
        box("right", back_m - depth_m, -1, back_m, -half_m, MIRROR),
    )
    # The front beside the recess is nearer, but its foot is in the recess.
    echoes = heard(room)
    assert echoes.range_m[0] == pytest.approx(back_m, abs=1e-6)
    reach_m = half_m * back_m / (back_m - depth_m)
    lost_db = echoes.level_db[0] - level_db(world(wall(back_m)))
    assert lost_db == pytest.approx(theory_db(-reach_m, reach_m, back_m), abs=0.02)


def test_wall_beside_a_large_wall_ends_nowhere():
    """In a room's corner the other wall mirrors it on."""
    room = world(
        box("ahead", 2.0, -3, 2.2, 0.03, MIRROR), box("beside", -3, 0.03, 2.2, 0.2, MIRROR)
    )
    array = SONAR.array(room.faces, room, np.random.default_rng(0))
    array.fire(0.0, (0,), np.array([[0.0, -0.01]]), np.zeros(1))
    assert array.detect().level_db[0] == pytest.approx(level_db(world(wall())), abs=0.05)


@pytest.mark.parametrize("arm_m", [0.03, 0.08, 0.2])
def test_corner_is_as_wide_as_its_arms_across_the_sound(arm_m):
    def corner(arm_m):
        return world(
            box("a", 2.0, -arm_m, 2.01, 0, MIRROR, turned_deg=-45, about=(2, 0)),
            box("b", 2.0, 0, 2.01, arm_m, MIRROR, turned_deg=45, about=(2, 0)),
        )

    lost_db = level_db(corner(arm_m)) - level_db(corner(5.0))
    width_m = arm_m / math.sqrt(2)
    assert lost_db == pytest.approx(theory_db(-width_m, width_m, 2.0), abs=0.5)


def test_narrow_mirror_takes_from_a_ghost():
    """A mirror is an opening in unfolded space, passed there and back."""

    def ghost(half_m):
        mirror = box("mirror", 1.0, -half_m, 1.01, half_m, MIRROR, turned_deg=-45, about=(1, 0))
        return world(mirror, box("board", -2, 1.5, 4, 1.51, MIRROR))

    # The mirror itself, at 45 degrees, sends nothing back.
    wide, narrow = (heard(ghost(half_m)) for half_m in (0.6, 0.04))
    for echoes in (wide, narrow):
        assert echoes.range_m[0] == pytest.approx(2.5, abs=1e-6)
        assert echoes.bounces[0] == 1
    # 1 m before the mirror and 4 m behind it; the mirror is met at 45 degrees.
    across_m = 0.04 / math.sqrt(2)
    u = across_m * math.sqrt(2 * 5.0 / (WAVELENGTH_M * 1.0 * 4.0))
    sine, cosine = fresnel(u)
    expected_db = 2 * 10 * math.log10(2 * (sine**2 + cosine**2))
    assert narrow.level_db[0] - wide.level_db[0] == pytest.approx(expected_db, abs=0.3)


def test_small_things_on_a_wall_do_not_change_what_is_far_from_them():
    plain = world(box("wall", 2, -3, 2.2, 3, MIRROR))
    furnished = world(
        box("wall", 2, -3, 2.2, 3, MIRROR), box("box", 1.9, 1.5, 2, 1.6, MIRROR),
    )  # fmt: skip
    assert level_db(furnished) == pytest.approx(level_db(plain), abs=0.05)
