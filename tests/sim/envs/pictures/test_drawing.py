import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from PIL import ImageColor
from rooms import box, closed_room, world

from sim.envs.pictures.drawing import ROBOT_COLOURS, Scene, draw, frame_size
from sim.envs.pictures.layout import LEGEND, layout
from sim.robot.amigobot import BODY_RADIUS_M
from sonarmap import AMIGOBOT, Cause, GridSpec, InputError
from worlds import Pose, Solid
from worlds.colours import CAUSE_COLOURS, WALL_COLOUR

ROOM = closed_room()
GRID = GridSpec(0.1, (-2.0, -2.0), (40, 50))
NO_TRAIL = np.empty((0, 2))
NOTHING = np.full(8, np.inf)


def scene(room=ROOM, pose=(0.0, 0.0, 0.0), **given):
    arguments = {
        "believed": Pose(*pose),
        "ring": AMIGOBOT,
        "range_m": NOTHING,
        "cause": np.full(8, Cause.OUT_OF_RANGE, np.int8),
        "trail_xy_m": NO_TRAIL,
    }
    return Scene(world=room, pose=Pose(*pose), **arguments | given)


def heard(sonar, range_m, cause, **given):
    """Return a scene in which one sonar alone has an echo, or no echo of another cause."""
    ranges, causes = NOTHING.copy(), np.full(8, Cause.OUT_OF_RANGE, np.int8)
    ranges[sonar], causes[sonar] = range_m, cause
    return scene(range_m=ranges, cause=causes, **given)


def a_map(row=0, col=0, value=0.5):
    probability = np.full(GRID.shape, 0.5)
    probability[row, col] = value
    return {"probability": probability, "grid": GRID}


def colour(name):
    return np.array(ImageColor.getrgb(name))


def pixels_of(frame, *names):
    """Return (x, y) of the pixels that have exactly one of the colours, shape (n, 2)."""
    found = np.any([(frame == colour(name)).all(axis=2) for name in names], axis=0)
    return np.argwhere(found)[:, ::-1]


def robot_at(frame):
    return pixels_of(frame, *ROBOT_COLOURS).mean(axis=0)


def place(a_scene, x_m, y_m, *, panel="room_px"):
    """Return (x, y) of the pixel of a place."""
    plan = layout(a_scene.world, with_map=a_scene.grid is not None)
    at = plan.in_panel([x_m, y_m]) + getattr(plan, panel)
    return tuple(np.floor(at).astype(int))


def pixel(a_scene, x_m, y_m, **where):
    x, y = place(a_scene, x_m, y_m, **where)
    return draw(a_scene)[y, x].astype(int)


@pytest.mark.parametrize("with_map", [False, True])
@pytest.mark.parametrize(("x_m", "y_m"), [(1.0, 0.0), (0.0, 1.0), (-0.7, 0.4)])
def test_robot_moves_in_the_frame_as_it_moves_in_the_room(x_m, y_m, with_map):
    given = a_map() if with_map else {}
    scale = layout(ROOM, with_map=with_map).pixels_per_m
    moved = robot_at(draw(scene(pose=(x_m, y_m, 0), **given))) - robot_at(draw(scene(**given)))
    # Pixels count downwards.
    assert moved == pytest.approx([x_m * scale, -y_m * scale], abs=0.5)


def test_robot_has_the_size_that_collides():
    frame = draw(scene(pose=(0.3, 0.2, 1.0)))
    found = pixels_of(frame, *ROBOT_COLOURS)
    scale = layout(ROOM, with_map=False).pixels_per_m
    assert np.ptp(found, axis=0) + 1 == pytest.approx(2 * BODY_RADIUS_M * scale, abs=3)
    # Nothing else has its colours: all lie within the disc.
    away = np.linalg.norm(found - place(scene(), 0.3, 0.2), axis=1)
    assert away.max() <= BODY_RADIUS_M * scale + 1


@pytest.mark.parametrize("heading_rad", [0.0, 1.2, math.pi / 2, -2.5])
def test_arrow_shows_the_heading(heading_rad):
    frame = draw(scene(pose=(0, 0, heading_rad)), height_px=1200)
    arrow = pixels_of(frame, ROBOT_COLOURS[1])
    # Its tip is what is farthest from the middle of the robot.
    away = arrow - robot_at(frame)
    tip = away[np.linalg.norm(away, axis=1).argmax()]
    assert math.atan2(-tip[1], tip[0]) == pytest.approx(heading_rad, abs=0.1)


