"""Rewards on states made by hand: no engine, no sonar."""

import math

import numpy as np
import pytest
from rooms import closed_room

import worlds
from sim.envs.facts import RoomFacts, facts_of
from sim.envs.states import new_states
from sim.envs.tasks.explore import Explore, ExploreWeights, explore_terms
from sim.envs.tasks.follow_wall import FollowWall, closeness, follow_terms
from sim.envs.tasks.navigate import Navigate, NavigateWeights, navigate_terms
from sim.envs.tasks.task import StepOutcome, TaskSetup, weighted
from sim.robot.amigobot import SPEED_MAX_MPS
from sonarmap import InputError
from worlds import Pose

OFFICE = facts_of(worlds.load("office"), 0.1)
NO = np.zeros(1, bool)


def states_at(*poses):
    states = new_states(len(poses), 8)
    states["true_pose"] = states["believed_pose"] = poses
    return states


def outcome(states, maps=None, stuck=None, effort=0.0):
    n = len(states)
    return StepOutcome(
        states, np.zeros(n, bool) if stuck is None else stuck, np.full(n, effort), maps
    )


def task_setup(start=(2.5, 3.0, 0.0), goal="random", facts=OFFICE, seed=0):
    return TaskSetup(facts, Pose(*start), goal, np.random.default_rng(seed))


class Gains:
    """What `Explore` asks of maps."""

    def __init__(self, bits, new, mapped):
        self.bits_gained, self.new_cells, self.mapped_cells = map(
            np.atleast_1d, (bits, new, mapped)
        )


@pytest.mark.parametrize(
    ("terms", "expected"),
    [
        # a worse map, nothing new, a collision
        (explore_terms(np.array([-0.2]), np.array([0.0]), ~NO, np.array([0.5])), [-0.2, 0, 1, 0.5]),
        # a better map and new area
        (explore_terms(np.array([1.5]), np.array([0.4]), NO, np.array([0.0])), [1.5, 0.4, 0, 0]),
        # nearer, not there; there
        (navigate_terms(np.array([0.1]), NO, NO, NO, np.array([0.2])), [0.1, 0, 0, 0, 0.2, 1]),
        (navigate_terms(np.array([-0.1]), ~NO, ~NO, NO, np.array([0.0])), [-0.1, 1, 1, 0, 0, 1]),
        (navigate_terms(np.array([0.0]), NO, ~NO, ~NO, np.array([0.0])), [0, 0, 1, 1, 0, 1]),
        # at full speed at the right distance; backwards; far from any wall
        (follow_terms(np.ones(1), np.array([0.1 * SPEED_MAX_MPS]), NO, np.zeros(1)), [1, 0, 0]),
        (follow_terms(np.ones(1), np.array([-0.0375]), ~NO, np.zeros(1)), [-0.5, 1, 0]),
        (follow_terms(np.zeros(1), np.array([0.075]), NO, np.ones(1)), [0, 0, 1]),
    ],
)
def test_terms(terms, expected):
    assert [value[0] for value in terms.values()] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("error_m", "expected"),
    [(0.0, 1), (0.05, 1), (0.225, 0.5), (0.4, 0), (3.0, 0), (math.inf, 0)],
)
def test_closeness(error_m, expected):
    assert closeness(np.array([error_m]), 0.05, 0.4)[0] == pytest.approx(expected)


def test_the_reward_is_the_weighted_sum_of_its_terms():
    terms = {"map_score": np.array([2.0, 0.0]), "collision": np.array([0.0, 1.0])}
    assert weighted(terms, {"map_score": 0.5, "collision": -3.0}).tolist() == [1.0, -3.0]


def test_explore_counts_gains_in_square_metres_and_ends_when_all_is_mapped():
    task = Explore(1, ExploreWeights(map_score=2.0, area=1.0, collision=0.0, effort=0.0))
    task.begin(0, task_setup())
    states, cells = states_at((2.5, 3.0, 0.0)), OFFICE.reachable_cells
    evaluation = task.evaluate(outcome(states, Gains(30.0, 5.0, 0.5 * cells)))
    assert evaluation.reward[0] == pytest.approx(2 * 0.30 + 0.05)
    assert (evaluation.terminated[0], evaluation.info["mapped_share"][0]) == (False, 0.5)
    evaluation = task.evaluate(outcome(states, Gains(0.0, 0.0, math.ceil(0.95 * cells))))
    assert evaluation.terminated[0]
    evaluation = task.evaluate(outcome(states, Gains(0.0, 0.0, 0.0), stuck=~NO))
    assert evaluation.terminated[0]


