import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sonarmap as sm

resolutions = st.sampled_from([0.01, 0.05, 0.1, 0.25, 0.3, 1.0])
coordinates = st.floats(-50, 50)


@st.composite
def grids(draw):
    return sm.GridSpec(
        draw(resolutions),
        (draw(coordinates), draw(coordinates)),
        (draw(st.integers(1, 200)), draw(st.integers(1, 200))),
    )


@given(grids(), st.data())
@settings(derandomize=True)
def test_cell_to_centre_to_cell_is_the_same_cell(grid, data):
    row = data.draw(st.integers(-5, grid.rows + 5))
    col = data.draw(st.integers(-5, grid.cols + 5))
    assert grid.cell_of(*grid.centre_of(row, col)) == (row, col)


@given(grids(), coordinates, coordinates)
@settings(derandomize=True)
def test_a_point_is_at_most_half_a_cell_from_the_centre_of_its_cell(grid, x_m, y_m):
    centre_x_m, centre_y_m = grid.centre_of(*grid.cell_of(x_m, y_m))
    half = grid.resolution_m / 2 * (1 + 1e-9) + 1e-12
    assert abs(centre_x_m - x_m) <= half
    assert abs(centre_y_m - y_m) <= half


# The grid of these: cells of 0.5 m, lower-left corner at (-1, -2), 8 rows of 4 columns.
GRID = sm.GridSpec(0.5, (-1.0, -2.0), (8, 4))


@pytest.mark.parametrize(
    ("x_m", "y_m", "row", "col"),
    [
        # inside, x gives the column and y the row
        (-0.75, -1.75, 0, 0),
        (0.9, -1.9, 0, 3),
        (-0.9, 1.9, 7, 0),
        # borders belong to the cell above and to the right of them
        (-1.0, -2.0, 0, 0),
        (-0.5, -2.0, 0, 1),
        (-1.0, -1.5, 1, 0),
        (math.nextafter(-0.5, -1), -2.0, 0, 0),
        # left of and below the grid: floor, not truncation towards 0
        (-1.1, -1.75, 0, -1),
        (-1.6, -2.6, -2, -2),
        # the upper and right border lie outside
        (1.0, 2.0, 8, 4),
    ],
)
def test_cell_of_a_point(x_m, y_m, row, col):
    assert GRID.cell_of(x_m, y_m) == (row, col)


def test_points_become_cells_in_arrays_of_any_shape():
    x_m, y_m = np.meshgrid([-0.75, 0.25, 0.75], [-1.75, 1.75])
    row, col = GRID.cell_of(x_m, y_m)
    assert row.tolist() == [[0, 0, 0], [7, 7, 7]]
    assert col.tolist() == [[0, 2, 3], [0, 2, 3]]


@pytest.mark.parametrize("nowhere", [math.nan, math.inf, -math.inf, 1e300])
def test_points_that_are_nowhere_lie_outside_of_every_grid(nowhere):
    row, col = GRID.cell_of([nowhere, 0.0], [0.0, nowhere])
    assert not GRID.contains(row, col).any()


def test_contains_knows_all_four_sides():
    row = [0, 7, 8, -1, 0, 0]
    col = [0, 3, 0, 0, 4, -1]
    assert GRID.contains(row, col).tolist() == [True, True, False, False, False, False]


def test_facts_that_follow_from_the_geometry():
    assert (GRID.rows, GRID.cols) == (8, 4)
    assert GRID.cell_area_m2 == 0.25
    assert GRID.extent_m == (-1.0, 1.0, -2.0, 2.0)


def test_a_grid_is_a_value():
    assert sm.GridSpec(0.5, (-1, -2), (8, 4)) == GRID
    assert len({GRID, sm.GridSpec(0.5, (-1, -2), (8, 4))}) == 1
    with pytest.raises(AttributeError):
        GRID.resolution_m = 1.0


def test_covering_is_the_smallest_aligned_grid_over_a_box():
    assert sm.GridSpec.covering(-0.3, 0.1, 0.9, 1.0, 0.25) == sm.GridSpec(0.25, (-0.5, 0), (4, 6))