@pytest.mark.parametrize("cause", list(Cause))
def test_cone_has_the_colour_of_its_cause(cause):
    # Sonar 0 looks to the left from (0.07, 0.1); halfway to its echo is inside its cone.
    drawn = heard(0, 1.0, cause)
    where = (0.07, 0.6)
    tint = 255 - pixel(drawn, *where)
    expected = 255 - colour(CAUSE_COLOURS[cause])
    assert tint / tint.max() == pytest.approx(expected / expected.max(), abs=0.03)
    # Its far end is a line in the full colour.
    rim = pixels_of(draw(drawn), CAUSE_COLOURS[cause])
    nearest = np.abs(rim - place(drawn, 0.07, 1.1)).max(axis=1).min()
    assert nearest <= 1


def test_cone_without_an_echo_is_fainter_and_reaches_to_the_maximum_range():
    room = world(start=(0, 0, 0))  # nothing within 5 m
    echo, silent = heard(0, 2.9, Cause.DROPOUT, room=room), heard(0, np.inf, Cause.DROPOUT)
    silent = replace(silent, world=room)
    strong, faint = (255 - pixel(one, 0.07, 2.0) for one in (echo, silent))
    assert 0 < 2 * faint.max() < strong.max()
    assert faint.argmax() == strong.argmax()
    far_m = 0.1 + AMIGOBOT.range_max_m
    assert (pixel(silent, 0.07, far_m - 0.1) < 255).any()
    assert (pixel(silent, 0.07, far_m + 0.1) == 255).all()


def test_cone_of_a_reading_too_close_is_as_long_as_the_minimum_range():
    drawn = heard(0, -np.inf, Cause.DIRECT)
    rim = pixels_of(draw(drawn), CAUSE_COLOURS[Cause.DIRECT])
    x, y = place(drawn, 0.07, 0.1 + AMIGOBOT.range_min_m)
    assert (np.abs(rim - (x, y)).max(axis=1) <= 1).any()


def test_size_depends_on_the_room_and_on_having_a_map_alone():
    for given, with_map in (({}, False), (a_map(), True)):
        size = (*frame_size(ROOM, with_map=with_map), 3)
        busy = heard(2, 1.0, Cause.BOUNCE, goal_xy_m=(1.0, 1.0), caption="step 1", **given)
        far_off = replace(
            busy, pose=Pose(90, -50, 7), believed=Pose(-1e6, 2e6, 0), caption="x" * 999
        )
        for drawn in (scene(**given), busy, far_off):
            frame = draw(drawn)
            assert frame.shape == size
            assert frame.dtype == np.uint8


@pytest.mark.parametrize("bounds_m", [(0, 0, 1, 40), (0, 0, 40, 1), (-3, -2, 90, 80)])
@pytest.mark.parametrize("height_px", [160, 480, 1080])
def test_any_room_fits_its_panel_and_the_legend_its_frame(bounds_m, height_px):
    room = replace(ROOM, bounds_m=bounds_m)
    for with_map in (False, True):
        plan = layout(room, with_map=with_map, height_px=height_px)
        corners = plan.in_panel([bounds_m[:2], bounds_m[2:]])
        assert (corners >= 0).all()
        assert (corners <= plan.panel_px).all()
        assert plan.size_px[1] == height_px
        assert plan.size_px[0] < 4 * height_px
        frame = draw(scene(room, **(a_map() if with_map else {})), height_px=height_px)
        below = frame[plan.room_px[1] + plan.panel_px[1] + 1 :]
        has_legend = len(plan.legend_px) > 0
        assert has_legend or height_px == 160
        for _, name in LEGEND[: len(Cause)]:
            assert (len(pixels_of(below, name)) > 10) == has_legend
        # The last words are not cut off: the last columns and rows are empty.
        assert (below[:, -2:] == 255).all()
        assert (below[-1:] == 255).all()


def test_both_panels_have_one_scale_and_the_map_its_cells_in_their_places():
    # Far from the middle in both axes, and off the diagonal.
    row, col = GRID.cell_of(-1.25, 0.75)
    for value, shade in ((1.0, 0), (0.0, 255), (0.5, 128)):
        drawn = scene(**a_map(row, col, value))
        assert pixel(drawn, -1.25, 0.75, panel="map_px") == pytest.approx(shade, abs=1)
    occupied = scene(**a_map(row, col, 1.0))
    for dx, dy in ((0.1, 0), (-0.1, 0), (0, 0.1), (0, -0.1)):
        assert (pixel(occupied, -1.25 + dx, 0.75 + dy, panel="map_px") > 100).all()
    # The cell is as large as its side in the scale of the room.
    plan = layout(ROOM, with_map=True)
    map_panel = draw(replace(occupied, caption=""))[:, plan.map_px[0] :]
    side = np.ptp(pixels_of(map_panel[plan.map_px[1] : -60], "#000000"), axis=0) + 1
    assert side == pytest.approx(0.1 * plan.pixels_per_m, abs=1.5)


