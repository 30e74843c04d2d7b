import sys

import gymnasium
import numpy as np
import pytest

import sim
import sonarmap as sm
import worlds
from sim.envs.maps.robot_maps import MAP_MODEL
from sim.envs.policies.policies import random_policy, wall_follow_policy
from sim.envs.recording import RecordLog, record_minari
from sonarmap import InputError

OFFICE = "office"
DESCRIPTION = {
    "algorithm_name": "random",
    "author": "nobody",
    "author_email": "nobody@example.org",
    "code_permalink": "https://example.org",
    "description": "for a test",
}


def make(name="FollowWall", **arguments):
    arguments = {"world": OFFICE, "max_episode_steps": 40, **arguments}
    return gymnasium.make(f"sonarbed/{name}-v1", **arguments)


def drive(env, *, seed=7, steps=40, options=None):
    observation, _ = env.reset(seed=seed, options=options)
    act, score, infos = wall_follow_policy(), 0.0, []
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(act(observation))
        score += reward
        infos.append(info)
        if terminated or truncated:
            break
    return score, infos


@pytest.fixture
def log():
    with RecordLog(make()) as env:
        drive(env)
        return env.logs[0]


def test_a_log_has_each_reading_once_with_its_truth(log):
    ring = sim.sonar.presets.preset("aria").ring
    assert log.ring == ring
    assert len(log) == 41 * len(ring)  # at time 0 and in each step
    np.testing.assert_array_equal(log.scan, np.repeat(np.arange(41), len(ring)))
    np.testing.assert_array_equal(log.sonar, np.tile(np.arange(len(ring)), 41))
    np.testing.assert_allclose(log.time_s, 0.1 * log.scan, atol=1e-9)
    assert log.truth.surface.dtype.kind == "U"
    known = {solid.name for solid in worlds.load(OFFICE).solids} | {""}
    assert set(log.truth.surface) <= known
    assert not log.truth.collision.any()


def test_the_log_tells_where_the_robot_was(log):
    with make() as env:
        _, infos = drive(env)
    last = log.select(log.scan == 40)
    for name, value in zip(("x_m", "y_m", "heading_rad"), infos[-1]["true_pose"], strict=True):
        assert getattr(last.truth, name) == pytest.approx(value, abs=1e-12)
    assert not np.array_equal(log.x_m, log.truth.x_m)


def test_right_causes_agree_with_the_true_ranges(log):
    direct = log.truth.cause == sm.Cause.DIRECT
    assert direct.sum() > 20
    error_m = log.range_m[direct] - log.truth.axis_range_m[direct]
    assert np.abs(error_m).max() < 0.2


def test_a_log_survives_its_file(log, tmp_path):
    log.write(tmp_path / "log.parquet")
    again = sm.read_log(tmp_path / "log.parquet")
    assert again.provenance == log.provenance
    for name in log.DTYPES:
        np.testing.assert_array_equal(getattr(again, name), getattr(log, name))
    for name in log.truth.DTYPES:
        np.testing.assert_array_equal(getattr(again.truth, name), getattr(log.truth, name))


def test_a_log_is_mapped_mended_and_scored(log):
    model = sm.ParameterizedModel.thesis()
    for poses in ("odometry", "true"):
        assert (sm.build_map(log, model, poses=poses).log_odds != 0).any()
    mended = sm.hsr(log, sm.HsrParams(0.02, 0.12, 3.0, 0.06))
    score = sm.score_readings(log, mended.log)
    np.testing.assert_array_equal(score.cause, log.truth.cause)
    np.testing.assert_array_equal(score.updated, mended.updated)


@pytest.mark.parametrize("engine", ["segments", "bullet"])
def test_the_map_of_the_log_is_that_of_the_environment(engine):
    with RecordLog(make("Explore", engine=engine, max_episode_steps=15)) as env:
        drive(env, steps=15)
        mapped = env.unwrapped.occupancy_map
        built = sm.build_map(env.logs[0], MAP_MODEL, mapped.grid, max_range_m=3.0)
    np.testing.assert_allclose(built.log_odds, mapped.log_odds, atol=1e-9)


def test_sonars_that_fire_one_after_the_other_keep_their_times_and_poses():
    with RecordLog(make(sonar="physical", max_episode_steps=10)) as env:
        drive(env, steps=10)
        log = env.logs[0]
    assert (np.diff(log.time_s) > 0).all()
    assert np.unique(log.time_s.round(6)).size == len(log)
    # What fires in one control step is one scan.
    np.testing.assert_array_equal(log.scan, np.ceil(log.time_s.round(6) / 0.1 - 1e-6))
    assert np.isfinite(log.truth.level_db).any()


