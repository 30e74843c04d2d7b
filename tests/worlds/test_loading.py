import math
import re

import pytest

import worlds
from sonarmap import InputError

ROOM = """
title = "a room"
source = "made by hand"
bounds_m = [-1, -1, 5, 4]
route_m = [[3.0, 1.0]]
notes = { bounds_m = "assumed" }

[start]
x_m = 1.0
y_m = 1.0
heading_deg = 90
notes = { heading_deg = "faces north" }

[parameters]
gap_m = 0.5
depth_m = { default = 1.0, minimum = 0.5, maximum = 2.0, notes = { default = "assumed" } }
notes = { gap_m = "a cat fits through" }

[materials.felt]
critical_incidence_deg = 45
reflectivity = 0.5
roughness_mm = 2
notes = { reflectivity = "assumed" }

[[wall]]
name = "room"
points_m = [[0, 0], [4, 0], [4, 3], [0, 3]]
closed = true
side = "right"
thickness_m = 0.1
height_m = 2.5
material = "brick"
notes = { thickness_m = "half a brick" }

[[wall]]
name = "screen"
points_m = [[2, "= 2 + gap_m"], [2, 3]]
thickness_m = 0.05
height_m = 1.5
material = "felt"

[[box]]
name = "desk"
centre_m = [3.5, 2.0]
size_m = ["= depth_m", 0.6]
heading_deg = 90
height_m = 0.7
material = "wood"

[[pillar]]
name = "post"
centre_m = [3.0, 0.5]
radius_m = 0.1
height_m = 2.5
material = "metal"
"""


@pytest.fixture
def load_text(tmp_path):
    def load(text, **parameters):
        path = tmp_path / "room.toml"
        path.write_text(text, encoding="utf-8")
        return worlds.load(path, **parameters)

    return load


def test_every_key_of_a_file_reaches_the_world(load_text):
    world = load_text(ROOM)
    assert (world.name, world.title, world.source) == ("room", "a room", "made by hand")
    assert world.bounds_m == (-1, -1, 5, 4)
    assert world.start == worlds.Pose(1.0, 1.0, math.pi / 2)
    assert world.route_m == ((3.0, 1.0),)
    assert [solid.name for solid in world.solids] == ["room", "screen", "desk", "post"]
    assert [solid.height_m for solid in world.solids] == [2.5, 1.5, 0.7, 2.5]
    room, screen, desk, post = world.solids
    assert room.material is worlds.MATERIALS["brick"]
    assert room.outline.bounds == pytest.approx((-0.1, -0.1, 4.1, 3.1))
    assert screen.material == worlds.Material("felt", math.pi / 4, 0.5, 0.002)
    assert screen.outline.bounds == pytest.approx((1.975, 2.5, 2.025, 3.0))
    assert desk.outline.bounds == pytest.approx((3.2, 1.5, 3.8, 2.5))
    assert post.circle == (3.0, 0.5, 0.1)


def test_notes_are_found_by_the_place_of_their_number(load_text):
    assert load_text(ROOM).notes == {
        "bounds_m": "assumed",
        "start.heading_deg": "faces north",
        "wall[0].thickness_m": "half a brick",
        "materials.felt.reflectivity": "assumed",
        "parameters.gap_m": "a cat fits through",
        "parameters.depth_m.default": "assumed",
    }


def test_parameters_replace_their_defaults(load_text):
    world = load_text(ROOM, gap_m=0.75, depth_m=2)
    assert world.parameters == {"gap_m": 0.75, "depth_m": 2.0}
    assert world.solids[1].outline.bounds[1] == 2.75
    assert world.solids[2].outline.bounds[1::2] == (1.0, 3.0)


PLAIN = """
title = "plain"
source = ""
bounds_m = [0, 0, 1, 1]
start = { x_m = 0.5, y_m = 0.5, heading_deg = 0 }
"""
POST = """
[[pillar]]
name = "post"
centre_m = [0.2, 0.2]
radius_m = 0.05
height_m = 1
material = "wood"
"""