def test_map_shows_the_robot_where_odometry_believes_it_to_be():
    given = a_map()
    here, there = (draw(scene(believed=Pose(x, 0, 0), **given)) for x in (0.0, 1.0))
    left = layout(ROOM, with_map=True).map_px[0]
    x, y = place(scene(**given), 1.0, 0.0, panel="map_px")
    changed = np.argwhere((here != there).any(axis=2))[:, ::-1]
    assert (np.abs(changed - (x, y)).max(axis=1) < 2).any()
    # The true robot is in the other panel.
    assert pixels_of(here, *ROBOT_COLOURS)[:, 0].max() < left


def test_walls_are_dark_and_what_they_surround_is_not():
    ring_wall = Solid(
        "ring", ROOM.solids[0].material, 1.0, shapely.box(-2, -2, 2, 2) - shapely.box(-1, -1, 1, 1)
    )
    drawn = scene(world(ring_wall))
    # Behind the robot, between two cones.
    assert (pixel(drawn, -1.5, 0.0) == colour(WALL_COLOUR)).all()
    assert (pixel(drawn, -0.9, 0.0) == 255).all()
    # Thinner than a pixel, yet there.
    board = scene(world(box("board", -1, 3.0, 1, 3.001)))
    assert (pixel(board, 0.0, 3.0) < 200).all()


def test_trail_and_goal_are_shown_at_their_places():
    trail = np.array([[-1.0, -1.0], [1.0, -1.0]])
    drawn = scene(trail_xy_m=trail, goal_xy_m=(-1.0, 1.0))
    assert pixel(drawn, 0.5, -1.0)[2] > pixel(drawn, 0.5, -1.0)[0] + 50  # blue
    assert (pixel(drawn, -1.0, 1.0) < 50).all()
    for k in (0, 1):
        draw(scene(trail_xy_m=trail[:k]))


def test_drawing_is_repeatable_and_changes_nothing():
    drawn = heard(
        3, 0.8, Cause.CROSSTALK, trail_xy_m=np.zeros((3, 2)), caption="a", **a_map(3, 4, 1)
    )
    arrays = (drawn.range_m, drawn.cause, drawn.trail_xy_m, drawn.probability)
    before = [array.copy() for array in arrays]
    for array in arrays:
        array.flags.writeable = False
    first = draw(drawn)
    kept = first.copy()
    first[:] = 0  # a frame belongs to whom it is given
    draw(heard(1, 1.2, Cause.BOUNCE))
    assert np.array_equal(draw(drawn), kept)
    for array, old in zip(arrays, before, strict=True):
        assert np.array_equal(array, old)


def test_caption_too_long_for_the_frame_ends_in_dots_and_a_short_one_is_shown():
    empty, short, long, longer = (
        draw(scene(caption=text)) for text in ("", "step 7", "x" * 300, "x" * 400)
    )
    assert not np.array_equal(empty, short)
    assert (long[:, -3:] == 255).all()
    assert np.array_equal(empty[30:], longer[30:])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"range_m": np.ones(7)}, r"range_m must have shape \(8,\), got \(7,\)"),
        ({"cause": np.zeros((8, 1), np.int8)}, r"cause must have shape \(8,\), got \(8, 1\)"),
        ({"range_m": np.full(8, np.nan)}, r"range_m\[0\] must be metres or infinite, got nan"),
        ({"cause": np.full(8, 9)}, r"cause\[0\] must be a sonarmap.Cause, got 9"),
        ({"trail_xy_m": np.empty(0)}, r"trail_xy_m must have shape \(k, 2\), got \(0,\)"),
        ({"trail_xy_m": np.ones((4, 3))}, r"trail_xy_m must have shape \(k, 2\), got \(4, 3\)"),
        ({"grid": GRID}, r"probability and grid must be given together"),
        ({"probability": np.ones((40, 50))}, r"probability and grid must be given together"),
        (
            {"grid": GRID, "probability": np.ones((50, 40))},
            r"probability must have the shape of its grid, \(40, 50\), got \(50, 40\)",
        ),
        ({"caption": "one\ntwo"}, r"caption must be one line, got 'one\\ntwo'"),
    ],
)
def test_bad_scenes_are_refused(change, message):
    with pytest.raises(InputError, match=message):
        scene(**change)


@pytest.mark.parametrize(
    ("height_px", "message"),
    [
        (159, r"height_px must be within \[160, 4320\], got 159"),
        (5000, r"height_px must be within \[160, 4320\], got 5000"),
        (200.5, r"height_px must be a whole number, got 200.5"),
        (math.nan, r"height_px must be within \[160, 4320\], got nan"),
        ("tall", r"height_px must be a number, got 'tall'"),
    ],
)
def test_bad_heights_are_refused(height_px, message):
    with pytest.raises(InputError, match=message):
        draw(scene(), height_px=height_px)
    with pytest.raises(InputError, match=message):
        frame_size(ROOM, with_map=True, height_px=height_px)
