import math

import numpy as np
import pytest
import shapely
from shapely import LineString, Point

import worlds
from sonarmap import AMIGOBOT

NAMES = (
    "clutter",
    "corridor",
    "l-shape",
    "office",
    "opening-rig",
    "round-room",
    "thesis-exp1",
    "thesis-exp2",
)
# The AmigoBot's radius in ARIA, and what a driver needs to turn beside a wall.
ROBOT_RADIUS_M = 0.18
ROUTE_CLEARANCE_M = 0.35
# Rashid 2006, table of wheel speeds: 40 and 75 mm/s; track 0.24 m; the circle they make.
CIRCLE_M = 0.12 * (75 + 40) / (75 - 40)


@pytest.fixture(params=NAMES)
def world(request):
    return worlds.load(request.param)


def solid(world, name):
    (found,) = (one for one in world.solids if one.name == name)
    return found


def circle_centre(world):
    """The point on the robot's left about which the thesis's wheel speeds turn it."""
    start = world.start
    left = start.heading_rad + math.pi / 2
    return np.array([start.x_m + CIRCLE_M * math.cos(left), start.y_m + CIRCLE_M * math.sin(left)])


def sonar_places(world):
    """Where the sonars come to while the robot drives its circle, and a point each degree."""
    angle = np.radians(np.arange(360))[:, None]
    x = CIRCLE_M * np.cos(angle - math.pi / 2)
    y = CIRCLE_M * np.sin(angle - math.pi / 2)
    ahead, left = AMIGOBOT.x_m, AMIGOBOT.y_m
    places_x = x + np.cos(angle) * ahead - np.sin(angle) * left
    places_y = y + np.sin(angle) * ahead + np.cos(angle) * left
    return circle_centre(world) + np.column_stack([places_x.ravel(), places_y.ravel()])


def test_the_rooms_that_are_shipped():
    assert worlds.names() == NAMES


def test_every_room_says_what_it_is(world):
    assert world.title
    assert world.source
    assert world.faces.surface_names == tuple(one.name for one in world.solids)


def test_the_start_is_free_at_any_usual_resolution(world):
    for resolution_m in (0.02, 0.05, 0.1):
        truth = worlds.truth(world, resolution_m=resolution_m)
        assert truth.state[truth.grid.cell_of(world.start.x_m, world.start.y_m)] == worlds.FREE
        assert (truth.state == worlds.OCCUPIED).sum() > 50


def test_start_and_route_keep_clear_of_every_solid(world):
    way = [(world.start.x_m, world.start.y_m), *world.route_m]
    path = LineString(way) if len(way) > 1 else Point(way[0])
    for one in world.solids:
        assert path.distance(one.outline) >= ROUTE_CLEARANCE_M, one.name


def test_walls_and_things_lie_within_the_bounds(world):
    bounds = shapely.box(*world.bounds_m).buffer(1e-9)
    for one in world.solids:
        assert bounds.covers(one.outline), one.name


@pytest.mark.parametrize("name", [name for name in NAMES if name != "opening-rig"])
def test_a_robot_cannot_leave_a_closed_room(name):
    truth = worlds.truth(worlds.load(name))
    edge = np.concatenate([truth.state[0], truth.state[-1], truth.state[:, 0], truth.state[:, -1]])
    assert worlds.FREE not in edge


def test_every_assumption_is_about_a_number_of_the_file(world):
    assert all(text for text in world.notes.values())
    if world.name.startswith("thesis"):
        assert sum("assumed" in text for text in world.notes.values()) > 10


@pytest.mark.parametrize("name", ["thesis-exp1", "thesis-exp2", "round-room"])
def test_the_thesis_circle_stays_clear_of_the_walls(name):
    world = worlds.load(name)
    circle = Point(circle_centre(world)).buffer(CIRCLE_M, quad_segs=64)
    for one in world.solids:
        assert circle.distance(one.outline) > ROBOT_RADIUS_M + 0.25, one.name


