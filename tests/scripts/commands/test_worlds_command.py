import json

import numpy as np
import pytest
from PIL import Image

import worlds


def test_the_list_has_every_room(run):
    table = run("worlds")
    told = json.loads(run("worlds --json"))
    assert [room["name"] for room in told] == list(worlds.names())
    for name in worlds.names():
        assert f" {name} " in table


def test_a_room_is_shown_with_its_parameters_and_what_is_assumed(run):
    shown = run("worlds opening-rig --set gap_m=0.6")
    room = worlds.load("opening-rig", gap_m=0.6)
    assert "gap_m = 0.6" in shown
    for solid in room.solids:
        assert solid.name in shown
    for where, note in room.notes.items():
        assert f"{where}: {note}" in shown


def test_the_json_of_a_room_is_the_room(run):
    told = json.loads(run("worlds opening-rig --set gap_m=0.6 --json"))
    room = worlds.load("opening-rig", gap_m=0.6)
    assert told["parameters"] == dict(room.parameters)
    assert told["bounds_m"] == list(room.bounds_m)
    assert told["start"]["x_m"] == room.start.x_m
    assert [solid["name"] for solid in told["solids"]] == [solid.name for solid in room.solids]


# One with many materials, one long, one with thin boards.
@pytest.mark.parametrize("name", ["clutter", "corridor", "opening-rig"])
def test_rooms_are_drawn(run, name):
    shown = run(f"worlds {name} --png pictures/room.png")
    assert "Drawn: pictures/room.png" in shown
    with Image.open("pictures/room.png") as image:
        assert image.format == "PNG"
        assert min(image.size) >= 400
        assert max(image.size) <= 1200
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    # Not blank, and in colour: the walls at least, and the start's blue.
    assert len(np.unique(pixels, axis=0)) > 50
    assert (pixels == (0x00, 0x72, 0xB2)).all(axis=1).sum() > 50


def test_a_file_of_ones_own_is_shown_and_drawn_in_spare_colours(run, tmp_path):
    (tmp_path / "mine.toml").write_text(OWN, encoding="utf-8")
    assert "mine: My room" in run("worlds mine.toml --png mine.png")
    with Image.open("mine.png") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    assert (pixels == (0xF0, 0xE4, 0x42)).all(axis=1).sum() > 1000


def test_a_file_is_shown_by_a_reader_of_ones_own(run, refused, tmp_path, monkeypatch):
    (tmp_path / "toy_yard.py").write_text(YARD, encoding="utf-8")
    (tmp_path / "yard.txt").write_text("1 2", encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    told = json.loads(run("worlds toy_yard:read:yard.txt --set size_m=5 --json"))
    assert told["bounds_m"] == [0, 0, 5, 5]
    assert told["solids"] == [{"name": "post", "material": "metal", "height_m": 1}]
    assert refused("worlds yard.txt") == (
        "yard.txt: no world reader for files that end in '.txt'; known: .toml"
    )


YARD = """\
from worlds import Solid, World


def read(path, *, size_m=4.0):
    centre_m = [float(word) for word in path.read_text().split()]
    post = Solid.pillar("post", centre_m, 0.1, height_m=1, material="metal")
    return World.of("yard", [post], bounds_m=(0, 0, size_m, size_m), start=(3, 3, 0))
"""


def test_tables_fit_a_narrow_terminal_and_are_whole_in_a_file(run, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    assert max(len(line) for line in run("worlds").splitlines()) <= 60
    monkeypatch.delenv("COLUMNS")
    table = run("worlds")
    for name in worlds.names():
        assert worlds.load(name).title in table


OWN = """\
title = "My room"
source = "a test"
bounds_m = [-0.2, -0.2, 3.2, 3.2]

[start]
x_m = 1.5
y_m = 1.5
heading_deg = 0

[materials.felt]
critical_incidence_deg = 60
reflectivity = 0.8
roughness_mm = 3

[[wall]]
name = "round"
points_m = [[0, 0], [3, 0], [3, 3], [0, 3]]
closed = true
side = "right"
thickness_m = 0.1
height_m = 1
material = "felt"
"""
