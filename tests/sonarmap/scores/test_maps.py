import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from support import cells

import sonarmap as sm
from sonarmap.scores.maps import MapScore, ToleranceCount

BELIEF = {".": 0.1, "?": 0.5, "#": 0.9}
STATE = {".": 0, "#": 1, "?": 2}  # in a truth ? is hidden


def grid_of(shape, resolution_m=0.1):
    return sm.GridSpec(resolution_m, (0.0, 0.0), shape)


def map_of(drawing, resolution_m=0.1):
    p = np.vectorize(BELIEF.get)(cells(drawing))
    return sm.OccupancyMap(grid_of(p.shape, resolution_m), np.log(p / (1 - p)))


def truth_of(drawing, resolution_m=0.1):
    state = np.vectorize(STATE.get)(cells(drawing)).astype(np.uint8)
    return SimpleNamespace(grid=grid_of(state.shape, resolution_m), state=state)


def score(map_drawing, truth_drawing, *, resolution_m=0.1, **options):
    return sm.score_map(
        map_of(map_drawing, resolution_m), truth_of(truth_drawing, resolution_m), **options
    )


def random_pair(rng, shape=(12, 15)):
    drawn = sm.OccupancyMap(grid_of(shape), rng.normal(scale=3, size=shape))
    state = rng.choice([0, 0, 0, 1, 2], size=shape).astype(np.uint8)
    return drawn, SimpleNamespace(grid=grid_of(shape), state=state)


# --- counted by hand -----------------------------------------------------------------------------


def test_a_map_counted_by_hand():
    # Ten cells are scored: the hidden two of the truth are not, whatever the map says there.
    s = score(
        """
        ##.#
        .?..
        ...#
        """,
        """
        ###?
        ....
        ..#?
        """,
    )
    assert s.cells == 10
    assert s.truth_occupied == 4
    assert s.map_occupied == 2
    assert s.known == 9
    assert s.false_free == 2
    assert s.phantom == 0
    assert s.coverage == pytest.approx(0.9)
    assert s.false_free_m2 == pytest.approx(2 * 0.01)
    assert s.phantom_m2 == 0
    # 7 cells with P 0.9 of what is true, 2 with 0.1, 1 with 0.5.
    assert s.map_score == pytest.approx((7 * math.log2(1.8) + 2 * math.log2(0.2)) / 10)
    assert s.brier == pytest.approx((7 * 0.01 + 2 * 0.81 + 0.25) / 10)


def test_precision_and_recall_counted_by_hand():
    # The map's wall stands one cell too high at the left and two at the right.
    s = score(
        """
        ..#
        #..
        ...
        """,
        """
        ...
        ...
        #.#
        """,
    )
    assert [(t.map_hits, t.truth_hits) for t in s.tolerances] == [(1, 1), (1, 1), (2, 2)]
    assert (s.precision(0), s.recall(0), s.f1(0)) == (0.5, 0.5, 0.5)
    assert (s.precision(2), s.recall(2), s.f1(2)) == (1, 1, 1)
    assert s.map_to_truth_m == pytest.approx(0.15)
    assert s.truth_to_map_m == pytest.approx(0.15)
    assert s.phantom == 2
    assert s.false_free == 2


def test_precision_and_recall_are_not_each_other():
    # Four cells found of one; of the four three lie one cell beside or farther.
    s = score("####", "#...", resolution_m=0.05)
    assert s.precision(0) == 2 / 4  # within one cell of 5 cm
    assert s.precision(1) == 3 / 4  # within 10 cm
    assert s.precision(2) == 1  # within 20 cm
    assert [s.recall(i) for i in range(3)] == [1, 1, 1]
    assert s.f1(0) == pytest.approx(2 / 3)
    assert s.map_to_truth_m == pytest.approx((0 + 0.05 + 0.10 + 0.15) / 4)
    assert s.truth_to_map_m == 0


@pytest.mark.parametrize(
    ("resolution_m", "apart", "hits"),
    [
        # one cell; 10 cm; 20 cm: a distance that equals the tolerance is within it
        (0.1, 1, (1, 1, 1)),
        (0.1, 2, (0, 0, 1)),
        (0.1, 3, (0, 0, 0)),
        (0.05, 2, (0, 1, 1)),
        (0.05, 4, (0, 0, 1)),
        (0.05, 5, (0, 0, 0)),
        # a coarse cell's one is more than 20 cm
        (0.25, 1, (1, 0, 0)),
    ],
)
def test_tolerances_are_one_cell_10_cm_and_20_cm(resolution_m, apart, hits):
    here = "#" + "." * apart
    s = score(here, here[::-1], resolution_m=resolution_m)
    assert tuple(t.map_hits for t in s.tolerances) == hits
    assert [t.tolerance_m for t in s.tolerances] == [resolution_m, 0.10, 0.20]