def test_a_file_may_do_without_everything_but_its_start_bounds_and_a_solid(load_text):
    world = load_text(PLAIN + POST)
    assert [solid.name for solid in world.solids] == ["post"]
    assert (world.route_m, dict(world.parameters)) == ((), {})
    assert world.faces.segments_m.shape == (0, 4)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (PLAIN, "wall: a room must have a wall, a box or a pillar, got none"),
        (
            PLAIN.replace("[0, 0, 1, 1]", "[0, 0, 5000, 4000]") + POST,
            "bounds_m: must be metres, at most 1000 a side, got 5000",
        ),
        (
            PLAIN.replace("[0, 0, 1, 1]", "[-180, -1e7, 180, 1e7]") + POST,
            "bounds_m: must be metres, at most 1000 a side, got 2e+07",
        ),
    ],
)
def test_what_cannot_be_a_room_is_refused(load_text, text, complaint):
    with pytest.raises(InputError, match=re.escape(complaint)):
        load_text(text)


@pytest.mark.parametrize(
    "encoded",
    [
        lambda text: b"\xef\xbb\xbf" + text.encode(),
        lambda text: text.encode("utf-16"),
        lambda text: b"\xfe\xff" + text.encode("utf-16-be"),
        lambda text: text.replace("\n", "\r\n").encode(),
    ],
)
def test_a_file_may_be_saved_by_notepad_or_powershell(encoded, tmp_path):
    path = tmp_path / "room.toml"
    path.write_bytes(encoded(PLAIN + POST))
    assert worlds.load(path).title == "plain"


def test_a_rooms_own_material_goes_before_a_preset_of_its_name(load_text):
    world = load_text(ROOM.replace("felt", "wood"))
    assert world.solids[2].material.critical_incidence_rad == math.pi / 4


