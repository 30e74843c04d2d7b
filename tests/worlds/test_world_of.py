"""`World.of` and the shapes of `Solid`: what every reader of worlds ends with."""

import math
import pickle

import pytest
import shapely

from sonarmap import InputError
from worlds import MATERIALS, Material, Pose, Solid, World

FELT = Material("felt", 0.8, 0.5, 0.002)
DESK = Solid.box("desk", (2, 1), (1.6, 0.8), height_m=0.7, material="wood")
POST = Solid.pillar("post", (3, 2.5), 0.1, height_m=2, material=FELT)


def world(**changes):
    given = {
        "name": "room",
        "solids": [DESK, POST],
        "bounds_m": (0, 0, 4, 3),
        "start": (1, 2, 0.5),
        "route_m": [(1, 2.5), (2, 2)],
    }
    return World.of(**(given | changes))


def test_a_world_is_made_of_plain_numbers():
    room = world(notes={"start": "assumed"}, parameters={"gap_m": 1.0}, source="a test")
    assert (room.name, room.title, room.source) == ("room", "room", "a test")
    assert room.bounds_m == (0.0, 0.0, 4.0, 3.0)
    assert room.start == Pose(1.0, 2.0, 0.5)
    assert room.route_m == ((1.0, 2.5), (2.0, 2.0))
    assert room.solids == (DESK, POST)
    assert (room.notes, room.parameters) == ({"start": "assumed"}, {"gap_m": 1.0})
    assert pickle.loads(pickle.dumps(room)) == room


def test_a_start_may_be_a_pose_and_everything_an_iterator():
    room = world(start=Pose(1, 2, 0.5), solids=iter([DESK, POST]), route_m=iter([[1, 2.5], (2, 2)]))
    assert room == world()


def test_solids_have_the_shape_that_they_are_made_from():
    wall = Solid.wall("w", [(0, 0), (4, 0)], thickness_m=0.2, height_m=2, material="brick")
    assert wall.outline.equals(shapely.box(0, -0.1, 4, 0.1))
    assert wall.material is MATERIALS["brick"]
    turned = Solid.box("b", (1, 1), (2, 1), heading_rad=math.pi / 2, height_m=1, material="wood")
    assert turned.outline.bounds == (0.5, 0.0, 1.5, 2.0)
    assert POST.circle == (3, 2.5, 0.1)
    assert POST.material is FELT
    frame = Solid.polygon(
        "f",
        [(0, 0), (3, 0), (3, 3), (0, 3)],
        holes_m=[[(1, 1), (2, 1), (2, 2), (1, 2)]],
        height_m=1,
        material="metal",
    )
    assert frame.outline.area == 8
    assert frame.circle is None


INF, NAN = math.inf, math.nan


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        # numbers
        ({"bounds_m": (0, 0, 4)}, "bounds_m: must be [xmin, ymin, xmax, ymax], finite numbers"),
        ({"bounds_m": (0, 0, 4, INF)}, "bounds_m: must be [xmin, ymin, xmax, ymax], finite"),
        (
            {"bounds_m": "wide"},
            "bounds_m: must be [xmin, ymin, xmax, ymax], finite numbers, got 'w",
        ),
        ({"bounds_m": 4}, "bounds_m: must be [xmin, ymin, xmax, ymax], finite numbers, got 4"),
        (
            {"bounds_m": (4, 0, 0, 3)},
            "bounds_m: must be [xmin, ymin, xmax, ymax] with min < max, got [4.0, 0.0, 0.0, 3.0]",
        ),
        ({"start": (1, 2)}, "start: must be [x, y, heading], finite numbers, got (1, 2)"),
        ({"start": Pose(1, NAN, 0)}, "start: must be [x, y, heading], finite numbers, got (1, nan"),
        ({"start": (1, 2, INF)}, "start: must be [x, y, heading], finite numbers, got (1, 2, inf)"),
        ({"route_m": [(1, 2), (NAN, 1)]}, "route_m[1]: must be [x, y], finite numbers, got (nan"),
        ({"route_m": [1, 2]}, "route_m[0]: must be [x, y], finite numbers, got 1"),
        # what holds between them
        ({"solids": [DESK, "post"]}, "solids[1]: must be a Solid, got 'post'"),
        (
            {"solids": [Solid("desk", "wood", 1.0, DESK.outline)]},
            "solids[0].material: must be a Material, got 'wood'",
        ),
        ({"solids": [DESK, POST, DESK]}, "solids[2].name: 'desk' is already that of solids[0]"),
        (
            {"solids": [DESK, POST, DESK], "places": ["box[0]", "pillar[0]", "box[1]"]},
            "box[1].name: 'desk' is already that of box[0]",
        ),
        (
            {"bounds_m": (0, 0, 4, 2.2)},
            "solids[1]: 'post' lies wholly outside of bounds_m [0.0, 0.0, 4.0, 2.2]",
        ),
        ({"start": (0, 2, 0)}, "start: [0, 2] must lie inside of bounds_m [0.0, 0.0, 4.0, 3.0]"),
        ({"start": (2, 1, 0)}, "start: [2, 1] lies inside of 'desk'"),
        ({"route_m": [(1, 2), (3, 2.5)]}, "route_m[1]: [3, 2.5] lies inside of 'post'"),
    ],
)
def test_a_world_that_breaks_a_rule(changes, message):
    with pytest.raises(InputError) as caught:
        world(**changes)
    assert str(caught.value).startswith(message)


