import math

import numpy as np
import pytest
import shapely
from support import cells

import worlds
from sonarmap import GridSpec, InputError

SIGNS = np.array([".", "#", "?"])

# Cells of 1 m. Hidden are the middle of the block, the closet, and the walls' outer half.
ROOM = """
bounds_m = [0, 0, 13, 10]
start = { x_m = 2.5, y_m = 2.5, heading_deg = 0 }

[[wall]]
name = "walls"
points_m = [[2, 2], [11, 2], [11, 8], [2, 8]]
closed = true
side = "right"
thickness_m = 2
height_m = 2
material = "brick"

[[wall]]
name = "closet"
points_m = [[8, 8], [8, 4], [11, 4]]
side = "left"
thickness_m = 1
height_m = 2
material = "brick"

[[box]]
name = "block"
centre_m = [4.5, 5.5]
size_m = [3, 3]
height_m = 2
material = "wood"

[[pillar]]
name = "post"
centre_m = [6.9, 2.5]
radius_m = 0.2
height_m = 2
material = "metal"
"""
TRUTH = """
    ?????????????
    ?########????
    ?#......#????
    ?#.###..#????
    ?#.#?#..#????
    ?#.###..####?
    ?#.........#?
    ?#....##...#?
    ?###########?
    ?????????????
"""

OPEN = """
bounds_m = [0, 0, 5, 4]
start = { x_m = 0.5, y_m = 0.5, heading_deg = 0 }
"""


def box(centre, size, heading_deg=0):
    return f"""
[[box]]
name = "box at {centre}"
centre_m = {centre}
size_m = {size}
heading_deg = {heading_deg}
height_m = 1
material = "wood"
"""


def pillar(centre, radius):
    return f"""
[[pillar]]
name = "pillar"
centre_m = {centre}
radius_m = {radius}
height_m = 1
material = "wood"
"""


def drawn(truth):
    return SIGNS[truth.state]


def plain_touched(world, grid):
    """The slow twin: the area of every solid in every cell, one cell at a time."""
    touched = np.zeros(grid.shape, bool)
    half = grid.resolution_m / 2
    for row in range(grid.rows):
        for col in range(grid.cols):
            x, y = grid.centre_of(row, col)
            cell = shapely.box(x - half, y - half, x + half, y + half)
            touched[row, col] = any(
                solid.outline.intersection(cell).area > 1e-9 for solid in world.solids
            )
    return touched


def test_the_truth_of_a_room(make_world):
    truth = worlds.truth(make_world(ROOM), resolution_m=1.0)
    assert (drawn(truth) == cells(TRUTH)).all()


@pytest.mark.parametrize(
    ("solids", "picture"),
    [
        # A face on the border of two cells touches only the cell behind it.
        (
            box([2.5, 2.0], [1, 2]),
            """
            .....
            ..#..
            ..#..
            .....
            """,
        ),
        # ... and one that passes the border by a millimetre touches the next cell too.
        (
            box([2.5, 2.0], [1.002, 2]),
            """
            .....
            .###.
            .###.
            .....
            """,
        ),
        # The circle misses the corner that its bounding box covers.
        (
            pillar([1.9, 1.9], 0.13),
            """
            .....
            ..#..
            .##..
            .....
            """.replace("..#..", ".#...", 1),
        ),
        # Only sides connect: what two solids that meet at a corner shut off is hidden.
        (
            "".join(
                box(centre, [1, 1])
                for centre in (
                    *([1.5, 3.5], [0.5, 2.5]),
                    *([3.5, 3.5], [4.5, 2.5]),
                    *([3.5, 0.5], [4.5, 1.5]),
                )
            ),
            """
            ?#.#?
            #...#
            ....#
            ...#?
            """,
        ),
        # A diamond of which the tips reach the middles of four sides.
        (
            box([2.5, 2.5], [1.4, 1.4], 45),
            """
            ..#..
            .###.
            ..#..
            .....
            """,
        ),
    ],
)
def test_which_cells_a_solid_touches(make_world, solids, picture):
    truth = worlds.truth(make_world(OPEN + solids), resolution_m=1.0)
    assert (drawn(truth) == cells(picture)).all(), drawn(truth)[::-1]


def test_a_pillar_is_a_circle_and_not_the_polygon_of_its_outline(make_world):
    # The circle reaches the corner at (3, 3) between two corners of the polygon.
    angle = math.radians(45 + 90 / 64)
    centre = [3 - 0.9999 * math.cos(angle), 3 - 0.9999 * math.sin(angle)]
    world = make_world(OPEN + pillar(centre, 1.0))
    assert not world.solids[0].outline.intersects(shapely.box(3, 3, 4, 4))
    assert worlds.truth(world, resolution_m=1.0).state[3, 3] == worlds.OCCUPIED


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_quarter_turn_of_the_world_turns_the_truth(make_world, turns):
    world = make_world(ROOM)
    before = worlds.truth(world, resolution_m=1.0)
    after = worlds.truth(world.transformed(quarter_turns=turns), resolution_m=1.0)
    # Row 0 is the lowest: seen as an array, counter-clockwise turns the other way.
    assert (after.state == np.rot90(before.state, -turns)).all()


@pytest.mark.parametrize("name", ["clutter", "office", "corridor", "thesis-exp2"])
def test_turned_and_mirrored_rooms_have_turned_and_mirrored_truth(name):
    world = worlds.load(name)
    # A grid whose borders are the same under both, so that cells fall on cells.
    grid = GridSpec.covering(-16, -16, 16, 16, 0.1)
    state = worlds.truth(world, grid).state
    turned = worlds.truth(world.transformed(quarter_turns=1), grid).state
    assert (turned == np.rot90(state, -1)).all()
    assert (worlds.truth(world.mirrored(), grid).state == state[::-1]).all()


