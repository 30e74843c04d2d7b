import gymnasium
import numpy as np
import pytest
from rooms import closed_room

import sim  # noqa: F401  registers the environments
from sim.envs.policies.kernel import step_towards
from sim.envs.policies.policies import frontier_policy, random_policy, wall_follow_policy
from sonarmap import InputError


def drive(name, policy, *, world, seed, steps, **arguments):
    """Return the sum of the rewards and the last info of an episode's first steps."""
    env = gymnasium.make(f"sonarbed/{name}-v1", world=world, **arguments)
    observation, _ = env.reset(seed=seed)
    act, score = policy(env), 0.0
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(act(observation))
        score += reward
        if terminated or truncated:
            break
    env.close()
    return score, info


def randomly(env):
    return random_policy(env.action_space, np.random.default_rng(0))


def observation(range_share=1.0, **changes):
    """Return what a robot knows that hears nothing, or what is given."""
    return {
        "range": np.full(8, range_share, np.float32),
        "validity": np.zeros(8, np.int8),
        "speed": np.zeros(2, np.float32),
        "last_action": np.zeros(2, np.float32),
        **changes,
    }


@pytest.mark.parametrize("action", ["velocity", "wheels", "discrete"])
def test_random_actions_are_in_the_space_and_are_those_of_the_seed(action):
    with gymnasium.make("sonarbed/FollowWall-v1", action=action) as env:
        before = repr(env.action_space.np_random.bit_generator.state)
        first, again = randomly(env), randomly(env)
        for _ in range(20):
            drawn = first({})
            assert drawn in env.action_space
            np.testing.assert_array_equal(drawn, again({}))
        assert repr(env.action_space.np_random.bit_generator.state) == before


@pytest.mark.parametrize("world", ["thesis-exp1", "l-shape", "office", "corridor", "round-room"])
def test_following_the_wall_earns_much_more_than_chance(world):
    def follow(env):
        return wall_follow_policy()

    followed, chance = (
        [drive("FollowWall", policy, world=world, seed=seed, steps=300)[0] for seed in (0, 1)]
        for policy in (follow, randomly)
    )
    assert np.mean(followed) > 40 > 10 > np.mean(chance)


def test_the_frontier_is_mapped_much_better_than_by_chance():
    def seek(env):
        return frontier_policy()

    mapped, chance = (
        [
            drive("Explore", policy, world=world, seed=0, steps=300, map_patch=64)[1][
                "mapped_share"
            ]
            for world in ("thesis-exp2", "l-shape", "office", "corridor")
        ]
        for policy in (seek, randomly)
    )
    assert np.mean(mapped) > np.mean(chance) + 0.15
    assert all(np.greater(mapped, chance))


@pytest.mark.parametrize("make", [wall_follow_policy, frontier_policy])
def test_a_policy_remembers_nothing_and_changes_nothing(make, rng):
    act = make()
    seen = observation(
        range=rng.random(8).astype(np.float32),
        map=rng.integers(0, 256, (1, 32, 32)).astype(np.uint8),
    )
    copies = {name: values.copy() for name, values in seen.items()}
    first = act(seen)
    act(observation(map=np.full((1, 32, 32), 128, np.uint8)))
    np.testing.assert_array_equal(act(seen), first)
    assert first.dtype == np.float32
    for name, values in seen.items():
        np.testing.assert_array_equal(values, copies[name])


def test_with_nothing_near_the_wall_follower_drives_straight_on():
    speed, turn = wall_follow_policy()(observation())
    assert speed > 0.4
    assert turn == 0


def test_with_something_too_near_ahead_the_wall_follower_backs_off():
    nearness = observation()
    nearness["range"][[2, 3]] = 0
    speed, turn = wall_follow_policy()(nearness)
    assert speed < 0
    assert turn < 0


def hall(side):
    """Return a patch of 21 cells: walls all around, but unknown on one side."""
    patch = np.full((21, 21), 0, np.uint8)
    patch[[0, -1]] = 255
    patch[:, [0, -1]] = 255
    border = {"ahead": np.s_[0, :], "left": np.s_[:, 0], "right": np.s_[:, -1]}
    patch[border[side]] = 128
    return patch[None]


@pytest.mark.parametrize(("side", "sign"), [("left", 1), ("right", -1), ("ahead", 0)])
def test_the_frontier_policy_turns_to_where_the_map_ends(side, sign):
    speed, turn = frontier_policy()(observation(map=hall(side)))
    if sign == 0:
        assert speed > 0.4
        assert abs(turn) < 0.5
    else:
        assert sign * turn > 0.4


def test_a_near_echo_bars_the_way_though_the_map_calls_it_free():
    open_ahead = observation(map=hall("ahead"))
    open_ahead["range"][[1, 2, 3, 4]] = 0.5 / 5.0
    assert frontier_policy()(open_ahead)[0] < 0.1


def test_a_frontier_behind_a_wall_is_not_sought():
    behind = hall("left")
    behind[0, :, 4] = 255
    _, turn = frontier_policy()(observation(map=behind))
    assert turn == 0


def test_steps_go_around_what_bars_the_way():
    cost = np.ones((5, 5))
    cost[1:5, 2] = np.inf
    goals = np.zeros((5, 5), bool)
    goals[4, 4] = True
    assert step_towards(goals, cost, 4, 0, 100) == (4, 4)
    assert step_towards(goals, cost, 4, 0, 3) == (1, 1)
    assert step_towards(goals, cost, 4, 4, 3) == (4, 4)
    cost[0, 2] = np.inf
    assert step_towards(goals, cost, 4, 0, 3) == (-1, -1)


def test_a_worse_way_costs_its_steps():
    cost = np.ones((3, 9))
    cost[1, 1:8] = 5.0
    goals = np.zeros((3, 9), bool)
    goals[1, 8] = True
    row, _ = step_towards(goals, cost, 1, 0, 1)
    assert row != 1


@pytest.mark.parametrize(
    ("make", "arguments", "message"),
    [
        (wall_follow_policy, {"distance_m": 0}, "distance_m must be"),
        (frontier_policy, {"cell_m": -0.1}, "cell_m must be"),
    ],
)
def test_bad_numbers_are_named(make, arguments, message):
    with pytest.raises(InputError, match=message):
        make(**arguments)


def test_in_a_closed_room_the_wall_follower_never_touches():
    env = gymnasium.make("sonarbed/FollowWall-v1", world=closed_room(1.5))
    seen, _ = env.reset(seed=3)
    act, touched = wall_follow_policy(), 0.0
    for _ in range(300):
        seen, _, _, _, info = env.step(act(seen))
        touched += info["reward_terms"]["collision"]
    env.close()
    assert touched == 0
