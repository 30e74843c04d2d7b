import math

import numpy as np
import pytest
from rooms import box, closed_room, world

import worlds
from sim.envs.facts import RoomFacts, facts_of
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import InputError
from worlds import Pose


@pytest.mark.parametrize("name", worlds.names())
def test_the_robot_fits_at_every_random_start(name, rng):
    facts = facts_of(worlds.load(name), 0.1)
    starts = [facts.random_start(rng) for _ in range(50)]
    for start in starts:
        assert facts.world.has_room_at(start.x_m, start.y_m, radius_m=BODY_RADIUS_M + 0.06)
        assert facts.is_reachable(start.x_m, start.y_m)
    assert len({(start.x_m, start.y_m) for start in starts}) > 10
    assert np.ptp([start.heading_rad for start in starts]) > math.pi


def test_what_lies_behind_a_gap_too_narrow_is_not_reachable():
    half_gap = BODY_RADIUS_M - 0.05
    walls = closed_room(2.0).solids
    left, right = (
        box("left", -0.05, half_gap, 0.05, 2.0),
        box("right", -0.05, -2.0, 0.05, -half_gap),
    )
    facts = RoomFacts(world(*walls, left, right, start=(-1.0, 0.0, 0.0)), 0.1)
    assert facts.is_reachable(-1.0, 0.5)
    assert not facts.is_reachable(1.0, 0.5)
    assert facts.distance_m(-1.0, 0.0)[facts.grid.cell_of(1.0, 0.0)] == math.inf


def test_ways_go_around_obstacles():
    # A wall from the top leaves a passage at the bottom of a room 4 m wide.
    wall = box("wall", -0.1, -1.0, 0.1, 2.0)
    facts = RoomFacts(world(*closed_room(2.0).solids, wall, start=(-1.0, 1.0, 0.0)), 0.05)
    distance_m = facts.distance_m(1.0, 1.0)
    left_m = distance_m[facts.grid.cell_of(-1.0, 1.0)]
    # Around the wall's end, at the robot's radius: two straight parts and a little between.
    corner = 1.0 + BODY_RADIUS_M
    shortest_m = 2 * math.hypot(1.0 - 0.1, 1.0 + corner) + 0.2
    # Steps are straight or diagonal, and the cells at the corner must leave the robot room.
    assert shortest_m <= left_m <= shortest_m * 1.15
    assert distance_m[facts.grid.cell_of(1.0, 0.5)] == pytest.approx(0.5, abs=0.051)


def test_random_goals_are_as_far_as_asked(rng):
    facts = facts_of(worlds.load("office"), 0.1)
    start = facts.random_start(rng)
    for _ in range(30):
        goal = facts.random_goal(rng, start, 2.0, 4.0)
        assert 1.9 <= facts.distance_m(*goal)[facts.grid.cell_of(start.x_m, start.y_m)] <= 4.1
        assert facts.is_reachable(*goal)


def test_in_a_small_room_the_goal_is_the_farthest_there_is(rng):
    facts = facts_of(worlds.load("round-room"), 0.1)
    goal = facts.random_goal(rng, Pose(0.0, 0.0, 0.0), 50.0, 60.0)
    assert math.hypot(*goal) > 0.8


def test_the_sign_is_what_a_map_shall_say():
    known = worlds.load("thesis-exp1")
    facts = facts_of(known, 0.1)
    truth = worlds.truth(known, facts.grid)
    assert ((facts.sign == 1) == (truth.state == worlds.OCCUPIED)).all()
    assert ((facts.sign == -1) == (truth.state == worlds.FREE)).all()
    assert (facts.sign[facts.reachable] == -1).all()


def test_a_room_without_a_place_for_the_robot_is_refused():
    narrow = closed_room(BODY_RADIUS_M - 0.03)
    with pytest.raises(InputError, match="'test' has no place where the robot fits"):
        RoomFacts(narrow, 0.02)


def test_facts_are_made_once_a_room():
    one, other = worlds.load("l-shape"), worlds.load("l-shape")
    assert facts_of(one, 0.1) is facts_of(other, 0.1)
    assert facts_of(one, 0.1) is not facts_of(one, 0.2)