def test_the_first_experiment_has_four_walls_in_range_and_card_on_the_fourth():
    world = worlds.load("thesis-exp1")
    assert [one.name for one in world.solids] == ["wall 1", "wall 2", "wall 3", "wall 4"]
    assert [one.material.name for one in world.solids] == ["drywall"] * 3 + ["smooth-cardboard"]
    places = shapely.points(sonar_places(world))
    for one in world.solids:
        assert shapely.distance(one.outline, places).max() < 3.0


def test_the_second_experiment_has_three_openings_two_of_them_doors():
    world = worlds.load("thesis-exp2")
    assert solid(world, "glass").material.name == "glass"
    jambs = {
        "D1": ("north, left of D1", "north, right of D1"),
        "D2": ("west, below D2", "west, above D2"),
        "hole": ("east, below", "east, above"),
    }
    width = {
        name: solid(world, one).outline.distance(solid(world, other).outline)
        for name, (one, other) in jambs.items()
    }
    assert width == pytest.approx({"D1": 0.8, "D2": 0.8, "hole": 1.0})
    # Section 6.3: an opening of 0.8 m is sensed from no farther than 0.8 m.
    circle = Point(circle_centre(world)).buffer(CIRCLE_M, quad_segs=64)
    for one, other in jambs.values():
        line = shapely.shortest_line(solid(world, one).outline, solid(world, other).outline)
        assert circle.distance(line) < 0.8


def test_the_outer_walls_of_the_second_experiment_are_out_of_range():
    world = worlds.load("thesis-exp2")
    places = shapely.points(sonar_places(world))
    for name in ("E", "T", "A"):
        assert shapely.distance(solid(world, name).outline, places).min() > 3.0


@pytest.mark.parametrize("gap_m", [0.1, 0.6, 0.8, 2.0])
@pytest.mark.parametrize("distance_m", [0.15, 0.4, 2.0])
def test_the_opening_rig_has_the_gap_and_the_distance_asked_for(gap_m, distance_m):
    world = worlds.load("opening-rig", gap_m=gap_m, distance_m=distance_m)
    left, right = (one.outline for one in world.solids)
    assert left.distance(right) == pytest.approx(gap_m)
    # Sonar 0 looks left, 0.100 m beside the robot's centre.
    sonar = np.array([[world.start.x_m + AMIGOBOT.x_m[0], world.start.y_m + AMIGOBOT.y_m[0]]])
    hits = world.faces.cast(sonar, [[0.0, 1.0]], 5.0)
    assert hits.distance_m[0] == pytest.approx(distance_m)
    assert world.route_m[-1][1] == world.start.y_m


def test_a_gap_of_nothing_lets_no_sound_through():
    world = worlds.load("opening-rig", gap_m=0)
    assert world.faces.cast([[0.0, -0.5]], [[0.0, 1.0]], 5.0).distance_m[0] == 0.5


def test_the_round_room_has_one_radius_all_around():
    world = worlds.load("round-room")
    angle = np.linspace(-math.pi, math.pi, 1000)
    directions = np.column_stack([np.cos(angle), np.sin(angle)])
    distance_m = world.faces.cast(np.zeros_like(directions), directions, 5.0).distance_m
    assert distance_m.max() == pytest.approx(1.5, abs=1e-4)
    assert distance_m.min() == pytest.approx(1.5 * math.cos(math.pi / 96), abs=1e-4)


def test_the_corridor_is_long_and_mirrors():
    world = worlds.load("corridor")
    route = LineString([(world.start.x_m, world.start.y_m), *world.route_m])
    assert route.length > 15
    assert solid(world, "walls").material.name == "drywall"
    ahead = world.faces.cast([[world.start.x_m, world.start.y_m]], [[1.0, 0.0]], 20.0)
    assert ahead.distance_m[0] > 8


def test_the_clutter_has_chair_legs_of_a_few_centimetres():
    legs = [one for one in worlds.load("clutter").solids if "leg" in one.name]
    assert len(legs) == 8
    assert all(0.015 <= one.circle[2] <= 0.025 for one in legs)