# What stands in the file, what stands there instead, and what is said about it.
FAULTS = [
    # keys
    (
        "thickness_m = 0.1",
        "thicknes_m = 0.1",
        r"wall[0].thicknes_m: unknown key; did you mean 'thickness_m'?",
    ),
    ("[[pillar]]", "[[pilar]]", "pilar: unknown key; did you mean 'pillar'?"),
    (
        "roughness_mm = 2",
        "roughness_m = 2",
        "materials.felt.roughness_m: unknown key; did you mean 'roughness_mm'?",
    ),
    (
        "heading_deg = 90\nnotes",
        "heading_rad = 1\nnotes",
        "start.heading_rad: unknown key; did you mean 'heading_deg'?",
    ),
    (
        "minimum = 0.5",
        "minimun = 0.5",
        "parameters.depth_m.minimun: unknown key; did you mean 'minimum'?",
    ),
    ("thickness_m = 0.05\n", "", "wall[1].thickness_m: this key is missing"),
    ("y_m = 1.0\n", "", "start.y_m: this key is missing"),
    ("bounds_m = [-1, -1, 5, 4]\n", "", "bounds_m: this key is missing"),
    # types
    ('title = "a room"', "title = 7", "title: must be a text, got 7"),
    (
        'material = "brick"',
        'material = ["brick"]',
        "wall[0].material: must be a text, got ['brick']",
    ),
    ("closed = true", 'closed = "yes"', "wall[0].closed: must be true or false, got 'yes'"),
    (
        'side = "right"',
        'side = "rigth"',
        "wall[0].side: must be 'centre', 'left' or 'right', got 'rigth'",
    ),
    ("radius_m = 0.1", 'radius_m = "0.1"', "pillar[0].radius_m: must be a number, got '0.1'"),
    ("radius_m = 0.1", "radius_m = true", "pillar[0].radius_m: must be a number, got True"),
    ("centre_m = [3.0, 0.5]", "centre_m = [3.0]", "pillar[0].centre_m: must be [x, y], got [3.0]"),
    (
        "centre_m = [3.0, 0.5]",
        "centre_m = [3.0, []]",
        "pillar[0].centre_m[1]: must be a number, got []",
    ),
    ("[[3.0, 1.0]]", "[3.0, 1.0]", "route_m[0]: must be [x, y], got 3.0"),
    ("[[3.0, 1.0]]", "3.0", "route_m: must be a list, got 3.0"),
    ("[[pillar]]", "[pillar]", "pillar: must be a list, got {"),
    ("notes = { bounds_m", "notes = 3 # {", "notes: must be a table, got 3"),
    (
        "[materials.felt]",
        "[materials]",
        "materials.critical_incidence_deg: must be a table, got 45",
    ),
    # numbers
    ("[[3.0, 1.0]]", "[[nan, 1.0]]", "route_m[0][0]: must be a finite number, got nan"),
    ("[2, 3]]", "[2, inf]]", "wall[1].points_m[1][1]: must be a finite number, got inf"),
    ("x_m = 1.0", "x_m = -inf", "start.x_m: must be a finite number, got -inf"),
    ("thickness_m = 0.1", "thickness_m = 0", "wall[0].thickness_m: must be > 0, got 0"),
    ("height_m = 0.7", "height_m = -1", "box[0].height_m: must be > 0, got -1"),
    ('"= depth_m", 0.6', '"= depth_m", 0', "box[0].size_m[1]: must be > 0, got 0"),
    ("radius_m = 0.1", "radius_m = -0.1", "pillar[0].radius_m: must be > 0, got -0.1"),
    (
        "critical_incidence_deg = 45",
        "critical_incidence_deg = 91",
        "materials.felt.critical_incidence_deg: must be within (0, 90], got 91",
    ),
    (
        "reflectivity = 0.5",
        "reflectivity = 1.5",
        "materials.felt.reflectivity: must be within [0, 1], got 1.5",
    ),
    (
        "roughness_mm = 2",
        "roughness_mm = 2\ndiffuse_floor_db = 3",
        "materials.felt.diffuse_floor_db: must be within [-100, 0], got 3",
    ),
    ("roughness_mm = 2", "roughness_mm = -2", "materials.felt.roughness_mm: must be >= 0, got -2"),
    (
        "[-1, -1, 5, 4]",
        "[5, -1, -1, 4]",
        "bounds_m: must be [xmin, ymin, xmax, ymax] with min < max, got [5.0, -1.0, -1.0, 4.0]",
    ),
    (
        "[-1, -1, 5, 4]",
        "[-1, -1, 5]",
        "bounds_m: must be [xmin, ymin, xmax, ymax], got [-1, -1, 5]",
    ),
    # formulas and parameters
    (
        '"= 2 + gap_m"',
        '"= 2 + gap"',
        "wall[1].points_m[0][1]: bad formula '= 2 + gap': unknown parameter 'gap'; did you mean",
    ),
    (
        '"= 2 + gap_m"',
        '"= 2 ** gap_m"',
        "wall[1].points_m[0][1]: bad formula '= 2 ** gap_m': only numbers, parameters and +",
    ),
    ('"= 2 + gap_m"', '"2 + gap_m"', "wall[1].points_m[0][1]: must be a number, got '2 + gap_m'"),
    ("default = 1.0", "default = 3.0", "parameters.depth_m: must be within [0.5, 2], got 3"),
    ("gap_m = 0.5", "gap_m = nan", "parameters.gap_m.default: must be a finite number, got nan"),
    (
        "gap_m = 0.5",
        '"gap m" = 0.5\ngap_m = 0.5',
        "parameters.gap m: a parameter's name is made of letters, digits and _",
    ),
    # notes
    (
        "{ thickness_m =",
        "{ thicknes_m =",
        "wall[0].notes.thicknes_m: no such key in this table; did you mean 'thickness_m'?",
    ),
    (
        '{ heading_deg = "f',
        '{ heading = "f',
        "start.notes.heading: no such key in this table; did you mean 'heading_deg'?",
    ),
    (
        '{ gap_m = "a',
        '{ gab_m = "a',
        "parameters.notes.gab_m: no such key in this table; did you mean 'gap_m'?",
    ),
    ('{ bounds_m = "assumed" }', "{ bounds_m = 1 }", "notes.bounds_m: must be a text, got 1"),
    # walls
    (
        "[[0, 0], [4, 0], [4, 3], [0, 3]]",
        "[[0, 0], [4, 3], [4, 0], [0, 3]]",
        "wall[0].points_m: the wall crosses itself at [2, 1.5]",
    ),
    ("[2, 3]]", "[2, 2.5]]", "wall[1].points_m: zero length: points 0 and 1 are both [2, 2.5]"),
    (
        'side = "right"\nthickness_m = 0.1',
        'side = "left"\nthickness_m = 4.0',
        "wall[0].points_m: a wall 4 m thick cannot follow this line",
    ),
    # what holds between tables
    (
        'material = "brick"',
        'material = "brik"',
        "wall[0].material: unknown material 'brik'; did you mean 'brick'?",
    ),
    (
        'material = "felt"',
        'material = "fealt"',
        "wall[1].material: unknown material 'fealt'; did you mean 'felt'?",
    ),
    ('name = "post"', 'name = "screen"', "pillar[0].name: 'screen' is already that of wall[1]"),
    (
        "centre_m = [3.0, 0.5]",
        "centre_m = [3000, 500]",
        "pillar[0]: 'post' lies wholly outside of bounds_m",
    ),
    ("x_m = 1.0\ny_m = 1.0", "x_m = 3.5\ny_m = 2.0", "start: [3.5, 2] lies inside of 'desk'"),
    ("x_m = 1.0\ny_m = 1.0", "x_m = 2.95\ny_m = 0.5", "start: [2.95, 0.5] lies inside of 'post'"),
    ("x_m = 1.0", "x_m = 4.05", "start: [4.05, 1] lies inside of 'room'"),
    ("x_m = 1.0", "x_m = 6", "start: [6, 1] must lie inside of bounds_m [-1.0, -1.0, 5.0, 4.0]"),
    ("[[3.0, 1.0]]", "[[3.0, 1.0], [2.0, 2.8]]", "route_m[1]: [2, 2.8] lies inside of 'screen'"),
]


