"""How many threads environments step with, and that it changes nothing they say."""

import multiprocessing
import subprocess
import sys
import threading
import time

import gymnasium
import numpy as np
import pytest
from sameness import assert_same

import sim  # noqa: F401  registers the environments
from sim.envs import threads
from sim.envs.registration import IDS
from sonarmap import InputError
from sonarmap import cores as counting

OPTIONS = {"world": ["office", "clutter"], "map_patch": 16}


def vector(name=IDS[0], robots=8, **options):
    return gymnasium.make_vec(name, num_envs=robots, **OPTIONS, **options)


def driven(env, steps=5):
    env.action_space.seed(0)
    told = [env.reset(seed=1)]
    return (*told, *(env.step(env.action_space.sample()) for _ in range(steps)))


@pytest.mark.parametrize("name", IDS)
def test_the_number_of_threads_changes_nothing(name):
    one = driven(vector(name, threads=1))
    assert_same(driven(vector(name, threads=2)), one)
    assert_same(driven(vector(name, threads="all")), one)


def test_one_place_decides(monkeypatch):
    monkeypatch.delenv(threads.SETTING, raising=False)
    cores = threads.usable_cores()
    assert cores >= 1
    assert threads.threads_for(None, 1) == threads.threads_for(None, 16) == 1
    assert threads.threads_for(None, 64) == cores
    assert threads.threads_for("all", 1) == cores
    assert threads.threads_for(3, 64) == 3
    monkeypatch.setenv(threads.SETTING, "5")
    assert threads.threads_for(None, 1) == threads.threads_for(None, 64) == 5
    assert threads.threads_for(2, 64) == 2
    monkeypatch.setenv(threads.SETTING, "all")
    assert threads.threads_for(None, 1) == cores
    monkeypatch.setenv(threads.SETTING, "")
    assert threads.threads_for(None, 1) == 1
    monkeypatch.delenv(threads.SETTING)
    # A process of a pool has neighbours.
    monkeypatch.setattr(multiprocessing, "parent_process", object)
    assert threads.threads_for(None, 64) == 1


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (0, "threads must be >= 1, got 0"),
        (1.5, "threads must be a whole number, got 1.5"),
        (True, "threads must be a number, got True"),
        ("some", "threads must be a whole number >= 1 or 'all', got 'some'"),
    ],
)
def test_other_numbers_are_refused(wanted, message):
    with pytest.raises(InputError, match=message):
        gymnasium.make(IDS[0], threads=wanted)


@pytest.mark.parametrize("setting", ["0", "-2", "many", "1.5"])
def test_so_are_other_settings(setting, monkeypatch):
    monkeypatch.setenv(threads.SETTING, setting)
    with pytest.raises(InputError, match="SONARBED_THREADS must be"):
        gymnasium.make(IDS[0])


@pytest.mark.parametrize(
    ("files", "cores"),
    [
        ({"cpu.max": "150000 100000"}, 2),
        ({"cpu.max": "max 100000"}, 64),
        ({"cpu/cpu.cfs_quota_us": "300000", "cpu/cpu.cfs_period_us": "100000"}, 3),
        ({"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, 64),
        ({"cpu.max": "50000 100000"}, 1),
        ({}, 64),
    ],
)
def test_a_container_has_its_share_of_the_cores(files, cores, tmp_path, monkeypatch):
    monkeypatch.setattr(counting, "_CGROUP", tmp_path)
    monkeypatch.setattr("os.sched_getaffinity", lambda pid: range(64), raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: 64)
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(f"{text}\n")
    assert threads.usable_cores() == cores


@pytest.mark.parametrize("count", [0, 1, 2, 7, 64, 1000])
@pytest.mark.parametrize("number", [1, 2, 5, 200])
def test_parts_make_the_whole(count, number):
    done, parts = np.zeros(count, int), []

    def work(begin, end, part):
        done[begin:end] += 1
        parts.append(part)

    threads.in_parts(work, count, number)
    assert (done == 1).all()
    assert sorted(parts) == list(range(len(parts)))
    assert len(parts) <= threads.PARTS


@pytest.mark.parametrize("fails", range(8))
def test_a_part_that_fails_fails_the_whole_when_the_others_have_ended(fails):
    under_way = []

    def work(begin, end, part):
        under_way.append(part)
        time.sleep(0.001)
        under_way.remove(part)
        if part == fails:
            raise ValueError(f"part {part}")

    with pytest.raises(ValueError, match=f"part {fails}"):
        threads.in_parts(work, 100, 2)
    assert not under_way


def test_a_thread_that_does_not_come_is_not_waited_for():
    begin, end = threading.Event(), threading.Event()

    def busy():
        begin.set()
        end.wait()

    held = threads._pool(1).submit(busy)
    begin.wait()
    done = np.zeros(100, int)

    def work(begin, end, part):
        done[begin:end] += 1

    threads.in_parts(work, 100, 2)
    end.set()
    held.result()
    assert (done == 1).all()


FORKED = """
import multiprocessing, sys
import gymnasium, numpy as np, sim
def work(seed):
    made = []
    for name in ("Explore", "Navigate", "FollowWall"):
        envs = gymnasium.make_vec(f"sonarbed/{name}-v1", num_envs=8, threads="all", map_patch=16)
        envs.reset(seed=seed)
        envs.step(np.zeros((8, 2), np.float32))
        made.append(float(envs.step(np.full((8, 2), 0.5, np.float32))[1].sum()))
    return made
if __name__ == "__main__":
    # By a call of its own, too, not by an environment of ours alone.
    import numba
    numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
    here = work(1)
    kept = gymnasium.make_vec("sonarbed/Explore-v1", num_envs=8, threads="all")
    kept.reset(seed=4)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        there = pool.apply_async(work, [1]).get(timeout=100)
        # What was made before the fork steps there as well.
        pool.apply_async(kept.step, [np.zeros((8, 2), np.float32)]).get(timeout=100)
    print(here == there)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="forks as only Linux does")
def test_a_forked_process_does_the_same(tmp_path):
    script = tmp_path / "forked.py"
    script.write_text(FORKED)
    told = subprocess.run(
        [sys.executable, "-W", "ignore", str(script)],
        check=True, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert told.stdout.strip() == "True"


def test_gymnasiums_processes_do_the_same():
    env = vector(robots=2, vectorization_mode="async")
    expected = driven(vector(robots=2))
    for one, other in zip(driven(env), expected, strict=True):
        assert_same(one[0], other[0])
    env.close()
