"""The engine that runs jobs: all of them, once, whatever happens."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from small_jobs import Write

from sim.runs.jobs import JobProgress, Processes, RemoteStore, open_store, run_jobs
from sonarmap.errors import InputError

TESTS = Path(__file__).parents[3]


def tree(folder):
    """Return the bytes of every file below a folder by its name."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.fixture
def store(tmp_path):
    return open_store(tmp_path / "out")


@pytest.mark.parametrize("workers", [1, 2])
def test_all_jobs_are_done_and_only_once(tmp_path, store, workers):
    diary = tmp_path / "diary"
    jobs = [Write(seed, diary=str(diary)) for seed in range(12)]
    heard = []
    with store.held():
        run_jobs(jobs[:5], store, workers=workers)
        report = run_jobs(
            iter(jobs), store, workers=workers, total=len(jobs), on_progress=heard.append
        )
    assert (report.done, report.skipped, report.failed, report.readings) == (12, 5, 0, 7000)
    assert heard[0] == JobProgress(0, 0, 0, 12, 0)
    assert heard[-1] == JobProgress(12, 5, 0, 12, 7000)
    assert sorted(diary.read_text().split(), key=int) == [str(seed) for seed in range(12)]
    assert set(tree(tmp_path / "out")) == {job.outputs[0] for job in jobs}


@pytest.mark.parametrize("workers", [1, 2])
def test_a_job_that_fails_is_reported_and_stops_nothing(store, workers):
    deeds = ["nothing", "refuse", "fail", "nothing"]
    jobs = [Write(seed, deed) for seed, deed in enumerate(deeds)]
    report = run_jobs(jobs, store, workers=workers)
    assert (report.done, report.failed) == (2, 2)
    refused, failed = report.failures
    assert (refused.label, refused.error, refused.details) == (
        "seed 0001",
        "scans must be >= 1, got 0",
        "",
    )
    assert refused.to_dict()["description"]["seed"] == 1
    assert failed.error == "ZeroDivisionError: by zero"
    assert "small_jobs.py" in failed.details


def test_a_worker_that_dies_loses_its_own_job_only_which_is_tried_again(tmp_path, store):
    diary = tmp_path / "diary"
    deeds = ["nothing", "die once", "die", *["nothing"] * 9]
    jobs = [Write(seed, deed, diary=str(diary)) for seed, deed in enumerate(deeds)]
    report = run_jobs(jobs, store, workers=2)
    assert (report.done, report.failed) == (11, 1)
    assert report.failures[0].label == "seed 0002"
    assert report.failures[0].error == "its worker died 2 times"
    begun = diary.read_text().split()
    assert {seed: begun.count(str(seed)) for seed in range(12) if begun.count(str(seed)) != 1} == {
        1: 2,
        2: 2,
    }


@pytest.mark.parametrize("workers", [1, 2])
def test_a_full_disk_ends_the_run_with_one_line(tmp_path, store, workers):
    deeds = ["nothing", "nothing", "fill", *["nothing"] * 200]
    jobs = [Write(seed, deed) for seed, deed in enumerate(deeds)]
    with pytest.raises(InputError, match="No space left on device; what was finished is kept"):
        run_jobs(jobs, store, workers=workers)
    assert 1 <= len(tree(tmp_path / "out")) < 100


