"""Drives are what their descriptions say: in names, in files, in memory."""

import os
import pickle
import shutil
from dataclasses import replace

import numpy as np
import pytest

import sim
import worlds
from sim.sonar.presets import preset
from sonarbed.reporting import drives as drives_module
from sonarbed.reporting.drives import DriveSpec, DriveStore, usual_driver
from sonarmap import AMIGOBOT, InputError

TINY = DriveSpec("thesis-exp1", scans=2, seed=0, driver="thesis", engine="segments")
PHYSICAL = preset("physical")

# Everything that may differ between two drives.
OTHERS = {
    "room": {"room": "office"},
    "scans": {"scans": 3},
    "seed": {"seed": 1},
    "driver": {"driver": "random"},
    "driver's own": {"driver": sim.ConstantSpeeds(0.1, 0.10000000000000002)},
    "sonar": {"sonar": "aria"},
    "sonar's own": {"sonar": PHYSICAL},
    "part of a sonar": {"sonar": PHYSICAL.replace(firing=sim.InTurn(0.05))},
    "ring": {"sonar": PHYSICAL.replace(ring=replace(AMIGOBOT, range_max_m=4.5))},
    "engine": {"engine": "bullet"},
    "packets": {"packets": sim.StatusPackets()},
    "delay": {"packets": sim.StatusPackets(delay_s=0.041)},
    "parameter": {"parameters": (("gap_m", 0.8),)},
    "last digit": {"parameters": (("gap_m", 0.80000001),)},
}


def test_other_drives_have_other_files():
    specs = [TINY, *(replace(TINY, **change) for change in OTHERS.values())]
    assert len({spec.file_name for spec in specs}) == len(set(specs)) == len(specs)


@pytest.mark.parametrize("change", OTHERS.values(), ids=OTHERS)
def test_a_spec_pickles_into_its_equal(change):
    spec = replace(TINY, **change)
    again = pickle.loads(pickle.dumps(spec))
    assert again == spec
    assert hash(again) == hash(spec)
    assert again.file_name == spec.file_name


def test_file_names_begin_with_what_people_look_for():
    assert TINY.file_name.startswith("thesis-exp1-thesis-thesis-2-0000-")
    spec = DriveSpec("office", scans=7, seed=12, driver=sim.RandomWander(), sonar=PHYSICAL)
    assert spec.file_name.startswith("office-randomwander-physical-7-0012-")


def test_another_version_makes_other_files(monkeypatch):
    before = TINY.file_name
    monkeypatch.setattr(drives_module, "version", lambda package: "99")
    assert replace(TINY).file_name != before


def test_of_a_rooms_file_the_content_counts(tmp_path):
    here, there = tmp_path / "a" / "hall.toml", tmp_path / "b" / "hall.toml"
    for file in (here, there):
        file.parent.mkdir()
        file.write_text("one")
    specs = [replace(TINY, room=str(file)) for file in (here, there)]
    assert specs[0] == specs[1]
    there.write_text("two")
    assert replace(specs[1]).file_name != specs[0].file_name
    assert specs[0].file_name.startswith("hall-")


def test_a_file_called_like_a_shipped_room_is_not_it(tmp_path, monkeypatch):
    before = TINY.file_name
    monkeypatch.chdir(tmp_path)
    (tmp_path / TINY.room).write_text("shopping list")
    assert replace(TINY).file_name == before


def test_what_cannot_be_described_is_refused():
    with pytest.raises(InputError, match="must be described by plain values, got <object"):
        replace(TINY, parameters=(("gap_m", object()),)).digest  # noqa: B018


def test_a_store_simulates_only_what_is_missing(tmp_path):
    store, heard = DriveStore(tmp_path), []
    specs = [TINY, replace(TINY, seed=1), TINY]
    store.simulate_missing(specs[:1])
    store.simulate_missing(specs, "hall", on_progress=lambda *news: heard.append(news))
    assert heard == [("hall", 0, 1), ("hall", 1, 1)]
    store.simulate_missing(specs, on_progress=lambda *news: heard.append(news))
    assert len(heard) == 2
    assert {path.name for path in tmp_path.iterdir()} == {spec.file_name for spec in specs}


def test_an_interrupted_store_goes_on_where_it_was(tmp_path):
    store, specs = DriveStore(tmp_path), [replace(TINY, seed=seed) for seed in range(3)]

    def stop(label, done, total):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        store.simulate_missing(specs, on_progress=stop)
    assert [store.path_of(spec).exists() for spec in specs] == [True, True, False]
    heard = []
    store.simulate_missing(specs, on_progress=lambda *news: heard.append(news))
    assert heard[-1] == ("driving", 1, 1)


def test_a_stored_log_is_the_simulated_one(tmp_path):
    store = DriveStore(tmp_path)
    spec = replace(TINY, sonar=PHYSICAL, packets=sim.StatusPackets(), scans=3)
    store.simulate_missing([spec])
    stored, simulated = store.log(spec), spec.simulate()
    assert stored.provenance["drive"] == simulated.provenance["drive"] == spec.description
    for name in stored.DTYPES:
        np.testing.assert_array_equal(getattr(stored, name), getattr(simulated, name))


def test_a_store_pickles_and_keeps_what_it_has_read(tmp_path):
    store = pickle.loads(pickle.dumps(DriveStore(tmp_path)))
    store.simulate_missing([TINY])
    drive = store.scorable(TINY)
    again = DriveStore(tmp_path).scorable(replace(TINY))
    assert drive.log is again.log
    assert drive.truth is again.truth
    assert drive.observable is again.observable


def test_a_file_that_was_made_again_is_read_again(tmp_path):
    store = DriveStore(tmp_path)
    store.simulate_missing([TINY])
    log, path = store.log(TINY), store.path_of(TINY)
    os.utime(path, ns=(0, path.stat().st_mtime_ns + 1))
    assert store.log(TINY) is not log


def test_scorable_drives_have_the_truth_of_their_room(tmp_path):
    spec = replace(TINY, room="opening-rig", driver="straight", parameters=(("gap_m", 1.2),))
    store = DriveStore(tmp_path)
    store.simulate_missing([spec])
    drive = store.scorable(spec, resolution_m=0.1)
    expected = worlds.truth(worlds.load("opening-rig", gap_m=1.2), resolution_m=0.1)
    np.testing.assert_array_equal(drive.truth.state, expected.state)
    np.testing.assert_array_equal(drive.observable, expected.observable(drive.log))


def test_another_drives_log_is_refused(tmp_path):
    store, other = DriveStore(tmp_path), replace(TINY, seed=1)
    store.simulate_missing([TINY])
    shutil.copy(store.path_of(TINY), store.path_of(other))
    with pytest.raises(InputError, match=r"parquet: must be the drive .*'seed': 1.*'seed': 0"):
        store.log(other)


def test_a_log_without_truth_is_refused(tmp_path):
    store = DriveStore(tmp_path)
    TINY.simulate().replace(truth=None).write(store.path_of(TINY))
    with pytest.raises(InputError, match=r"parquet: the log has no truth"):
        store.log(TINY)


def test_a_drive_that_is_not_here_is_one_clear_line(tmp_path):
    with pytest.raises(InputError, match=r"parquet: no such file"):
        DriveStore(tmp_path).log(TINY)


@pytest.mark.parametrize(("room", "driver"), [("office", "route"), ("thesis-exp1", "thesis")])
def test_the_usual_driver_follows_a_route_if_there_is_one(room, driver):
    assert usual_driver(room) == driver