@pytest.mark.parametrize("name", ["clutter", "office", "round-room"])
def test_the_raster_agrees_with_its_slow_twin(name):
    world = worlds.load(name)
    truth = worlds.truth(world, resolution_m=0.1)
    touched = plain_touched(world, truth.grid)
    assert (touched[truth.state == worlds.OCCUPIED]).all()
    assert not touched[truth.state == worlds.FREE].any()
    free = np.pad(truth.state == worlds.FREE, 1)
    # Nothing that was left HIDDEN should have been OCCUPIED.
    beside = sum(
        free[down : down + truth.grid.rows, right : right + truth.grid.cols]
        for down in range(3)
        for right in range(3)
    )
    assert not (touched & (beside > 0) & (truth.state == worlds.HIDDEN)).any()


def test_any_grid_over_the_start_will_do(make_world):
    world = make_world(ROOM)
    whole = worlds.truth(world, resolution_m=1.0)
    wider = worlds.truth(world, GridSpec(1.0, (-40.0, -3.0), (20, 90)))
    assert (wider.state[3:13, 40:53] == whole.state).all()
    narrow = worlds.truth(world, GridSpec(1.0, (2.0, 2.0), (3, 3)))
    assert (narrow.state == [[0, 0, 0], [0, 0, 0], [0, 1, 1]]).all()


def test_the_default_grid_covers_the_bounds():
    truth = worlds.truth(worlds.load("thesis-exp1"))
    assert truth.grid == GridSpec.covering(-0.1, -0.1, 2.7, 2.3, 0.05)
    assert truth.state.dtype == np.uint8


def test_free_space_is_that_of_the_room_to_the_cell():
    truth = worlds.truth(worlds.load("thesis-exp1"), resolution_m=0.05)
    assert (truth.state == worlds.FREE).sum() == 52 * 44
    assert (truth.state == worlds.OCCUPIED).sum() == 2 * (54 + 44)


def test_the_numbers_of_the_states():
    assert (worlds.FREE, worlds.OCCUPIED, worlds.HIDDEN) == (0, 1, 2)


@pytest.mark.parametrize(
    ("grid", "message"),
    [
        (GridSpec(0.05, (10, 10), (5, 5)), r"grid must hold the start \[1.3, 0.706\] of 'thesis-"),
        (
            GridSpec(0.05, (-9, 0), (50, 50)),
            r"got extent_m \(-9.0, -6.5, 0.0, 2.5\), wholly outside of the room's bounds_m",
        ),
        (GridSpec(3.0, (-1, -4.1), (1, 1)), r"grid must hold the start .* wholly outside"),
        (
            GridSpec(3.0, (-1, 1.9), (1, 1)),
            r"resolution_m must leave the start .* free cell, got 3",
        ),
        (
            GridSpec(3.0, (-1, -1), (5, 5)),
            r"resolution_m must leave the start .* a free cell, got 3",
        ),
    ],
)
def test_a_grid_without_a_free_start_is_refused(grid, message):
    with pytest.raises(InputError, match=message):
        worlds.truth(worlds.load("thesis-exp1"), grid)


# What a map may be cut out to, in cells of 10 cm: (row, col, rows, cols). The start lies elsewhere.
CUTS = {
    "inside": (30, 10, 20, 30),
    "one cell": (40, 45, 1, 1),
    "over the northern border": (60, -15, 40, 120),
    "over the western border": (15, -30, 50, 40),
    "more than the room, but not its south": (14, -20, 80, 140),
}


@pytest.mark.parametrize("cut", CUTS.values(), ids=CUTS)
def test_a_grid_without_the_start_is_a_part_of_the_whole(cut):
    office = worlds.load("office")
    row, col, rows, cols = cut
    margin = 100
    whole = GridSpec(0.1, (-0.1 - margin * 0.1, -1.3 - margin * 0.1), (300, 300))
    part = GridSpec(0.1, (-0.1 + col * 0.1, -1.3 + row * 0.1), (rows, cols))
    truth = worlds.truth(office, part)
    assert truth.grid == part
    inside = slice(margin + row, margin + row + rows), slice(margin + col, margin + col + cols)
    assert (truth.state == worlds.truth(office, whole).state[inside]).all()


@pytest.mark.parametrize("resolution_m", [0.0, -0.05, float("nan")])
def test_a_resolution_is_positive(resolution_m):
    with pytest.raises(InputError, match="resolution_m must be > 0"):
        worlds.truth(worlds.load("l-shape"), resolution_m=resolution_m)


def test_the_truth_is_saved_whole(tmp_path):
    truth = worlds.truth(worlds.load("thesis-exp1"))
    path = truth.save(tmp_path / "new" / "folder")
    assert [file.name for file in path.parent.iterdir()] == ["truth.npz"]
    with np.load(path) as saved:
        assert (saved["state"] == truth.state).all()
        assert saved["resolution_m"] == 0.05
        assert saved["origin_xy_m"] == pytest.approx((-0.1, -0.1))


def test_the_truth_cannot_be_changed():
    truth = worlds.truth(worlds.load("thesis-exp1"))
    with pytest.raises(ValueError, match="read-only"):
        truth.state[0, 0] = worlds.FREE
