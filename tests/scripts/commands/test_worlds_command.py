import json
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

import worlds
from sonarbed.cli import main


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


# The commands below `worlds`.

BELOW = ("generate", "check", "materials", "list")


@pytest.mark.parametrize("command", BELOW)
def test_every_command_below_has_help_with_an_example(run, command, monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    text = run(f"worlds {command} --help")
    assert f"Usage: sonarbed worlds {command}" in text
    assert "Example" in text
    assert f"sonarbed worlds {command}" in text.split("Example")[1]
    assert command in run("worlds --help")


def test_help_below_loads_nothing_heavy():  # in a fresh process
    heavy = ["numpy", "scipy", "numba", "pyarrow", "matplotlib", "shapely", "PIL"]
    script = (
        "import sys\n"
        "from sonarbed.cli import main\n"
        f"for name in {BELOW}:\n"
        "    assert main(['worlds', name, '--help']) == 0\n"
        f"loaded = [name for name in {heavy} if name in sys.modules]\n"
        "sys.exit(f'loaded: {loaded}' if loaded else 0)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_list_is_the_list(run):
    assert run("worlds list") == run("worlds")
    assert run("worlds list --json") == run("worlds --json")


def test_a_room_that_is_called_as_a_command_is_shown_by_its_path(run, tmp_path):
    for name in ("check", "generate"):
        (tmp_path / name).write_text(OWN, encoding="utf-8")
        assert f"{name}: My room" in run(f"worlds ./{name}")


def test_materials_are_listed_with_their_numbers(run):
    table = run("worlds materials")
    told = json.loads(run("worlds materials --json"))
    assert list(told) == sorted(worlds.MATERIALS)
    for name, material in worlds.MATERIALS.items():
        assert f" {name} " in table
        assert told[name]["roughness_mm"] == pytest.approx(material.roughness_m * 1000)
    assert told["glass"]["critical_incidence_deg"] == 18
    assert "18° │  0.2 dB" in table


def test_rooms_are_generated_as_files(run, tmp_path):
    assert run("worlds generate --style office --seed 3:6 --out rooms") == (
        "3 rooms: rooms/office-0003.toml to office-0005.toml\n"
    )
    files = sorted((tmp_path / "rooms").iterdir())
    assert [path.name for path in files] == [f"office-000{i}.toml" for i in (3, 4, 5)]
    for seed, path in enumerate(files, 3):
        assert worlds.load(path) == worlds.generate("office", seed)
        assert path.read_bytes() == worlds.plan("office", seed).to_toml().encode()
    assert "office-0003: Rooms with doors" in run("worlds rooms/office-0003.toml")


def test_what_is_there_and_the_same_stays_and_anything_else_is_refused(run, refused, tmp_path):
    run("worlds generate --style room --seed 1 --out rooms")
    path = tmp_path / "rooms" / "room-0001.toml"
    before = path.stat().st_ino, path.stat().st_mtime_ns
    run("worlds generate --style room --seed 0:3 --out rooms")
    assert (path.stat().st_ino, path.stat().st_mtime_ns) == before
    path.write_text("mine", encoding="utf-8")
    assert refused("worlds generate --style room --seed 0:3 --out rooms") == (
        "rooms/room-0001.toml: another file is there already: remove it, or another --out"
    )
    assert path.read_text(encoding="utf-8") == "mine"
    path.unlink()
    path.mkdir()
    assert "is a folder" in refused("worlds generate --style room --seed 0:3 --out rooms")


def test_parameters_and_the_robots_size_reach_the_rooms(run):
    run(
        "worlds generate --style office --seed 2 --out wide --robot-radius 0.25 "
        "--param door_min_m=1.1 --param door_max_m=1.3 --param wall_materials=brick:1,plaster:2"
    )
    expected = worlds.generate(
        "office",
        2,
        robot_radius_m=0.25,
        door_min_m=1.1,
        door_max_m=1.3,
        wall_materials="brick:1,plaster:2",
    )
    assert worlds.load("wide/office-0002.toml") == expected


def test_a_sheet_of_all_styles_is_drawn(run):
    shown = run("worlds generate --style all --seed 0:2 --png sheet.png --json")
    assert json.loads(shown) == {"files": [], "png": "sheet.png"}
    with Image.open("sheet.png") as image:
        assert min(image.size) >= 400
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(pixels, axis=0)) > 50


def test_check_says_what_is_doubtful(run, tmp_path):
    (tmp_path / "mine.toml").write_text(OWN, encoding="utf-8")
    assert run("worlds check corridor mine.toml") == (
        "corridor: nothing to say against it\nmine.toml: nothing to say against it\n"
    )
    near = OWN.replace("y_m = 1.5", "y_m = 0.1").replace("height_m = 1\n", "height_m = 100\n")
    (tmp_path / "near.toml").write_text(near, encoding="utf-8")
    shown = run("worlds check near.toml")
    assert "near.toml: doubtful: start: the robot meets 'round', 0.10 m away" in shown
    assert "near.toml: doubtful: round: height_m 100: are those metres?" in shown
    assert "start" not in run("worlds check near.toml --robot-radius 0.05")
    (told,) = json.loads(run("worlds check near.toml --json"))
    assert (told["file"], told["error"]) == ("near.toml", None)
    assert {doubt["rule"] for doubt in told["doubts"]} == {"start", "height"}


def test_check_tells_of_all_files_and_ends_with_the_error(capsys, tmp_path):
    (tmp_path / "bad.toml").write_text(OWN.replace("felt]", "felts]"), encoding="utf-8")
    assert main(["worlds", "check", "gone.toml", "corridor", "bad.toml"]) == 2
    out, err = capsys.readouterr()
    assert err == "sonarbed: gone.toml: no such file (and 1 more with errors)\n"
    assert "corridor: nothing to say against it" in out
    assert "wrong: bad.toml: wall[0].material: unknown material 'felt'" in out
    assert main(["worlds", "check", "bad.toml", "--json"]) == 2
    out, err = capsys.readouterr()
    (told,) = json.loads(out)
    assert told["error"].startswith("bad.toml: wall[0].material")
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("generate", "Missing option '--style'"),
        ("generate --style office", "--out DIR is missing: where to write the rooms"),
        ("generate --style offise --out r", "style 'offise' is unknown; did you mean 'office'?"),
        ("generate --style x:y --out r", "style 'x:y' cannot be imported"),
        ("generate --style office --seed -1 --out r", "--seed must be a whole number >= 0 or"),
        ("generate --style office --seed 1.5 --out r", "--seed must be a whole number >= 0 or"),
        ("generate --style office --seed 5:5 --out r", "must be 1 to 1000000 seeds, got '5:5': 0"),
        ("generate --style office --seed 0:9999999 --out r", "must be 1 to 1000000 seeds"),
        ("generate --style office --out file", "file: cannot be made a folder: a file is in the"),
        ("generate --style office --png a.jpg", "a.jpg: the file's name must end with .png"),
        ("generate --style office --param door --out r", "--param must be NAME=VALUE, got 'door'"),
        (
            "generate --style office --param door=1 --out r",
            "style 'office' has no parameter 'door'",
        ),
        ("generate --style office --param rooms_max=x --out r", "must be a whole number, got 'x'"),
        ("generate --style office --param door_max_m=.1 --out r", "door_min_m must be <= door_max"),
        ("generate --style all --param height_m=2 --out r", "--param needs one --style, got 10"),
        ("generate --style office --robot-radius -1 --out r", "robot_radius_m must be > 0, got -1"),
        ("check", "Missing argument 'FILE...'"),
        ("check offise", "unknown world 'offise'; did you mean 'office'?"),
        ("check office --robot-radius 0", "--robot-radius must be > 0, got 0.0"),
        ("materials wood", "unexpected extra argument"),
        ("list office", "unexpected extra argument"),
    ],
)
def test_bad_lines_below_are_refused(refused, tmp_path, line, complaint):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert complaint in refused(f"worlds {line}")
    assert not (tmp_path / "r").exists() or not list((tmp_path / "r").iterdir())