@pytest.mark.parametrize(("old", "new", "message"), FAULTS)
def test_a_fault_is_named_in_one_line(load_text, tmp_path, old, new, message):
    assert old in ROOM
    # The side is drawn inwards for the wall that is to be too thick.
    with pytest.raises(InputError) as caught:
        load_text(ROOM.replace(old, new, 1))
    said = str(caught.value)
    assert said.startswith(f"{tmp_path / 'room.toml'}: {message}")
    assert "\n" not in said


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"gab_m": 1}, "unknown parameter 'gab_m'; did you mean 'gap_m'?"),
        ({"gap_m": math.nan}, "parameter gap_m must be a finite number, got nan"),
        ({"gap_m": "wide"}, "parameter gap_m must be a number, got 'wide'"),
        ({"gap_m": True}, "parameter gap_m must be a number, got True"),
        ({"depth_m": 3}, "parameter depth_m must be within [0.5, 2], got 3"),
        ({"gap_m": 0.5, "depth_m": 0.1}, "parameter depth_m must be within [0.5, 2], got 0.1"),
    ],
)
def test_a_bad_parameter_is_named(load_text, parameters, message):
    with pytest.raises(InputError, match=re.escape(f"room.toml: {message}")):
        load_text(ROOM, **parameters)


def test_a_room_without_parameters_says_so():
    with pytest.raises(InputError, match=r"^rooms/l-shape.toml: unknown parameter 'gap_m'; this"):
        worlds.load("l-shape", gap_m=1.0)


def test_a_misspelt_room_is_answered_with_the_nearest_one():
    with pytest.raises(InputError, match=r"unknown world 'ofice'; did you mean 'office'\?"):
        worlds.load("ofice")


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match=r"missing.toml: no such file"):
        worlds.load(tmp_path / "missing.toml")
    with pytest.raises(InputError, match=r": cannot be read: "):
        worlds.load(tmp_path)
    foreign = tmp_path / "picture.toml"
    foreign.write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe")
    with pytest.raises(InputError, match=r"picture.toml: is not a world file: not UTF-8 text"):
        worlds.load(foreign)


def test_faults_of_toml_are_given_with_their_line(load_text):
    with pytest.raises(InputError, match=r"room.toml: is not TOML: .*at line 3"):
        load_text('title = "a"\nsource = "b"\nbounds_m = = 2\nstart = 3')


def test_a_cut_file_is_refused_or_lacks_whole_things_at_its_end(load_text):
    names = [solid.name for solid in load_text(ROOM).solids]
    refused = 0
    for end in range(0, len(ROOM), 17):
        try:
            world = load_text(ROOM[:end])
        except InputError:
            refused += 1
        else:
            assert [solid.name for solid in world.solids] == names[: len(world.solids)]
    assert refused > 50


def test_a_material_may_tell_what_it_scatters(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(ROOM.replace("roughness_mm = 2", "roughness_mm = 2\ndiffuse_floor_db = -25"))
    materials = {solid.material for solid in worlds.load(path).solids}
    assert {m.diffuse_floor_db for m in materials if m.name == "felt"} == {-25.0}
