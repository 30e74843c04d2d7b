import math

import numpy as np
import pytest
import shapely
from shapely import LineString, Point

import worlds
from sonarmap import InputError

# A room of 4 m by 3 m with a post in it.
ROOM = """
bounds_m = [0, 0, 4, 3]
start = { x_m = 1, y_m = 1, heading_deg = 0 }

[[wall]]
name = "walls"
points_m = [[0, 0], [4, 0], [4, 3], [0, 3]]
closed = true
side = "right"
thickness_m = 0.1
height_m = 2
material = "brick"

[[pillar]]
name = "post"
centre_m = [3, 1]
radius_m = 0.25
height_m = 2
material = "metal"
"""


@pytest.fixture
def room(make_world):
    return make_world(ROOM)


def unit(angle_rad):
    angle = np.atleast_1d(angle_rad)
    return np.column_stack([np.cos(angle), np.sin(angle)])


def cast_one(world, x, y, angle_deg, range_max_m=10.0):
    hits = world.faces.cast([[x, y]], unit(math.radians(angle_deg)), range_max_m)
    return hits.distance_m[0], tuple(hits.normal_xy[0]), hits.surface[0]


def plain_cast(world, origin, direction, range_max_m):
    """The slow twin: cut the ray with every outline, one ray and one solid at a time."""
    best, found = math.inf, -1
    start = Point(origin)
    end = origin + range_max_m * direction
    for surface, solid in enumerate(world.solids):
        if solid.circle is None:
            cut = LineString([origin, end]).intersection(solid.outline.boundary)
            distance = start.distance(cut) if not cut.is_empty else math.inf
        else:
            to_centre = np.array(solid.circle[:2]) - origin
            along = to_centre @ direction
            aside_2 = to_centre @ to_centre - along**2
            reaches = aside_2 <= solid.circle[2] ** 2 and along > 0
            distance = along - math.sqrt(solid.circle[2] ** 2 - aside_2) if reaches else math.inf
        if distance <= range_max_m and distance < best:
            best, found = distance, surface
    return best, found


def test_distance_and_normal_of_a_wall_met_head_on(room):
    assert cast_one(room, 1, 2, 0) == (3.0, (-1.0, 0.0), 0)
    assert cast_one(room, 1, 2, 180) == (1.0, (1.0, 0.0), 0)
    distance, normal, surface = cast_one(room, 1, 2, 90)
    assert (distance, surface) == (pytest.approx(1.0), 0)
    assert normal == (0.0, -1.0)


@pytest.mark.parametrize("angle_deg", [-35, -20, 5, 15, 18])
def test_a_tilted_ray_is_longer_by_its_cosine(room, angle_deg):
    distance, normal, _ = cast_one(room, 1, 2, angle_deg + 180)
    assert distance == pytest.approx(1 / math.cos(math.radians(angle_deg)))
    assert normal == (1.0, 0.0)


def test_a_circle_is_met_exactly(room):
    distance, normal, surface = cast_one(room, 1, 1, 0)
    assert (distance, normal, surface) == (1.75, (-1.0, 0.0), 1)
    # 0.15 m beside the centre the circle is sqrt(0.25^2 - 0.15^2) = 0.2 m before it.
    distance, normal, surface = cast_one(room, 1, 1.15, 0)
    assert distance == pytest.approx(1.8)
    assert normal == pytest.approx((-0.8, 0.6))
    assert surface == 1


def test_a_ray_that_just_misses_a_circle_meets_the_wall_behind(room):
    assert cast_one(room, 1, 1.2499, 0)[2] == 1
    assert cast_one(room, 1, 1.2501, 0) == (3.0, (-1.0, 0.0), 0)


def test_from_inside_a_solid_its_far_side_is_met(room):
    distance, normal, surface = cast_one(room, 3.1, 1, 0)
    assert (distance, normal, surface) == (pytest.approx(0.15), (-1.0, 0.0), 1)
    assert cast_one(room, -0.04, 1, 180)[0] == pytest.approx(0.06)


def test_nothing_is_met_beyond_the_range(room):
    assert cast_one(room, 1, 2, 0, 3.0)[0] == 3.0
    distance, normal, surface = cast_one(room, 1, 2, 0, math.nextafter(3.0, 0))
    assert (distance, normal, surface) == (math.inf, (0.0, 0.0), -1)
    assert cast_one(room, 1, 1, 0, math.nextafter(1.75, 0))[2] == -1


def test_every_ray_may_have_its_own_range(room):
    hits = room.faces.cast([[1, 2]] * 3, [[1, 0]] * 3, [2.0, 3.0, np.inf])
    assert hits.distance_m.tolist() == [math.inf, 3.0, 3.0]


def test_a_ray_that_begins_on_a_surface_leaves_it(room):
    assert cast_one(room, 0, 2, 0)[0] == 4.0
    assert cast_one(room, 2.75, 1, 180)[0] == pytest.approx(2.75)
    # where a mirrored ray begins, rounding may have put it a little behind the surface
    assert cast_one(room, math.nextafter(4, 5), 2, 135)[0] == pytest.approx(math.sqrt(2))


