import math
import textwrap
from types import SimpleNamespace

import numpy as np
import pytest
import shapely
from support import cells

import worlds
from sonarmap import InputError, SonarRing

# A room of 9 m by 3 m in cells of 1 m, with a wall across the lower two thirds of it.
ROOM = """
bounds_m = [0, 0, 11, 5]
start = { x_m = 1.5, y_m = 1.5, heading_deg = 0 }

[[wall]]
name = "walls"
points_m = [[1, 1], [10, 1], [10, 4], [1, 4]]
closed = true
side = "right"
thickness_m = 1
height_m = 2
material = "brick"
"""
ACROSS = """
[[wall]]
name = "across"
points_m = [[6.5, 1], [6.5, 3]]
thickness_m = 1
height_m = 2
material = "brick"
"""


def ring(half_angle_deg, range_max_m, *, x_m=(0.0,), y_m=(0.0,), heading_deg=(0.0,)):
    return SonarRing(
        "test", x_m, y_m, np.radians(heading_deg), math.radians(half_angle_deg), 0.1, range_max_m
    )


def log_at(ring, *poses, sonar=0):
    """Return what a log with these true poses, one reading each, says of itself."""
    x, y, heading_deg = np.array(poses, float).T
    truth = SimpleNamespace(x_m=x, y_m=y, heading_rad=np.radians(heading_deg))
    return SimpleNamespace(ring=ring, truth=truth, sonar=np.full(len(x), sonar))


def observed(world, log, resolution_m=1.0):
    return worlds.truth(world, resolution_m=resolution_m).observable(log)


def picture(text):
    return cells(text) == "o"


@pytest.mark.parametrize(
    ("half_angle_deg", "range_max_m", "pose", "seen"),
    [
        # A narrow beam along a row, up to its range
        (
            1,
            4.2,
            (1.5, 2.5, 0),
            """
            ...........
            ...........
            .ooooo.....
            ...........
            ...........
            """,
        ),
        # ... and up to the first surface, that included.
        (
            1,
            20,
            (1.5, 2.5, 0),
            """
            ...........
            ...........
            .oooooo....
            ...........
            ...........
            """,
        ),
        # Past the end of the wall the beam goes on to the next one.
        (
            1,
            20,
            (1.5, 3.5, 0),
            """
            ...........
            .oooooooooo
            ...........
            ...........
            ...........
            """,
        ),
        # A cone covers the cells that its edges cut.
        (
            40,
            2.0,
            (1.5, 2.5, 0),
            """
            ...........
            ..oo.......
            .ooo.......
            ..oo.......
            ...........
            """,
        ),
        # What lies ahead, and of the walls every cell but those that only meet at a corner.
        (
            89,
            20,
            (3.5, 1.5, 180),
            """
            .ooo.......
            oooo.......
            oooo.......
            oooo.......
            .ooo.......
            """,
        ),
    ],
)
def test_what_one_sonar_sees(make_world, half_angle_deg, range_max_m, pose, seen):
    log = log_at(ring(half_angle_deg, range_max_m), pose)
    assert (observed(make_world(ROOM + ACROSS), log) == picture(seen)).all()


def test_turning_the_robot_shows_the_whole_room_and_nothing_beyond(make_world):
    world = make_world(ROOM)
    log = log_at(ring(45, 30), *[(4.3, 2.2, turn) for turn in (0, 90, 180, 270)])
    truth = worlds.truth(world, resolution_m=0.5)
    expected = truth.state != worlds.HIDDEN
    corners = np.ix_([1, 8], [1, 20])
    assert (truth.state[corners] == worlds.OCCUPIED).all()
    expected[corners] = False  # they meet the room in a point: no sound comes back
    assert (truth.observable(log) == expected).all()


def test_nothing_is_seen_through_a_thin_wall(make_world):
    world = make_world(ROOM + ACROSS.replace("thickness_m = 1", "thickness_m = 0.001"))
    log = log_at(ring(20, 20), (1.5, 1.6, 0))
    seen = observed(world, log)
    assert seen[1, 6]
    assert not seen[1:3, 7:].any()
    assert seen[3, 9]  # over the end of the wall


def test_a_wall_seen_under_a_grazing_angle_has_no_gaps(make_world):
    # The last rays that meet the wall end more than a metre apart.
    world = make_world(ROOM)
    log = log_at(ring(6, 9.0), (1.05, 1.2, 0))
    seen = observed(world, log, resolution_m=0.1)[9, 10:100]
    nearest, farthest = np.flatnonzero(seen)[[0, -1]]
    assert farthest - nearest > 50
    assert seen[nearest : farthest + 1].all()


def test_a_face_that_one_ray_meets_is_seen_in_the_cell_behind_it(make_world):
    # The post's face lies on the border at x = 5, and the ray comes from the right.
    post = """
        [[box]]
        name = "post"
        centre_m = [4.99, 2.5]
        size_m = [0.02, 0.02]
        height_m = 1
        material = "wood"
    """
    seen = observed(make_world(ROOM + textwrap.dedent(post)), log_at(ring(10, 4), (8.5, 2.5, 180)))
    assert seen[2, 4]


