"""Walls as pictures, counted by hand, and the maps that every score must put in their place."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from support import cells

import sonarmap as sm

SIZE_M = 0.1
BELIEF = {".": 0.1, "?": 0.5, "#": 0.9, "+": 0.7}
STATE = {".": 0, "#": 1, "?": 2}


def truth_of(drawing):
    state = np.vectorize(STATE.get)(cells(drawing)).astype(np.uint8)
    return SimpleNamespace(grid=sm.GridSpec(SIZE_M, (0.0, 0.0), state.shape), state=state)


def map_of(p):
    return sm.OccupancyMap.from_probability(sm.GridSpec(SIZE_M, (0.0, 0.0), p.shape), p)


def score(map_drawing, truth_drawing):
    p = np.vectorize(BELIEF.get)(cells(map_drawing)).astype(float)
    return sm.score_map(map_of(p), truth_of(truth_drawing))


WALL = """
.....
#####
.....
.....
"""


@pytest.mark.parametrize(
    ("drawing", "expected"),
    [
        # All five within one cell, each claimed once: every mark above the threshold hits.
        ("#####\n.....\n.....\n.....", 1.0),
        ("##...\n..###\n.....\n.....", 1.0),
        # Two rows of marks: ten claim five; the lower row is less sure and claims nothing.
        ("#####\n+++++\n.....\n.....", 1.0),
        # The sure ones lie too far away: five of ten marks hit.
        ("+++++\n.....\n.....\n#####", None),
    ],
)
def test_a_wall_is_hit_within_one_cell_and_once(drawing, expected):
    s = score(drawing, WALL)
    if expected is None:
        # Precision at recall k/5: k hits among 5 + k marks.
        expected = sum(k / (5 + k) for k in range(1, 6)) / 5
        # All five of equal probability fall into one class: precision 5 of 10.
        expected = 0.5
    assert s.tolerant_average_precision == pytest.approx(expected)


def test_lengths_counted_by_hand():
    s = score("#....\n##...\n.....\n.....", WALL)
    # Three cells of the wall have a mark within one cell: 0, 1, and 2 beside the mark on 1.
    assert s.wall_gap_m == pytest.approx(2 * SIZE_M)
    # Within 20 cm: three marks, of the wall 0 to 3.
    assert s.thickness_m == pytest.approx(SIZE_M * 3 / 4)


def test_baddeleys_distance_counted_by_hand():
    s = score("#....", "..#..")
    # Distances 0 1 2 3 4 and 2 1 0 1 2 cells.
    differences = np.array([2, 0, 2, 2, 2]) * SIZE_M
    assert s.baddeley_m == pytest.approx(math.sqrt((differences**2).mean()))
    # Without a wall all is farther than the cut.
    s = score(".....", "..#..")
    assert s.baddeley_m == pytest.approx(
        math.sqrt(((0.5 - np.array([2, 1, 0, 1, 2]) * 0.1) ** 2).mean())
    )


def test_image_similarity_counted_by_hand():
    s = score("#...", "..#.")
    # Occupied: 2 both ways. Free of the map: cells 1, 2, 3 to the truth's 0, 1, 3: 0, 1, 0; of the
    # truth: 0 to 1, 0, 0.
    assert s.image_dissimilarity == pytest.approx(2 + 2 + 1 / 3 + 1 / 3)
    assert math.isinf(score("....", "..#.").image_dissimilarity)
    assert score("..#.", "..#.").image_dissimilarity == 0


def random_pair(rng, shape=(14, 17)):
    p = rng.uniform(0.001, 0.999, shape)
    state = rng.choice([0, 0, 0, 1, 2], size=shape).astype(np.uint8)
    return map_of(p), SimpleNamespace(grid=sm.GridSpec(SIZE_M, (0.0, 0.0), shape), state=state)


def test_turns_and_mirrors_change_nothing(rng):
    m, truth = random_pair(rng)
    expected = sm.score_map(m, truth)
    for move in (np.flipud, np.fliplr, np.rot90):
        state = move(truth.state)
        grid = sm.GridSpec(SIZE_M, (0.0, 0.0), state.shape)
        moved = sm.OccupancyMap.from_probability(grid, move(m.probability))
        found = sm.score_map(moved, SimpleNamespace(grid=grid, state=state))
        for name in ("tolerant_average_precision", "wall_gap_m", "thickness_m", "baddeley_m"):
            assert getattr(found, name) == pytest.approx(getattr(expected, name)), name
        assert found.image_dissimilarity == pytest.approx(expected.image_dissimilarity)


def test_scores_of_two_rooms_add_up(rng):
    pairs = [random_pair(rng), random_pair(rng, (9, 30))]
    both = sum((sm.score_map(*pair) for pair in pairs[1:]), sm.score_map(*pairs[0]))
    one, other = (sm.score_map(*pair) for pair in pairs)
    n, k = one.cells, other.cells
    expected = math.sqrt((one.baddeley_m**2 * n + other.baddeley_m**2 * k) / (n + k))
    assert both.baddeley_m == pytest.approx(expected)
    assert both.wall_gap_m == pytest.approx(one.wall_gap_m + other.wall_gap_m)
    low, high = sorted(each.tolerant_average_precision for each in (one, other))
    assert low - 0.05 <= both.tolerant_average_precision <= high + 0.05
    # It forgives what plain average precision does not.
    assert one.tolerant_average_precision > one.average_precision


ROOM = """
##########
#........#
#........#
#...##...#
#...##...#
#........#
#........#
##########
"""


def pathological():
    truth = truth_of(ROOM)
    walls = truth.state == 1
    perfect = np.where(walls, 0.99, 0.01)
    missing = perfect.copy()
    missing[:, 0] = 0.01
    return truth, {
        "perfect": perfect,
        "all free": np.full(walls.shape, 0.01),
        "all occupied": np.full(walls.shape, 0.99),
        "all 0.5": np.full(walls.shape, 0.5),
        "sheet": np.full(walls.shape, walls.mean()),
        "shifted": np.roll(perfect, 1, axis=1),
        "wall missing": missing,
    }


def test_pathological_maps_get_what_they_deserve():
    truth, maps = pathological()
    scores = {name: sm.score_map(map_of(p), truth) for name, p in maps.items()}
    ceiling = scores["perfect"].skill_ceiling
    share = (truth.state == 1).mean()

    def of(measure):
        return {name: getattr(each, measure) for name, each in scores.items()}

    skill = of("skill")
    assert skill["perfect"] == pytest.approx(ceiling)
    assert skill["sheet"] == pytest.approx(0, abs=1e-9)
    assert skill["all 0.5"] < 0
    assert skill["all free"] < skill["all 0.5"]
    assert skill["all occupied"] < skill["all 0.5"]
    assert skill["shifted"] < 0 < skill["wall missing"] < ceiling
    for measure in ("average_precision", "tolerant_average_precision"):
        ap = of(measure)
        assert ap["perfect"] == 1
        # A constant ranks nothing: among all marks as many hits as there are walls.
        for name in ("all free", "all occupied", "all 0.5", "sheet"):
            assert ap[name] == pytest.approx(share)
    assert of("tolerant_average_precision")["shifted"] > 0.8 > of("average_precision")["shifted"]
    gap = of("wall_gap_m")
    assert gap["perfect"] == gap["all occupied"] == 0
    # Of the wall at the right only what lies beside its neighbours is within one cell.
    assert 0 < gap["shifted"] < 6 * SIZE_M
    assert gap["all free"] == pytest.approx((truth.state == 1).sum() * SIZE_M)
    # The corners of the missing wall have the others within one cell.
    assert gap["wall missing"] == pytest.approx(6 * SIZE_M)
    thickness = of("thickness_m")
    assert thickness["perfect"] == pytest.approx(SIZE_M)
    assert thickness["shifted"] == pytest.approx(SIZE_M, rel=0.1)
    assert thickness["all occupied"] > 2 * SIZE_M
    assert math.isnan(thickness["all free"])
    assert of("baddeley_m")["perfect"] == of("image_dissimilarity")["perfect"] == 0
    assert of("baddeley_m")["wall missing"] < of("baddeley_m")["all free"]


# --- paths ---------------------------------------------------------------------------------------


def test_paths_of_pathological_maps():
    truth, maps = pathological()
    told = {
        name: sm.score_paths(map_of(p), truth, radius_m=0.1, pairs=20) for name, p in maps.items()
    }
    assert told["perfect"] == sm.PathScore(20, 20, 0)
    assert told["perfect"].usable_share == 1
    for name in ("all occupied", "all 0.5"):
        assert told[name] == sm.PathScore(20, 0, 0)
        assert told[name].missed_share == 1
        assert math.isnan(told[name].colliding_share)
    # Through walls as through air: what the pillar in the middle stands in the way of.
    assert told["all free"].planned == 20
    assert 0 < told["all free"].colliding < 20
    assert told["sheet"].pairs == 20


def test_a_wall_that_the_map_lacks_is_run_into():
    truth = truth_of("#######\n#.....#\n#.....#\n###.###\n#.....#\n#.....#\n#######")
    lacks = np.where(truth.state == 1, 0.99, 0.01)
    lacks[3, 1:6] = 0.01
    told = sm.score_paths(map_of(lacks), truth, radius_m=0.1, pairs=60)
    assert told.planned == 60
    assert told.colliding > 10
    # A door that the map has closed: half of the pairs are missed, and none collides.
    closed = np.where(truth.state == 1, 0.99, 0.01)
    closed[3, 3] = 0.99
    told = sm.score_paths(map_of(closed), truth, radius_m=0.1, pairs=60)
    assert told.colliding == 0
    assert 0.2 < told.missed_share < 0.8


def test_path_scores_add_up_and_the_seed_decides(rng):
    truth, maps = pathological()
    m = map_of(maps["all free"])
    one = sm.score_paths(m, truth, radius_m=0.1, pairs=10, seed=1)
    assert one == sm.score_paths(m, truth, radius_m=0.1, pairs=10, seed=1)
    other = sm.score_paths(m, truth, radius_m=0.1, pairs=30, seed=2)
    both = one + other
    assert (both.pairs, both.planned) == (40, one.planned + other.planned)
    assert both.to_dict()["colliding_share"] == both.colliding / both.planned


def test_bad_arguments_of_paths_are_refused():
    truth, maps = pathological()
    m = map_of(maps["perfect"])
    with pytest.raises(sm.InputError, match="radius_m must be > 0"):
        sm.score_paths(m, truth, radius_m=0)
    with pytest.raises(sm.InputError, match="pairs must be >= 1"):
        sm.score_paths(m, truth, pairs=0)
    with pytest.raises(sm.InputError, match="must connect two places"):
        sm.score_paths(m, truth, radius_m=2.0)
    with pytest.raises(sm.InputError, match="must have the same grid"):
        sm.score_paths(map_of(np.full((3, 3), 0.5)), truth)
