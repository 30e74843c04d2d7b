"""Data sets: whole after any interruption, one table for every reader, nothing lost."""

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow.dataset as pds
import pyarrow.parquet as pq
import pytest
from tiny_datasets import as_toml, tiny, tiny_spec, tree

import sim.datasets.rooms
import sonarmap as sm
import worlds
from sim.datasets import make_dataset
from sim.datasets.logs import LogJob
from sim.runs.jobs import Processes
from sonarmap.errors import InputError

TESTS = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The small data set, in one process."""
    folder = tmp_path_factory.mktemp("made") / "tiny"
    report = make_dataset(tiny_spec(), folder)
    return SimpleNamespace(folder=folder, report=report)


def test_what_is_there(made):
    names = set(tree(made.folder))
    logs = {name for name in names if name.startswith("logs/")}
    assert names - logs == {
        "dataset.json",
        "manifest.parquet",
        "croissant.json",
        *(f"rooms/{room}.toml" for room in ("office", "thesis-exp1", "l-shape")),
    }
    assert len(logs) == made.report.logs.done == 3 * 2 * 2
    assert made.report.failures == []
    assert sum(name.startswith("logs/split=test/room=office/") for name in logs) == 4
    # The rooms are those that were driven in.
    stored = (made.folder / "rooms" / "office.toml").read_bytes()
    assert stored == (Path(worlds.__file__).parent / "rooms" / "office.toml").read_bytes()


def test_a_log_is_a_log_and_can_be_taken_again_from_its_row(made):
    row = pq.read_table(made.folder / "manifest.parquet").to_pylist()[0]
    log = sm.read_log(made.folder / row["file"])
    settings = json.loads(row["settings"])
    again = sim.simulate(
        worlds.load(made.folder / "rooms" / f"{row['room']}.toml"),
        scans=row["scans"],
        seed=row["seed"],
        driver=row["driver"],
        sonar=sim.sonar.presets.preset("aria").randomised(
            1.0, sim.Air(temperature_c=settings["air.temperature_c"])
        ),
        engine=row["engine"],
    )
    for name in log.DTYPES:
        np.testing.assert_array_equal(getattr(log, name), getattr(again, name))
    assert log.provenance["dataset"]["digest"] == row["digest"]


def columns_of(table):
    return {name: np.asarray(table.column(name).to_pylist()) for name in table.column_names}


def test_all_logs_are_one_table(made):
    table = pds.dataset(made.folder / "logs", partitioning="hive").to_table(
        columns=["log", "split", "room", "truth_cause", "range_m"]
    )
    columns = columns_of(table)
    rows = pq.read_table(made.folder / "manifest.parquet").to_pylist()
    for row in rows:
        mine = columns["log"] == row["log"]
        assert mine.sum() == row["readings"]
        assert set(columns["room"][mine]) == {row["room"]}
        assert set(columns["split"][mine]) == {row["split"]}
        counts = np.bincount(columns["truth_cause"][mine], minlength=len(sm.Cause))
        assert [row[cause.name.lower()] for cause in sm.Cause] == counts.tolist()
    assert sum(row["readings"] for row in rows) == table.num_rows
    assert sum(made.report.summary.readings.values()) == table.num_rows


@pytest.mark.parametrize("reader", ["pandas", "polars", "duckdb"])
def test_other_readers_see_one_table(made, reader):
    module = pytest.importorskip(reader, reason=f"{reader} is not installed")
    pattern = f"{made.folder}/logs/**/*.parquet"
    total = sum(made.report.summary.readings.values())
    if reader == "pandas":
        frame = module.read_parquet(made.folder / "logs")
        assert (len(frame), frame.log.nunique(), set(frame.split)) == (total, 12, {"train", "test"})
    elif reader == "polars":
        frame = module.scan_parquet(pattern, hive_partitioning=True).collect()
        assert (len(frame), frame["log"].n_unique()) == (total, 12)
    else:
        query = "select count(*), count(distinct log), count(distinct room) from"
        found = module.sql(f"{query} read_parquet('{pattern}', hive_partitioning=true)").fetchall()
        assert found == [(total, 12, 3)]


def test_croissant_is_valid(made):
    pytest.importorskip("mlcroissant", reason="mlcroissant is not installed")
    # In a process of its own: what it imports warns.
    script = (
        "import sys, mlcroissant\n"
        "found = mlcroissant.Dataset(sys.argv[1])\n"
        "assert not found.metadata.issues.errors\n"
        "print(next(iter(found.records('log')))['log/room'].decode())\n"
        "print(next(iter(found.records('reading')))['reading/scan'])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, made.folder / "croissant.json"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == ["office", "0"]


def test_two_processes_make_the_same_files(made, tmp_path):
    make_dataset(tiny_spec(), tmp_path / "out", workers=Processes(2))
    assert tree(tmp_path / "out") == tree(made.folder)


def test_a_second_run_takes_nothing_and_mends_what_was_removed(made, tmp_path):
    folder = tmp_path / "out"
    make_dataset(tiny_spec(), folder)
    before = {path: path.stat().st_mtime_ns for path in (folder / "logs").rglob("*.parquet")}
    report = make_dataset(tiny_spec(), folder)
    assert (report.logs.done, report.logs.skipped) == (12, 12)
    gone, *kept = sorted(before)
    gone.unlink()
    report = make_dataset(tiny_spec(), folder)
    assert (report.logs.done, report.logs.skipped) == (12, 11)
    assert all(path.stat().st_mtime_ns == before[path] for path in kept)
    assert tree(folder) == tree(made.folder)


def test_a_folder_of_another_data_set_is_refused(made, tmp_path):
    before = tree(made.folder)
    for changes, message in [
        ({"logs__seeds": 3}, 'has another data set: seeds is "0:2", asked for "0:3"'),
        ({"logs__air": {"temperature_c": 20}}, "logs.air.temperature_c"),
        ({"seed": 1}, "seed is 0, asked for 1"),
    ]:
        with pytest.raises(InputError, match=message):
            make_dataset(tiny_spec(**changes), made.folder)
    # Words about it may change.
    make_dataset(tiny_spec(description="Another word."), made.folder)
    make_dataset(tiny_spec(), made.folder)
    assert tree(made.folder) == before
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(InputError, match=r"must be new or empty, but has 'thesis\.txt'"):
        make_dataset(tiny_spec(), tmp_path)
    assert set(tree(tmp_path)) == {"thesis.txt"}
    with pytest.raises(InputError, match="must be a folder, but a file is in the way"):
        make_dataset(tiny_spec(), tmp_path / "thesis.txt")


NO_PLACE = """
title = "A box that is too small"
source = "made for this test"
bounds_m = [-1, -1, 1, 1]
[start]
x_m = 0.0
y_m = 0.0
heading_deg = 0
[[wall]]
name = "wall"
points_m = [[-0.15, -0.15], [0.15, -0.15], [0.15, 0.15], [-0.15, 0.15]]
closed = true
side = "right"
thickness_m = 0.05
height_m = 1.0
material = "wood"
"""


def test_a_room_without_a_place_fails_alone(tmp_path):
    (tmp_path / "small.toml").write_text(NO_PLACE)
    (tmp_path / "broken.toml").write_text("title = 3")
    heard = []
    spec = tiny_spec(rooms__files=["*.toml"], logs__start="anywhere")
    report = make_dataset(spec, tmp_path / "out", folder=tmp_path, on_progress=heard.append)
    assert (report.logs.done, report.logs.failed, report.without_room) == (12, 0, 8)
    broken, small = report.failures
    assert broken.label == "room broken"
    assert f"{tmp_path}/broken.toml: " in broken.error
    assert "room 'small' has no place for a robot of 0.18 m radius at its start" in small.error
    lines = (tmp_path / "out" / "failures.jsonl").read_text().splitlines()
    assert [json.loads(line)["job"] for line in lines] == ["room broken", "room small"]
    assert heard[-1].phase == "manifest"
    # Once it is mended, its logs are taken: a new folder, for it is another room.
    with pytest.raises(InputError, match="has another data set: rooms"):
        make_dataset(tiny_spec(logs__start="anywhere"), tmp_path / "out", folder=tmp_path)


def test_a_log_that_fails_is_reported_with_its_seed(tmp_path, made):
    # The route driver has no route in this room.
    spec = tiny_spec(rooms={"names": ["office", "round-room"]}, logs__driver=["route", "wander"])
    report = make_dataset(spec, tmp_path / "out")
    rows = pq.read_table(tmp_path / "out" / "manifest.parquet").to_pylist()
    assert len(rows) == report.logs.done
    if report.logs.failed:
        failure = report.failures[0]
        assert failure.label.startswith("room round-room, log 0000")
        assert failure.description["seed"] > 0
        assert "needs route_m" in failure.error


def test_a_full_disk_is_one_line_and_the_rest_is_kept(tmp_path, monkeypatch, made):
    folder, run, count = tmp_path / "out", LogJob.run, []

    def full(self, store):
        count.append(self)
        if len(count) > 5:
            with store.writing(self.outputs[0]):
                raise OSError(errno.ENOSPC, "No space left on device")
        return run(self, store)

    monkeypatch.setattr(LogJob, "run", full)
    with pytest.raises(InputError, match="No space left on device; what was finished is kept"):
        make_dataset(tiny_spec(), folder)
    assert len(list((folder / "logs").rglob("*.parquet"))) == 5
    monkeypatch.undo()
    make_dataset(tiny_spec(), folder)
    assert tree(folder) == tree(made.folder)


def test_generated_rooms(tmp_path, monkeypatch):
    office = (Path(worlds.__file__).parent / "rooms" / "office.toml").read_text()

    class Generator:
        @staticmethod
        def style(name):
            if name != "office":
                raise InputError(f"style {name!r} is unknown")

        @staticmethod
        def plan(style, seed):
            return SimpleNamespace(to_toml=lambda: f"# {style} {seed}\n{office}")

    monkeypatch.setattr(sim.datasets.rooms, "import_module", lambda name: Generator)
    rooms = {"generate": [{"style": "office", "seeds": "5:9"}]}
    report = make_dataset(tiny_spec(rooms=rooms, splits={}), tmp_path / "out")
    assert report.summary.logs.total() == 4 * 4
    names = [path.name for path in sorted((tmp_path / "out" / "rooms").iterdir())]
    assert names == [f"office-000{seed}.toml" for seed in range(5, 9)]
    rooms["generate"][0]["style"] = "ofice"
    with pytest.raises(InputError, match=r"rooms.generate\[0\]: style 'ofice' is unknown"):
        make_dataset(tiny_spec(rooms=rooms, splits={}), tmp_path / "out")


def test_random_starts_can_be_reached_and_differ(tmp_path):
    spec = tiny_spec(rooms={"names": ["office"]}, logs__start="anywhere", logs__seeds=8)
    make_dataset(spec, tmp_path / "out")
    world = worlds.load("office")
    starts = set()
    for path in (tmp_path / "out" / "logs").rglob("*.parquet"):
        truth = sm.read_log(path).truth
        x_m, y_m = truth.x_m[0], truth.y_m[0]
        assert world.has_room_at(x_m, y_m, radius_m=0.2)
        assert 0 < x_m < 8
        assert -1.2 < y_m < 6
        starts.add((x_m, y_m))
    assert len(starts) == 16


SCRIPT = """
import sys
from sim.datasets import make_dataset
if __name__ == "__main__":
    make_dataset(sys.argv[1], sys.argv[2], workers=int(sys.argv[3]))