@pytest.mark.parametrize(
    ("heading_deg", "seen"),
    [
        # Sonar 1 sits 1 m ahead of the robot's middle and 1 m to its left, and looks left.
        (0, [(2, 5), (3, 5), (4, 5)]),
        (90, [(2, 0), (2, 1), (2, 2), (2, 3)]),
    ],
)
def test_the_sonar_counts_and_not_the_robots_middle(make_world, heading_deg, seen):
    mounted = ring(1, 20, x_m=[0, 1], y_m=[0, 1], heading_deg=[0, 90])
    log = log_at(mounted, (4.5, 1.5, heading_deg), sonar=1)
    assert [tuple(cell) for cell in np.argwhere(observed(make_world(ROOM), log))] == seen


def test_a_log_sees_what_its_firings_see_together(make_world, rng):
    world = make_world(ROOM + ACROSS)
    truth = worlds.truth(world, resolution_m=0.25)
    poses = rng.uniform((1.2, 1.2, 0), (5.8, 3.8, 360), (12, 3))
    cone = ring(15, 3.0)
    together = truth.observable(log_at(cone, *poses))
    one_by_one = [truth.observable(log_at(cone, pose)) for pose in poses]
    assert (together == np.any(one_by_one, axis=0)).all()


def test_standing_still_changes_nothing(make_world):
    world = make_world(ROOM)
    truth = worlds.truth(world, resolution_m=0.01)
    moving, still = log_at(ring(15, 5), (2, 2, 3)), log_at(ring(15, 5), *[(2, 2, 3)] * 20_000)
    once = truth.observable(moving)
    assert (truth.observable(still) == once).all()


@pytest.mark.parametrize("name", ["clutter", "office", "round-room"])
def test_the_kernel_agrees_with_lines_of_sight_to_many_points(name, rng):
    world = worlds.load(name)
    truth = worlds.truth(world, resolution_m=0.1)
    solids = shapely.union_all([solid.outline for solid in world.solids])
    shapely.prepare(solids)
    half_angle, reach = math.radians(15), 2.5
    x, y, heading = world.start.x_m, world.start.y_m, world.start.heading_rad + 0.3
    seen = truth.observable(log_at(ring(15, reach), (x, y, math.degrees(heading))))
    # The twin: 100 points a cell, each in the cone or not, each in sight or not.
    parts = (np.arange(10) + 0.5) / 10 - 0.5
    for row, col in np.argwhere(truth.state == worlds.FREE):
        centre_x, centre_y = truth.grid.centre_of(row, col)
        px, py = (
            values.ravel() for values in np.meshgrid(centre_x + 0.1 * parts, centre_y + 0.1 * parts)
        )
        distance = np.hypot(px - x, py - y)
        off_axis = np.abs(
            np.remainder(np.arctan2(py - y, px - x) - heading + np.pi, 2 * np.pi) - np.pi
        )
        # Points at the very edge of the cone may fall between its rays.
        well_inside = (distance < reach - 0.02) & (off_axis < half_angle - 0.005)
        about_inside = (distance < reach + 0.02) & (off_axis < half_angle + 0.05)
        if about_inside.any():
            rays = shapely.linestrings(
                np.stack([np.full((100, 2), (x, y)), np.column_stack([px, py])], axis=1)
            )
            in_sight = ~shapely.intersects(solids, rays)
            if (well_inside & in_sight).sum() > 50:
                assert seen[row, col], (row, col)
            if seen[row, col] and about_inside.all():
                assert in_sight.any(), (row, col)
        elif distance.min() > 0.2:
            assert not seen[row, col], (row, col)
    assert seen.sum() > 50


def test_what_is_seen_through_a_slit_narrower_than_a_cell_stays_hidden(make_world):
    # Both walls of the slit touch its cell: no free cell connects one side with the other.
    upper = ACROSS.replace("across", "upper").replace("[6.5, 1], [6.5, 3]", "[6.5, 2.6], [6.5, 4]")
    lower = ACROSS.replace("[6.5, 3]", "[6.5, 2.4]")
    world = make_world(ROOM + lower + upper)
    assert world.faces.cast([[1.5, 2.5]], [[1.0, 0.0]], 20).distance_m == 8.5
    seen = observed(world, log_at(ring(1, 20), (1.5, 2.5, 0)))
    assert np.argwhere(seen).tolist() == [[2, col] for col in range(1, 7)]


def test_poses_outside_of_the_grid_do_no_harm(make_world):
    seen = observed(make_world(ROOM), log_at(ring(15, 3), (-50, -50, 0), (1e6, 3, 180)))
    assert not seen.any()


def test_a_log_without_truth_is_taken_from_where_its_odometry_says(make_world):
    room = make_world(ROOM)
    log = log_at(ring(15, 3), (1.5, 2.5, 0))
    real = SimpleNamespace(**{**vars(log), **vars(log.truth), "truth": None})
    assert np.array_equal(observed(room, real), observed(room, log))
    with pytest.raises(InputError, match=r"log has no truth .* needed for the true poses"):
        worlds.truth(room).observable(real, poses="true")
    with pytest.raises(InputError, match="poses 'gps' is unknown"):
        worlds.truth(room).observable(real, poses="gps")