def test_distances_are_straight_lines():
    s = score("..\n#.", ".#\n..")
    assert s.map_to_truth_m == pytest.approx(0.1 * math.sqrt(2))
    assert s.tolerances[0].map_hits == 0


# --- maps that everyone agrees about -------------------------------------------------------------


def test_a_perfect_map():
    drawing = """
        #####
        #...#
        #####
    """
    certain = np.where(cells(drawing) == "#", 30.0, -30.0)
    s = sm.score_map(sm.OccupancyMap(grid_of((3, 5)), certain), truth_of(drawing))
    assert s.map_score == pytest.approx(1 + math.log2(0.99))  # the clamp's price
    assert s.brier == pytest.approx(0, abs=1e-12)
    assert s.correlation == pytest.approx(1)
    assert [(s.precision(i), s.recall(i), s.f1(i)) for i in range(3)] == [(1, 1, 1)] * 3
    assert (s.coverage, s.false_free, s.phantom) == (1, 0, 0)
    assert (s.map_to_truth_m, s.truth_to_map_m) == (0, 0)


def test_a_map_that_knows_nothing():
    s = score("????\n????", "#..#\n....")
    assert s.map_score == 0
    assert s.brier == 0.25
    assert s.correlation == 0
    assert s.coverage == 0
    assert math.isnan(s.precision(0))
    assert s.recall(0) == 0
    assert s.f1(0) == 0
    assert math.isnan(s.map_to_truth_m)
    assert s.truth_to_map_m == math.inf


def test_a_map_that_is_confidently_wrong():
    wrong = np.array([[30.0, -30.0, 30.0]])
    s = sm.score_map(sm.OccupancyMap(grid_of((1, 3)), wrong), truth_of(".#."))
    assert s.map_score == pytest.approx(1 + math.log2(0.01))
    assert s.map_score == pytest.approx(-5.64, abs=0.005)
    assert s.brier == pytest.approx(1)
    assert s.correlation == pytest.approx(-1)
    assert (s.phantom, s.false_free) == (2, 1)


def test_a_free_world_has_no_recall():
    s = score("..#.", "....")
    assert math.isnan(s.recall(0))
    assert s.precision(0) == 0
    assert s.f1(0) == 0
    assert s.map_to_truth_m == math.inf
    assert s.correlation == 0


@pytest.mark.parametrize(
    ("p", "occupied", "free"),
    [(0.65, 1, 0), (0.6499, 0, 0), (0.5, 0, 0), (0.3501, 0, 0), (0.35, 0, 1)],
)
def test_known_begins_at_the_limits(p, occupied, free):
    log_odds = np.full((1, 2), math.log(p / (1 - p)))
    # The probability that comes back from log-odds is that of the literal to the last bit or not.
    log_odds += math.copysign(1e-12, p - 0.5)
    s = sm.score_map(sm.OccupancyMap(grid_of((1, 2)), log_odds), truth_of(".#"))
    assert s.map_occupied == 2 * occupied
    assert s.phantom == occupied
    assert s.false_free == free
    assert s.known == 2 * (occupied + free)


# --- against numpy -------------------------------------------------------------------------------


def test_correlation_is_numpys(rng):
    m, truth = random_pair(rng)
    scored = truth.state != 2
    expected = np.corrcoef(m.probability[scored], truth.state[scored] == 1)[0, 1]
    assert sm.score_map(m, truth).correlation == pytest.approx(expected)


def test_distances_are_those_of_a_plain_loop(rng):
    m, truth = random_pair(rng, (9, 11))
    s = sm.score_map(m, truth)
    scored = truth.state != 2
    found = np.argwhere(scored & (m.probability >= 0.65))
    real = np.argwhere(scored & (truth.state == 1))
    to_real = [min(math.dist(a, b) for b in real) * 0.1 for a in found]
    to_found = [min(math.dist(a, b) for b in found) * 0.1 for a in real]
    assert s.map_to_truth_m == pytest.approx(np.mean(to_real))
    assert s.truth_to_map_m == pytest.approx(np.mean(to_found))
    for tolerance in s.tolerances:
        within = tolerance.tolerance_m + 1e-6
        assert tolerance.map_hits == sum(d <= within for d in to_real)
        assert tolerance.truth_hits == sum(d <= within for d in to_found)


