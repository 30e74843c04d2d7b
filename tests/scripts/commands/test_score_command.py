"""Maps of other makers, scored."""

import json
import math

import numpy as np
import pytest
from PIL import Image

import sonarmap as sm
import worlds
from sonarbed.cli import main

OFFICE = worlds.load("office")


def write_ros(folder, grid, state, *, yaw_rad=0.0, image="map.png"):
    """Write a ROS map that states the truth, hidden cells unknown."""
    grey = np.array([254, 0, 205], np.uint8)[state]
    folder.mkdir()
    Image.fromarray(grey[::-1]).save(folder / image)
    x_m, y_m = grid.origin_xy_m
    (folder / "map.yaml").write_text(
        f"image: {image}\nresolution: {grid.resolution_m}\norigin: [{x_m}, {y_m}, {yaw_rad}]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def scored(run, line):
    return json.loads(run(f"score {line} --world office --json"))


GRIDS = {
    "the room": sm.GridSpec.covering(*OFFICE.bounds_m, 0.05),
    "larger": sm.GridSpec(0.05, (-3.0, -4.0), (240, 300)),
    "on no lattice of ours": sm.GridSpec(0.073, (-0.9, -2.111), (120, 140)),
    "cut out, without the start": sm.GridSpec(0.05, (2.0, 1.0), (60, 60)),
}


@pytest.mark.parametrize("grid", GRIDS.values(), ids=GRIDS)
def test_a_perfect_ros_map_has_a_perfect_score(run, tmp_path, grid):
    state = worlds.truth(OFFICE, grid).state
    write_ros(tmp_path / "theirs", grid, state)
    for line in ("theirs/map.yaml", "theirs"):
        scores = scored(run, line)
        assert scores["counts"]["cells"] == (state != worlds.HIDDEN).sum()
        assert scores["map_score"] == pytest.approx(1 + math.log2(0.99))
        assert scores["f1_1_cell"] == scores["coverage"] == 1


def test_a_map_scores_alike_by_its_yaml_and_by_its_folder_but_for_its_shades(run, rng, tmp_path):
    grid = GRIDS["the room"]
    states = rng.choice([0.01, 0.5, 0.99], grid.shape)
    sm.OccupancyMap.from_probability(grid, states, states != 0.5).save(tmp_path / "ours")
    assert scored(run, "ours") == scored(run, "ours/map.yaml")


@pytest.mark.parametrize(("moved_m", "says"), [(0.0, False), (0.5, False), (4.0, True)])
def test_a_map_whose_frame_is_not_the_rooms_is_scored_with_a_note(capsys, tmp_path, moved_m, says):
    own = GRIDS["the room"]
    state = worlds.truth(OFFICE, own).state
    x_m, y_m = own.origin_xy_m
    write_ros(tmp_path / "moved", sm.GridSpec(0.05, (x_m + moved_m, y_m), own.shape), state)
    assert main(["score", "moved", "--world", "office", "--json"]) == 0
    out, err = capsys.readouterr()
    told = json.loads(out)
    assert (told["known_outside_share"] > 0.25) == says
    assert ("notes" in told) == says
    if says:
        share = told["known_outside_share"]
        assert f"{share:.0%} of what the map knows lies outside of the bounds of 'office'" in err
        assert told["notes"] == [err.strip()]
    else:
        assert err == ""


def test_a_turned_map_is_resampled_and_said_on_standard_error(capsys, tmp_path):
    # Turned by a quarter about the room's corner: what was east of it is north of it now.
    grid = sm.GridSpec(0.05, (-0.5, -1.5), (160, 180))
    state = np.rot90(worlds.truth(OFFICE, grid).state, 1)  # clockwise, for row 0 is the lowest
    turned = sm.GridSpec(0.05, (-0.5 + 180 * 0.05, -1.5), state.shape)
    write_ros(tmp_path / "theirs", turned, state, yaw_rad=math.pi / 2)
    assert main(["score", "theirs/map.yaml", "--world", "office", "--json"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["f1_1_cell"] == 1
    assert err == (
        "theirs/map.yaml: the map is turned by 90 degrees; its 180 x 160 cells were resampled, to "
        "the nearest cell, to 160 x 180 along the axes\n"
    )


def test_a_map_that_lies_elsewhere_or_is_none(refused, tmp_path):
    grid = sm.GridSpec(0.05, (50.0, 50.0), (20, 20))
    write_ros(tmp_path / "far", grid, np.zeros(grid.shape, int))
    assert refused("score far/map.yaml --world office") == (
        "grid must hold the start [6.8, -0.6] of 'office', got extent_m (50.0, 51.0, 50.0, 51.0), "
        "wholly outside of the room's bounds_m [-0.1, -1.3, 8.1, 6.1]"
    )
    assert refused("score far/map.png --world office") == (
        "far/map.png: is an image: give the map.yaml that it belongs to"
    )
    (tmp_path / "far" / "map.png").unlink()
    assert refused("score far/map.yaml --world office") == (
        "far/map.yaml: image: far/map.png: no such file"
    )
    assert refused("score gone.yaml --world office") == "gone.yaml: no such file"