def test_a_ray_along_a_wall_meets_its_end_and_one_beside_it_nothing():
    rig = worlds.load("opening-rig", gap_m=1.0)
    hits = rig.faces.cast([[-3.5, 0.01], [-3.5, 0.0], [-3.5, -1e-6]], [[1, 0]] * 3, 10.0)
    assert hits.surface.tolist() == [0, 0, -1]
    assert hits.distance_m[:2] == pytest.approx([0.5, 0.5])


def test_no_ray_slips_through_a_corner(rng):
    world = worlds.load("round-room")
    corners = np.array(world.solids[0].outline.interiors[0].coords)[:-1]
    for corner in corners:
        origins = rng.uniform(-1, 1, (200, 2))
        towards = corner - origins
        distance = np.hypot(*towards.T)
        hits = world.faces.cast(origins, towards / distance[:, None], 5.0)
        assert hits.distance_m == pytest.approx(distance, abs=1e-7)


@pytest.mark.parametrize("name", worlds.names())
def test_the_kernel_agrees_with_its_slow_twin(name, rng):
    world = worlds.load(name)
    x_min, y_min, x_max, y_max = world.bounds_m
    free = shapely.union_all([solid.outline for solid in world.solids])
    origins = rng.uniform((x_min, y_min), (x_max, y_max), (150, 2))
    origins = origins[shapely.distance(free, shapely.points(origins)) > 0.01]
    directions = unit(rng.uniform(-math.pi, math.pi, len(origins)))
    hits = world.faces.cast(origins, directions, 3.0)
    for k, (origin, direction) in enumerate(zip(origins, directions, strict=True)):
        distance, surface = plain_cast(world, origin, direction, 3.0)
        assert hits.distance_m[k] == pytest.approx(distance, abs=1e-9), (origin, direction)
        assert hits.surface[k] == surface
    assert (hits.surface >= 0).sum() > 20


@pytest.mark.parametrize("name", worlds.names())
def test_normals_are_unit_vectors_against_the_ray(name, rng):
    world = worlds.load(name)
    directions = unit(rng.uniform(-math.pi, math.pi, 500))
    origins = np.broadcast_to([world.start.x_m, world.start.y_m], directions.shape)
    hits = world.faces.cast(origins, directions, 20.0)
    met = hits.surface >= 0
    assert np.hypot(*hits.normal_xy[met].T) == pytest.approx(1.0)
    assert ((hits.normal_xy * directions).sum(axis=1)[met] < 0).all()
    assert (hits.normal_xy[~met] == 0).all()
    assert (met == np.isfinite(hits.distance_m)).all()


@pytest.mark.parametrize("name", ["clutter", "office"])
def test_mirrored_and_turned_rooms_give_the_same_distances_to_the_last_bit(name, rng):
    world = worlds.load(name)
    directions = unit(rng.uniform(-math.pi, math.pi, 2000))
    origins = np.broadcast_to([world.start.x_m, world.start.y_m], directions.shape)
    hits = world.faces.cast(origins, directions, 20.0)
    changes = {
        "mirrored": (world.mirrored(), np.array([[1, 0], [0, -1]])),
        "turned": (world.transformed(quarter_turns=1), np.array([[0, -1], [1, 0]])),
        "turned twice": (world.transformed(quarter_turns=2), np.array([[-1, 0], [0, -1]])),
    }
    for what, (changed, matrix) in changes.items():
        again = changed.faces.cast(origins @ matrix.T, directions @ matrix.T, 20.0)
        assert np.array_equal(again.distance_m, hits.distance_m), what
        assert np.array_equal(again.normal_xy, hits.normal_xy @ matrix.T), what
        assert np.array_equal(again.surface, hits.surface), what


def test_surfaces_are_numbered_as_the_solids(room):
    assert room.faces.surface_names == ("walls", "post")
    assert room.faces.segment_surface.tolist() == [0] * 8
    assert room.faces.circle_surface.tolist() == [1]
    assert room.faces.circles_m.tolist() == [[3.0, 1.0, 0.25]]


def test_no_rays_give_no_hits(room):
    hits = room.faces.cast(np.empty((0, 2)), np.empty((0, 2)), 1.0)
    assert (hits.distance_m.shape, hits.normal_xy.shape) == ((0,), (0, 2))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([1, 2], [[1, 0]], 1.0), r"origins_xy_m must have shape \(n, 2\), got \(2,\)"),
        (([[1, 2, 3]], [[1, 0]], 1.0), r"origins_xy_m must have shape \(n, 2\), got \(1, 3\)"),
        (([[1, 2]], [[1, 0]] * 2, 1.0), "must have one row a ray, got 1 and 2"),
        (([[1, math.nan]], [[1, 0]], 1.0), "origins_xy_m must be finite numbers"),
        (([[1, 2]], [[1, 1]], 1.0), "directions_xy must be unit vectors, got one of length 1.41"),
        (([[1, 2]], [[1, 0]], [1.0, 2.0]), r"range_max_m must be a number or one a ray \(1\)"),
        (([[1, 2]], [[1, 0]], -1.0), "range_max_m must be >= 0"),
        (([[1, 2]], [[1, 0]], math.nan), "range_max_m must be >= 0"),
    ],
)
def test_bad_rays_are_refused(room, arguments, message):
    with pytest.raises(InputError, match=message):
        room.faces.cast(*arguments)
