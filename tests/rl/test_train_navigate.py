"""The training example, for a moment; run by `make test-rl`."""

import csv
import json

import gymnasium
import numpy as np
import pytest
from scipy.stats import binomtest
from stable_baselines3 import PPO

import train_navigate
from sonarmap import InputError
from train_navigate import JUDGED_IN, TRAINED_IN, Share, judge, straight_on, training_rooms


@pytest.mark.parametrize(("successes", "episodes"), [(0, 100), (7, 20), (50, 50)])
def test_the_interval_is_wilsons(successes, episodes):
    expected = binomtest(successes, episodes).proportion_ci(method="wilson")
    low, high = Share(successes, episodes).interval
    assert (low, high) == pytest.approx((expected.low, expected.high), abs=1e-8)


def test_the_rooms_are_many_and_the_judges_are_not_among_them():
    rooms = training_rooms()
    assert len({room.start for room in rooms}) == len(rooms) == 8 * len(TRAINED_IN)
    assert not {room.name for room in rooms} & set(JUDGED_IN)


def test_the_same_seeds_give_all_policies_the_same_starts_and_goals():
    seen = []

    def watching(env):
        def act(observations):
            seen.append(observations["goal"].copy())
            return straight_on(observations)

        return act

    shares = [judge(watching, "l-shape", episodes=3, seed=1) for _ in range(2)]
    np.testing.assert_array_equal(seen[0], seen[len(seen) // 2])
    assert shares[0] == shares[1]
    assert shares[0].episodes == 3


def test_a_short_training_leaves_all_its_files(tmp_path, monkeypatch):
    for name, value in {"ROBOTS": 4, "CURVE_EPISODES": 2, "FILM_TRIES": 1}.items():
        monkeypatch.setattr(train_navigate, name, value)
    train_navigate.main(minutes=0.02, seed=3, episodes=2, out=tmp_path)
    told = json.loads((tmp_path / "results.json").read_text())
    assert set(told["shares"]) == {"random", "straight to the goal", "PPO"}
    assert all(set(rooms) == set(JUDGED_IN) for rooms in told["shares"].values())
    with (tmp_path / "curve.csv").open() as file:
        points = list(csv.DictReader(file))
    assert int(points[-1]["steps"]) == told["steps"] > 0
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")
    model = PPO.load(tmp_path / "model.zip", device="cpu")
    with gymnasium.make(train_navigate.NAVIGATE) as env:
        action, _ = model.predict(env.reset(seed=0)[0], deterministic=True)
        assert action in env.action_space


@pytest.mark.parametrize("option", ["minutes", "episodes"])
def test_bad_numbers_are_named(option, tmp_path):
    arguments = {"minutes": 1.0, "seed": 0, "episodes": 2, "out": tmp_path / "out", option: 0}
    with pytest.raises(InputError, match=f"--{option} must be"):
        train_navigate.main(**arguments)
    assert not (tmp_path / "out").exists()