def test_the_provenance_tells_how_to_have_the_episode_again():
    room = worlds.load(OFFICE).mirrored()
    with RecordLog(make(world=[room])) as env:
        score, _ = drive(env, seed=3, options={"start": "world"})
        drive(env, seed=None)
        first, second = (log.provenance for log in env.logs)
    assert first["environment"] == "sonarbed/FollowWall-v1"
    assert first["arguments"]["world"] == [room.name]
    assert first["options"] == {"start": "world"}
    assert (first["seed"], first["resets_since_seed"]) == (3, 0)
    assert (second["seed"], second["resets_since_seed"]) == (3, 1)
    assert (first["world"], first["sonar"]) == (room.name, "aria")
    assert first["reward"] == pytest.approx(score)


def test_recording_changes_nothing():
    with make() as plain, RecordLog(make()) as recorded:
        assert drive(plain)[0] == drive(recorded)[0]


def test_each_episode_has_its_log_also_one_that_is_broken_off():
    with RecordLog(make()) as env:
        drive(env, steps=5)
        assert env.logs == []
        assert len(env.log()) == 6 * 8
        drive(env)
        assert [int(log.scan[-1]) for log in env.logs] == [5, 40]
        assert env.log() is env.logs[-1]


def test_a_collision_is_in_the_log():
    with RecordLog(make("Explore", world="thesis-exp1", max_episode_steps=400)) as env:
        env.reset(seed=0)
        for _ in range(400):
            _, _, terminated, _, _ = env.step(np.array([1.0, 0.0], np.float32))
            if terminated:
                break
        assert terminated
        assert env.logs[0].truth.collision.sum() >= 20 * 8


def test_no_log_before_the_first_reset():
    with RecordLog(make()) as env, pytest.raises(InputError, match="reset must be called"):
        env.log()


def test_only_our_environments_are_recorded():
    with (
        RecordLog(gymnasium.make("CartPole-v1")) as env,
        pytest.raises(InputError, match="must wrap an environment of sonarbed"),
    ):
        env.reset()


@pytest.fixture
def minari(tmp_path, monkeypatch):
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path))
    return pytest.importorskip("minari")


def record(env, **changes):
    policy = random_policy(env.action_space, np.random.default_rng(0))
    arguments = {"episodes": 2, "seed": 5, **DESCRIPTION, **changes}
    return record_minari(env, policy, "sonarbed/test/random-v0", **arguments)


def test_a_minari_data_set_survives_its_files(minari):
    arguments = {"world": ["l-shape", OFFICE], "map_patch": 16, "max_episode_steps": 12}
    with make("Navigate", **arguments) as env:
        record(env)
        env.reset(seed=0)  # it is still open
    kept = minari.load_dataset("sonarbed/test/random-v0")
    assert (kept.total_episodes, kept.total_steps) == (2, 24)
    with kept.recover_environment() as again:
        for seed, episode in zip((5, 6), kept.iterate_episodes(), strict=True):
            observations, rewards, ends = replayed(again, seed, episode.actions)
            for name, rows in episode.observations.items():
                np.testing.assert_array_equal(rows, [seen[name] for seen in observations])
            np.testing.assert_array_equal(episode.rewards, rewards)
            np.testing.assert_array_equal(episode.truncations, ends)


def replayed(env, seed, actions):
    observations, rewards, ends = [env.reset(seed=seed)[0]], [], []
    for action in actions:
        observation, reward, _, truncated, _ = env.step(action)
        observations.append(observation)
        rewards.append(reward)
        ends.append(truncated)
    return observations, rewards, ends


def test_a_data_set_is_not_overwritten(minari):
    with make(max_episode_steps=2) as env:
        record(env)
        with pytest.raises(InputError, match="dataset_id must be new"):
            record(env)


@pytest.mark.parametrize(
    ("arguments", "changes", "message"),
    [
        ({}, {"episodes": 0}, "episodes must be >= 1, got 0"),
        ({"world": worlds.load(OFFICE).mirrored()}, {}, "arguments that JSON can hold.*of its own"),
    ],
)
def test_what_minari_could_not_keep_is_named(minari, arguments, changes, message, tmp_path):
    with make(**arguments) as env, pytest.raises(InputError, match=message):
        record(env, **changes)
    assert list(tmp_path.iterdir()) == []


def test_without_minari_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "minari", None)
    with make() as env, pytest.raises(InputError, match=r"pip install 'sonarbed\[minari\]'"):
        record(env)