def test_navigate_rewards_the_way_around_obstacles_and_ends_at_the_goal():
    task = Navigate(1, NavigateWeights(time=0.0, effort=0.0))
    goal = (2.55, 1.05)
    task.begin(0, task_setup((2.55, 3.05, 0.0), goal))
    evaluation = task.evaluate(outcome(states_at((2.55, 2.55, 0.0))))
    distance_m = OFFICE.distance_m(*goal)
    nearer = (
        distance_m[OFFICE.grid.cell_of(2.55, 3.05)] - distance_m[OFFICE.grid.cell_of(2.55, 2.55)]
    )
    assert evaluation.terms["progress"][0] == pytest.approx(nearer)
    assert nearer > 0.3
    assert not evaluation.terminated[0]
    # Back to where it was: nothing is won by going to and fro.
    again = task.evaluate(outcome(states_at((2.55, 3.05, 0.0))))
    assert again.terms["progress"][0] == pytest.approx(-nearer)
    # Inside of a wall, in no reachable cell, the way does not change.
    assert task.evaluate(outcome(states_at((-0.05, 3.0, 0.0)))).terms["progress"][0] == 0
    there = task.evaluate(outcome(states_at((2.55, 1.05 + 0.29, 1.0))))
    assert there.terminated[0]
    assert there.info["is_success"][0]
    assert there.reward[0] > 5


def test_the_goal_is_told_by_odometry():
    task = Navigate(1)
    task.begin(0, task_setup((2.55, 3.05, 0.0), (2.55, 1.05)))
    states = states_at((2.55, 3.05, 0.0))
    states["believed_pose"] = (1.55, 1.05, math.pi / 2)  # lost: the goal seems 1 m to the right
    assert task.observe(states)["goal"][0] == pytest.approx([0.1, 0.0, -1.0], abs=1e-6)
    assert task.goal_of(0) == (2.55, 1.05)


def test_each_robot_has_its_own_goal_and_room():
    task = Navigate(2)
    small = facts_of(worlds.load("thesis-exp1"), 0.1)
    start = small.world.start
    task.begin(0, task_setup((2.55, 3.05, 0.0), (2.55, 1.05)))
    task.begin(1, task_setup((start.x_m, start.y_m, 0.0), "random", small))
    near = states_at((2.55, 1.1, 0.0), (start.x_m, start.y_m, 0.0))
    assert task.evaluate(outcome(near)).terminated.tolist() == [True, False]


@pytest.mark.parametrize("goal", [(-50.0, 0.0), (-0.05, 3.0), (5.0, 1.0)])
def test_a_goal_in_a_wall_or_outside_is_refused(goal):
    with pytest.raises(InputError, match=r"goal of .* must be where the robot .* fits"):
        Navigate(1).begin(0, task_setup(goal=goal))


def test_follow_wall_measures_the_wall_on_the_left():
    room = RoomFacts(closed_room(1.5), 0.1)  # its northern wall is at y = 1.5
    task = FollowWall(1)
    task.begin(0, task_setup((0.0, 1.0, 0.0), facts=room))
    evaluation = task.evaluate(outcome(states_at((0.1 * SPEED_MAX_MPS, 1.0, 0.0))))
    assert evaluation.info["wall_m"][0] == pytest.approx(0.5)
    assert evaluation.terms["following"][0] == pytest.approx(1.0)
    # Who drives west has it on the right.
    task.begin(0, task_setup((0.0, 1.0, math.pi), facts=room))
    evaluation = task.evaluate(outcome(states_at((-0.05, 1.0, math.pi))))
    assert evaluation.info["wall_m"][0] > 1.0
    assert evaluation.terms["following"][0] == 0
    # To stand is not to follow.
    task.begin(0, task_setup((0.0, 1.0, 0.0), facts=room))
    assert task.evaluate(outcome(states_at((0.0, 1.0, 0.0)))).terms["following"][0] == 0


@pytest.mark.parametrize("task", [Navigate, FollowWall])
def test_who_is_stuck_is_done(task):
    judged = task(1)
    judged.begin(0, task_setup())
    states = states_at((2.5, 3.0, 0.0))
    assert not judged.evaluate(outcome(states)).terminated[0]
    assert judged.evaluate(outcome(states, stuck=~NO)).terminated[0]