def test_covering_adds_no_cell_for_a_rounding_error():
    # 0.3 / 0.1 is 2.9999999999999996, 2.1 / 0.3 is 7.000000000000001.
    assert sm.GridSpec.covering(0.3, 0.3, 0.7, 0.7, 0.1).shape == (4, 4)
    assert sm.GridSpec.covering(0.0, 0.0, 2.1, 2.1, 0.3).shape == (7, 7)


def test_covering_a_point_is_one_cell():
    grid = sm.GridSpec.covering(0.3, -0.3, 0.3, -0.3, 0.25)
    assert grid == sm.GridSpec(0.25, (0.25, -0.5), (1, 1))
    assert sm.GridSpec.covering(0.5, 0.5, 0.5, 0.5, 0.25).shape == (1, 1)


@given(coordinates, coordinates, st.floats(0, 5), st.floats(0, 5), resolutions)
@settings(derandomize=True)
def test_covering_holds_its_box_on_borders_that_are_multiples(x_m, y_m, width, height, size):
    grid = sm.GridSpec.covering(x_m, y_m, x_m + width, y_m + height, size)
    left, right, bottom, top = grid.extent_m
    slack = 1e-8 * size + 1e-12
    assert left - slack <= x_m < left + size + slack
    assert bottom - slack <= y_m < bottom + size + slack
    assert right + slack >= x_m + width
    assert top + slack >= y_m + height
    for corner in grid.origin_xy_m:
        assert corner / size == pytest.approx(round(corner / size), abs=1e-6)


def test_two_grids_of_one_resolution_lie_cell_on_cell():
    a = sm.GridSpec.covering(-3.21, 0.4, 1.0, 1.0, 0.1)
    b = sm.GridSpec.covering(-1.77, -9.4, 1.0, 1.0, 0.1)
    apart = (np.array(a.origin_xy_m) - b.origin_xy_m) / 0.1
    assert apart == pytest.approx(np.round(apart), abs=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"resolution_m": 0}, "resolution_m must be > 0, got 0"),
        ({"resolution_m": -0.1}, "resolution_m must be > 0, got -0.1"),
        ({"resolution_m": math.nan}, "resolution_m must be > 0, got nan"),
        ({"resolution_m": "fine"}, "resolution_m must be a number, got 'fine'"),
        ({"origin_xy_m": (math.inf, 0)}, r"origin_xy_m\[0\] must be a finite number, got inf"),
        ({"origin_xy_m": (0, math.nan)}, r"origin_xy_m\[1\] must be a finite number, got nan"),
        ({"origin_xy_m": (0, 0, 0)}, r"origin_xy_m must be two numbers, got \(0, 0, 0\)"),
        ({"shape": (0, 4)}, r"shape must be at least \(1, 1\), got \(0, 4\)"),
        ({"shape": (4, -1)}, r"shape must be at least \(1, 1\), got \(4, -1\)"),
        ({"shape": (1.5, 4)}, "shape must be whole numbers, got 1.5"),
        ({"shape": 4}, "shape must be two numbers, got 4"),
        ({"shape": (10**5, 10**5)}, "shape must have at most 400000000 cells"),
    ],
)
def test_bad_geometry_is_refused(change, message):
    fields = {"resolution_m": 0.1, "origin_xy_m": (0, 0), "shape": (2, 2)} | change
    with pytest.raises(sm.InputError, match=f"^{message}"):
        sm.GridSpec(**fields)


@pytest.mark.parametrize(
    ("box", "message"),
    [
        ((math.nan, 0, 1, 1), "x_min_m must be a finite number, got nan"),
        ((0, 0, 1, math.inf), "y_max_m must be a finite number, got inf"),
        ((2, 0, 1, 1), "x_min_m must be <= x_max_m, got 2 and 1"),
        ((0, 3, 1, 1), "y_min_m must be <= y_max_m, got 3 and 1"),
        ((0, 0, 1e6, 1e6), "shape must have at most 400000000 cells"),
    ],
)
def test_bad_boxes_are_refused(box, message):
    with pytest.raises(sm.InputError, match=f"^{message}"):
        sm.GridSpec.covering(*box, 0.1)