"""


@pytest.mark.parametrize(("workers", "points"), [(1, (0, 1, 4, 8)), (2, (1, 6))])
def test_killed_at_several_points_it_ends_the_same(made, tmp_path, workers, points):
    (tmp_path / "spec.toml").write_text(as_toml(tiny()))
    (tmp_path / "script.py").write_text(SCRIPT)
    folder = tmp_path / "out"
    paths = [str(TESTS), str(TESTS.parent), os.environ.get("PYTHONPATH", "")]
    command = [sys.executable, "script.py", "spec.toml", "out", str(workers)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}

    def finished():
        return [path for path in folder.glob("logs/*/*/*") if not path.name.startswith(".")]

    for wanted in points:
        process = subprocess.Popen(command, cwd=tmp_path, env=environment)
        deadline = time.monotonic() + 120
        while not (folder.exists() and len(finished()) >= wanted):
            if process.poll() is not None:  # it was quicker than we looked
                break
            assert time.monotonic() < deadline
            time.sleep(0.002)
        process.send_signal(signal.SIGKILL)
        process.wait()
    subprocess.run(command, cwd=tmp_path, env=environment, check=True)
    assert tree(folder) == tree(made.folder)


def test_files_go_to_a_url(made):
    fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed")
    make_dataset(tiny_spec(), "memory://tiny")
    files = fsspec.filesystem("memory")
    there = {path.removeprefix("/tiny/"): files.cat(path) for path in files.find("/tiny")}
    assert there == tree(made.folder)
    window = sm.SonarDataset("memory://tiny", split="test", window=8)[0]
    assert window["range_m"].shape == (8,)