BODY = {"height_m": 1, "material": "wood"}
SQUARE = [(0, 0), (3, 0), (3, 3), (0, 3)]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Solid.box("b", (1, 1), (2, 1), height_m=1, material="wod"),
            "material: unknown material 'wod'; did you mean 'wood'?",
        ),
        (
            lambda: Solid.box("b", (1, 1), (2, 1), height_m=0, material="wood"),
            "height_m must be > 0, got 0",
        ),
        (lambda: Solid.box("b", (1,), (2, 1), **BODY), "centre_m must be two numbers, got (1,)"),
        (lambda: Solid.box("b", (1, 1), (2, -1), **BODY), "size_m[1] must be > 0, got -1"),
        (
            lambda: Solid.box("b", (1, 1), (2, 1), heading_rad=NAN, **BODY),
            "heading_rad must be a finite number, got nan",
        ),
        (
            lambda: Solid.pillar("p", (1, INF), 0.1, **BODY),
            "centre_m[1] must be a finite number, got inf",
        ),
        (lambda: Solid.pillar("p", (1, 1), 0, **BODY), "radius_m must be > 0, got 0"),
        (
            lambda: Solid.wall("w", [(0, 0), (1, 1), (2, NAN)], thickness_m=0.1, **BODY),
            "points_m[2][1] must be a finite number, got nan",
        ),
        (
            lambda: Solid.wall("w", [(0, 0), (0, 0)], thickness_m=0.1, **BODY),
            "points_m: zero length: points 0 and 1 are both [0, 0]",
        ),
        (
            lambda: Solid.wall("w", [(0, 0), (1, 0)], thickness_m=0, **BODY),
            "thickness_m must be > 0, got 0",
        ),
        (
            lambda: Solid.wall("w", [(0, 0), (1, 0)], thickness_m=0.1, side="up", **BODY),
            "side 'up' is unknown; known: centre, left, right",
        ),
        (
            lambda: Solid.polygon("p", SQUARE[:2], **BODY),
            "points_m: a polygon needs at least 3 points, got 2",
        ),
        (
            lambda: Solid.polygon("p", [(0, 0), (1, 1), (1, 0), (0, 1)], **BODY),
            "points_m: no polygon: Self-intersection[0.5 0.5]",
        ),
        (
            lambda: Solid.polygon("p", [(0, 0), (1, 1), (2, 2)], **BODY),
            "points_m: no polygon: ",
        ),
        (
            lambda: Solid.polygon("p", SQUARE, holes_m=[[(5, 5), (6, 5), (6, 6)]], **BODY),
            "points_m: no polygon: Hole lies outside shell[5 5]",
        ),
        (
            lambda: Solid.polygon("p", SQUARE, holes_m=[[(1, 1), (2, 1), "ab"]], **BODY),
            "holes_m[0][2][0] must be a number, got 'a'",
        ),
    ],
)  # fmt: skip
def test_a_solid_that_breaks_a_rule(make, message):
    with pytest.raises(InputError) as caught:
        make()
    assert str(caught.value).startswith(message)