def test_workers_have_one_thread_a_library_and_this_process_keeps_its_own(store, monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    run_jobs([Write(0)], store, workers=Processes(1))
    assert "OMP_NUM_THREADS" not in os.environ


def test_jobs_are_taken_as_there_are_hands_for_them(store):
    taken = []

    def jobs():
        for seed in range(50):
            taken.append(seed)
            yield Write(seed)

    def check(progress):
        assert len(taken) <= progress.done + 3

    run_jobs(jobs(), store, workers=2, on_progress=check)
    assert len(taken) == 50


def test_a_folder_is_written_by_one_process(tmp_path, store):
    with (
        store.held(),
        pytest.raises(InputError, match="out: another process is writing there"),
        store.held(),
    ):
        pass
    with store.held():
        pass
    assert tree(tmp_path) == {}


def test_what_a_killed_process_left_is_removed_and_nothing_else(tmp_path, store):
    ours = [".0003-abc_1234.parquet", ".x.y-zzzzzzzz"]
    others = [".bash-history", ".lock", "a-b", ".0003-abc_12345.parquet", "0003-abc_1234.parquet"]
    (tmp_path / "out" / "deep").mkdir(parents=True)
    for name in ours + others:
        (tmp_path / "out" / "deep" / name).touch()
    with store.held():
        assert len(tree(tmp_path / "out" / "deep")) == 7
        store.tidy()
    assert set(tree(tmp_path / "out")) == {f"deep/{name}" for name in others}


def test_a_file_in_the_way_is_no_folder(tmp_path):
    (tmp_path / "out").touch()
    with pytest.raises(InputError, match="out: must be a folder, but a file is in the way"):
        open_store(tmp_path / "out")


def test_an_empty_file_is_not_complete(tmp_path, store):
    job = Write(3)
    (tmp_path / "out" / "part=0").mkdir(parents=True)
    (tmp_path / "out" / job.outputs[0]).touch()
    assert run_jobs([job], store).skipped == 0
    assert store.has(job.outputs[0])


SCRIPT = """
import sys
from pathlib import Path
from small_jobs import Write
from sim.runs.jobs import open_store, run_jobs

if __name__ == "__main__":
    folder, diary, workers = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3])
    store = open_store(folder)
    with store.held():
        store.tidy()
        jobs = (Write(seed, diary=diary, seconds=0.02) for seed in range(24))
        report = run_jobs(jobs, store, workers=workers)
    print(report.done, report.skipped)
"""


def alive_with(word):
    """Return the numbers of processes whose command line or environment has a word."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/environ"):
        try:
            if word.encode() in entry.read_bytes():
                found.append(int(entry.parent.name))
        except OSError:
            continue
    return found


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="needs /proc")
@pytest.mark.parametrize("workers", [1, 2])
def test_killed_at_any_moment_it_goes_on_and_ends_the_same(tmp_path, workers):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    mark = f"mark-{os.getpid()}-{workers}"
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(TESTS), str(TESTS.parent)]),
        "SONARBED_TEST": mark,
    }
    diary = tmp_path / "diary"
    folder = tmp_path / "out"

    def begin():
        return subprocess.Popen(
            [sys.executable, script, folder, diary, str(workers)],
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )

    for wanted in (1, 5, 14):
        command = begin()
        deadline = time.monotonic() + 120
        while len([name for name in tree(folder) if "/." not in name]) < wanted:
            assert command.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.005)
        os.kill(command.pid, signal.SIGKILL)
        command.communicate()
        while alive_with(mark):  # nobody works on for a process that is gone
            assert time.monotonic() < deadline
            time.sleep(0.02)
    there = len([name for name in tree(folder) if "/." not in name and "/" in name])
    out, _ = begin().communicate(timeout=120)
    assert out == f"24 {there}\n"
    begun = [int(line) for line in diary.read_text().split()]
    # What was complete is not done again: only what was under way when a kill came.
    assert len(begun) <= 24 + 4 * workers
    diary.unlink()

    untouched = open_store(tmp_path / "other")
    run_jobs([Write(seed, diary=str(diary), seconds=0.02) for seed in range(24)], untouched)
    assert tree(folder) == tree(tmp_path / "other")


def test_files_go_to_any_fsspec_url(tmp_path):
    pytest.importorskip("fsspec", reason="fsspec is not installed")
    for url in ("memory://jobs", f"file://{tmp_path}/far"):
        store = open_store(url)
        assert isinstance(store, RemoteStore)
        with store.held():
            assert run_jobs([Write(0), Write(1)], store).done == 2
            report = run_jobs([Write(0), Write(1), Write(2, "fail")], store)
        assert (report.done, report.skipped, report.failed) == (2, 2, 1)
        with store.reading(Write(1).outputs[0]) as file:
            assert file.read() == b"1\n" * 1000
        store.remove(Write(1).outputs[0])
        assert not store.has(Write(1).outputs[0])
    assert set(tree(tmp_path / "far")) == {Write(0).outputs[0]}
