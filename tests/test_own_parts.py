"""The examples of CONTRIBUTING.md: a toy of each part, one file from outside of the packages."""

import re
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from support import make_log

import sonarmap as sm
import worlds
from sonarbed.cli import main

TEXT = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def parts(tmp_path, monkeypatch):
    """Write each example under the name that its first line gives it, and run from there."""
    monkeypatch.chdir(tmp_path)
    # Python does not import a module of one name twice.
    for name in list(sys.modules):
        if name.startswith("my_"):
            monkeypatch.delitem(sys.modules, name)
    latest = None
    for block in re.findall(r"^```python\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL):
        named = re.match(r"# (my_\w+\.py)", block)
        latest = Path(named.group(1)) if named else latest
        with latest.open("a", encoding="utf-8") as file:
            file.write(block)
    make_log([1.0, 2.5, 1.5], ring=sm.AMIGOBOT).write("log.parquet")


def run(line):
    assert main(line.split()) == 0, line


def test_a_mapping_method():
    run("map log.parquet --method my_mapper:six_percent --out map")
    assert (sm.read_map("map").probability == 0.06).all()


def test_a_reading_filter():
    run("filter log.parquet --method my_filter:short --out filtered.parquet")
    assert sm.read_log("filtered.parquet").rejected.tolist() == [False, True, False]
    run("map log.parquet --filter my_filter:short --out map")


def test_a_world_reader():
    Path("yard.posts").write_text("1 1\n2 3\n")
    run("worlds my_rooms:read_posts:yard.posts --set size_m=5")
    world = worlds.load("my_rooms:read_posts:yard.posts")
    assert [solid.name for solid in world.solids] == ["post 0", "post 1"]


def test_a_log_importer_and_an_exporter():
    np.savetxt("robot.txt", [[0, 0, 0, 0, 1.25], [1, 0.1, 0, 0, 1.5]])
    run("import robot.txt --format my_robot:read --ring amigobot --out read.parquet")
    assert sm.read_log("read.parquet").range_m.tolist() == [1.25, 1.5]
    run("export read.parquet --to ranges.txt --format my_robot:write")
    assert np.loadtxt("ranges.txt").tolist() == [[0, 1.25], [1, 1.5]]


def test_a_sonar_and_a_driver():
    run(
        "simulate office --sonar my_sonar:WIDE --driver my_driver:Spin --engine segments "
        "--scans 3 --out drive.parquet"
    )
    log = sm.read_log("drive.parquet")
    assert log.provenance["sonar"]["max_bounces"] == 3
    assert len(log) == 24
    assert np.ptp(log.truth.x_m) < 0.01  # it turns on the spot


def test_an_environment_task(monkeypatch):
    monkeypatch.syspath_prepend(Path.cwd())
    env = gymnasium.make("sim:sonarbed/Task-v0", task="my_task:Hurry")
    env.reset(seed=0)
    _, reward, *_, info = env.step(np.array([1.0, 0.0], np.float32))
    assert reward == pytest.approx(info["reward_terms"]["speed"])
    assert reward > 0
    assert env.spec.max_episode_steps == 300
    env.close()


def test_every_group_of_entry_points_has_an_example():
    groups = set(re.findall(r"`(sonarbed\.\w+)`\)", TEXT))
    assert groups == {
        "sonarbed.methods",
        "sonarbed.filters",
        "sonarbed.world_readers",
        "sonarbed.importers",
        "sonarbed.exporters",
        "sonarbed.sonar_presets",
        "sonarbed.drivers",
        "sonarbed.tasks",
        "sonarbed.room_styles",
    }
