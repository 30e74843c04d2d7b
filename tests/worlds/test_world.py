import math
import pickle

import numpy as np
import pytest
from shapely.affinity import rotate, scale

import worlds

SOME = ("clutter", "office", "thesis-exp2")  # boxes at angles, pillars, routes, many walls


@pytest.fixture(params=SOME)
def world(request):
    return worlds.load(request.param)


def same_shape(one, other):
    return one.symmetric_difference(other).area < 1e-12


def test_a_world_that_is_turned_has_turned_solids(world):
    for turns in range(4):
        turned = world.transformed(quarter_turns=turns)
        for before, after in zip(world.solids, turned.solids, strict=True):
            assert (after.name, after.material) == (before.name, before.material)
            assert same_shape(after.outline, rotate(before.outline, 90 * turns, origin=(0, 0)))


def test_start_route_and_bounds_turn_with_the_world():
    world = worlds.load("office").transformed(quarter_turns=1)
    assert world.start == worlds.Pose(0.6, 6.8, math.pi)
    assert world.route_m[:2] == ((-1.0, 6.8), (-2.8, 6.0))
    assert world.bounds_m == (-6.1, -0.1, 1.3, 8.1)


def test_pillars_turn_as_exact_circles():
    world = worlds.load("clutter")
    column = next(solid for solid in world.solids if solid.name == "column")
    assert column.circle == (2.3, 2.7, 0.15)
    (turned,) = (s for s in world.transformed(quarter_turns=1).solids if s.name == "column")
    assert turned.circle == (-2.7, 2.3, 0.15)
    (mirrored,) = (s for s in world.mirrored().solids if s.name == "column")
    assert mirrored.circle == (2.3, -2.7, 0.15)


def test_four_quarter_turns_are_none(world):
    turned = world
    for _ in range(4):
        turned = turned.transformed(quarter_turns=1)
    assert turned.start.heading_rad == pytest.approx(world.start.heading_rad)
    assert turned.solids == world.solids
    assert turned.route_m == world.route_m
    assert world.transformed(quarter_turns=4) == world.transformed(quarter_turns=0) == world


def test_turns_add_up_also_backwards(world):
    back = world.transformed(quarter_turns=3).transformed(quarter_turns=-1)
    assert back.solids == world.transformed(quarter_turns=2).solids


def test_a_mirrored_world_has_left_and_right_exchanged(world):
    mirrored = world.mirrored()
    assert mirrored.start.heading_rad == -world.start.heading_rad
    assert mirrored.start.y_m == -world.start.y_m
    assert mirrored.route_m == tuple((x, -y) for x, y in world.route_m)
    for before, after in zip(world.solids, mirrored.solids, strict=True):
        assert same_shape(after.outline, scale(before.outline, 1, -1, origin=(0, 0)))


def test_mirroring_twice_is_nothing(world):
    assert world.mirrored().mirrored() == world
    assert world.mirrored() != world


def test_mirroring_reverses_the_sense_of_turning(world):
    one_way = world.mirrored().transformed(quarter_turns=1)
    other_way = world.transformed(quarter_turns=-1).mirrored()
    assert one_way.solids == other_way.solids
    assert one_way.bounds_m == other_way.bounds_m


def test_a_world_cannot_be_changed(world):
    with pytest.raises(AttributeError):
        world.start = None
    with pytest.raises(TypeError):
        world.notes["start.x_m"] = "guessed"
    with pytest.raises(ValueError, match="read-only"):
        world.faces.segments_m[0, 0] = 1.0


def test_a_world_is_the_same_after_a_journey_to_another_process():
    world = worlds.load("opening-rig", gap_m=0.6)
    arrived = pickle.loads(pickle.dumps(world))
    assert arrived == world
    assert hash(arrived) == hash(world)
    assert np.array_equal(arrived.faces.segments_m, world.faces.segments_m)


def test_faces_are_computed_once(world):
    assert world.faces is world.faces
