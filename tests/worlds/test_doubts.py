import math

import pytest

import worlds
from worlds import Solid, World

METAL = {"height_m": 1.0, "material": "metal"}


def room(*more, start=(1, 1, 0), route=(), bounds=(-0.1, -0.1, 4.1, 3.1), **wall):
    walls = Solid.wall(
        "walls",
        [(0, 0), (4, 0), (4, 3), (0, 3)],
        closed=True,
        side="right",
        **{"thickness_m": 0.1, "height_m": 2.5, "material": "drywall"} | wall,
    )
    return World.of("room", [walls, *more], bounds_m=bounds, start=start, route_m=route)


def said(world, **arguments):
    return {doubt.rule: str(doubt) for doubt in worlds.doubts(world, **arguments)}


def test_an_empty_room_is_beyond_doubt():
    assert said(room(route=[(3, 1), (3, 2)])) == {}


@pytest.mark.parametrize("name", worlds.names())
def test_of_the_shipped_rooms_only_boards_and_glass_are_doubtful(name):
    assert set(said(worlds.load(name))) <= {"thin"}


def test_a_start_and_a_route_that_touch_something():
    desk = Solid.box("desk", (2, 1), (0.4, 0.4), **METAL)
    assert said(room(desk, start=(1.7, 1, 0)))["start"] == (
        "start: the robot meets 'desk', 0.10 m away: a robot of 0.18 m radius touches it"
    )
    route = said(room(desk, route=[(1, 2), (3, 2), (3, 0.9), (1, 0.9)]))["route"]
    assert route.startswith("route_m[3]: the leg to it meets 'desk', 0.00 m away")
    assert said(room(desk, start=(1.7, 1, 0)), robot_radius_m=0.05) == {}


def halves(gap_m):
    """A room of two halves with a gap in the wall between them."""
    edge = 1.5 - gap_m / 2
    pieces = [[(2, 0), (2, edge)], [(2, 3 - edge), (2, 3)]] if gap_m else [[(2, 0), (2, 3)]]
    return room(
        *(Solid.wall(f"p{i}", ends, thickness_m=0.1, **METAL) for i, ends in enumerate(pieces))
    )


def test_a_room_out_of_reach_tells_why():
    assert said(halves(0.5)) == {}
    narrow = said(halves(0.3))["reach"]
    # What is said last is how little is reached.
    assert narrow == "start: the robot comes to 50% of the free space that it fits in"
    (first, *_) = worlds.doubts(halves(0.3))
    assert str(first).startswith("start: 4.2 m² about [")
    assert str(first).endswith("the way by [2.00, 1.50] is 0.30 m wide, the robot 0.36 m")
    (first, *_) = worlds.doubts(halves(0))
    assert str(first).endswith("cannot be reached: no opening leads there")
    assert said(halves(0.3), robot_radius_m=0.14) == {}


def test_what_lies_outside_of_the_walls_is_no_room():
    assert said(room(bounds=(-3, -3, 6, 6))) == {}


@pytest.mark.parametrize(
    ("material", "complaint"),
    [
        ((50, 0.9, 0.1), "roughness_mm 100: are those millimetres?"),
        ((20, 0.9, 0.002), "as rough as 2 mm it scatters, yet mirrors beyond 20 degrees"),
        ((60, 0.9, 0.0001), "as smooth as 0.1 mm it is a mirror, yet is seen up to 60 degrees"),
        ((60, 0.01, 0.002), "reflectivity 0.01: never heard"),
    ],
)
def test_materials_that_make_no_sense(material, complaint):
    degrees, reflectivity, roughness_m = material
    own = worlds.Material("own", math.radians(degrees), reflectivity, roughness_m)
    assert said(room(material=own))["material"].startswith(f"materials.own: {complaint}")
    # One that is called as a preset but is not it is looked at, too.
    assert "material" not in said(room(material="brick"))


def test_heights_that_make_no_sense():
    low = Solid.box("sill", (2, 1), (0.4, 0.4), height_m=0.05, material="wood")
    assert "height_m 0.05 is lower than a sonar" in said(room(low))["height"]
    assert said(room(height_m=250))["height"] == "walls: height_m 250: are those metres?"


def test_thin_walls_but_not_what_hangs_on_a_wall():
    glass = Solid.wall("glass", [(2, 1), (2, 2)], thickness_m=0.02, **METAL)
    board = Solid.box("board", (2, 2.98), (1, 0.03), **METAL)
    leg = Solid.pillar("leg", (3, 2), 0.01, **METAL)
    assert said(room(board, leg)) == {}
    assert said(room(glass, board))["thin"].startswith(
        "glass: thinner than a cell of 0.05 m: 1 ('glass');"
    )
    assert said(room(glass), resolution_m=0.01) == {}


def test_solids_in_one_another():
    desk = Solid.box("desk", (2, 2), (1, 1), **METAL)
    half = Solid.box("half", (2.5, 2), (0.8, 0.8), **METAL)
    inside = Solid.box("inside", (2, 2), (0.5, 0.5), **METAL)
    assert said(room(desk, half)) == {}
    assert said(room(desk, inside))["overlap"] == "inside: 100% of it lies inside of 'desk'"


def test_bounds_much_larger_than_what_is_there():
    doubt = said(room(bounds=(-0.1, -0.1, 400, 3.1)))["bounds"]
    assert doubt == "bounds_m: 400.1 m wide, where all that stands there and the route need 4.2 m"