# --- which cells are scored ----------------------------------------------------------------------


def test_only_observable_cells_are_scored():
    observable = cells("oo.\noo.") == "o"
    s = score("##.\n..#", "#..\n..?", observable=observable)
    assert s.cells == 4
    assert (s.truth_occupied, s.map_occupied, s.phantom) == (1, 2, 1)


def test_a_wall_that_is_not_scored_is_no_counterpart():
    # The map's cell has a true one beside it, but that one could not be observed.
    observable = cells("o.o") == "o"
    assert score("#..", ".#.", observable=observable).tolerances[0].map_hits == 0


# --- scores add up -------------------------------------------------------------------------------


def test_the_sum_of_scores_is_the_score_of_the_maps_taken_as_one(rng):
    (m_1, truth_1), (m_2, truth_2) = random_pair(rng), random_pair(rng)
    # Side by side with hidden cells between them, wide enough that no distance crosses.
    gap = np.zeros((12, 40))
    both = sm.OccupancyMap(grid_of((12, 70)), np.hstack([m_1.log_odds, gap, m_2.log_odds]))
    truth = SimpleNamespace(
        grid=both.grid,
        state=np.hstack([truth_1.state, np.full(gap.shape, 2, np.uint8), truth_2.state]),
    )
    added = sm.score_map(m_1, truth_1) + sm.score_map(m_2, truth_2)
    as_one = sm.score_map(both, truth)
    assert added.tolerances == as_one.tolerances
    for name in MapScore.__slots__:
        if name != "tolerances":
            assert getattr(added, name) == pytest.approx(getattr(as_one, name)), name
    assert added.correlation == pytest.approx(as_one.correlation)


def test_scores_of_different_resolutions_do_not_add_up():
    fine, coarse = score("#.", "#."), score("#.", "#.", resolution_m=0.2)
    with pytest.raises(sm.InputError, match=r"same resolution_m to be added, got 0\.1 and 0\.2"):
        fine + coarse


# --- as JSON -------------------------------------------------------------------------------------


def test_scores_that_are_not_defined_are_null():
    text = json.dumps(score("??", "#.").to_dict(), allow_nan=False)
    back = json.loads(text)
    assert back["precision_1_cell"] is None
    assert back["map_to_truth_m"] is None
    assert back["truth_to_map_m"] is None
    assert back["counts"]["truth_distance_m"] is None
    assert back["recall_10_cm"] == 0
    assert back["map_score"] == 0


def test_the_dictionary_has_scores_and_their_counts():
    s = score("##..", "#...")
    scores = s.to_dict()
    assert scores["precision_1_cell"] == s.precision(0) == 1
    assert scores["f1_20_cm"] == s.f1(2)
    assert scores["brier"] == s.brier
    assert scores["counts"]["cells"] == 4
    assert scores["counts"]["tolerances"][1] == {
        "tolerance_m": 0.10,
        "map_hits": 2,
        "truth_hits": 1,
    }


def test_a_score_comes_back_from_its_counts():
    s = score("##..", "#...")
    counts = s.to_dict()["counts"]
    counts["tolerances"] = tuple(ToleranceCount(**t) for t in counts["tolerances"])
    assert MapScore(**counts) == s


# --- bad input -----------------------------------------------------------------------------------


def test_another_grid_is_refused():
    with pytest.raises(sm.InputError, match="map and truth must have the same grid, got Grid"):
        sm.score_map(map_of("#."), truth_of("#.", resolution_m=0.2))


def test_a_mask_of_another_shape_is_refused():
    with pytest.raises(sm.InputError, match=r"observable must have .* \(1, 2\), got \(2, 1\)"):
        score("#.", "#.", observable=np.ones((2, 1), bool))


@pytest.mark.parametrize(
    ("truth", "observable"), [("??", None), ("#.", np.zeros((1, 2), bool)), ("?.", [[True, False]])]
)
def test_nothing_to_score_is_refused(truth, observable):
    observable = None if observable is None else np.array(observable)
    with pytest.raises(sm.InputError, match="no cell is left to score: none is observable"):
        score("#.", truth, observable=observable)
