import math

import numpy as np
import pytest
import yaml
from support import cells

import sonarmap as sm


def logit(p):
    return np.log(p / (1 - p))


def map_of(drawing, resolution_m=0.5, origin_xy_m=(-1.0, 2.0)):
    """Return the map that is drawn: ``.`` 0.02, ``?`` 0.5, ``#`` 0.98."""
    belief = {".": 0.02, "?": 0.5, "#": 0.98}
    p = np.vectorize(belief.get)(cells(drawing))
    return sm.OccupancyMap(sm.GridSpec(resolution_m, origin_xy_m, p.shape), logit(p))


@pytest.fixture
def corner():
    return map_of("""
        ####
        #...
        #.??
    """)


def read_pgm(path):
    magic, size, maximum, pixels = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    assert (magic, maximum) == (b"P5", b"255")
    return np.frombuffer(pixels, np.uint8).reshape(height, width)


def test_probability_and_log_odds_are_inverse():
    p = np.array([[1e-6, 0.2, 0.5, 0.65, 1 - 1e-6]])
    m = sm.OccupancyMap(sm.GridSpec(1, (0, 0), (1, 5)), logit(p))
    np.testing.assert_allclose(m.probability, p, rtol=1e-9)
    assert m.probability[0, 2] == 0.5


def test_any_log_odds_are_a_probability():
    m = sm.OccupancyMap(sm.GridSpec(1, (0, 0), (1, 3)), [[-1e6, 0, 1e6]])
    assert m.probability.tolist() == [[0.0, 0.5, 1.0]]


def test_a_map_cannot_be_changed(corner):
    with pytest.raises(ValueError, match="read-only"):
        corner.log_odds[0, 0] = 1


# --- files ---------------------------------------------------------------------------------------


def test_a_map_comes_back_exactly(corner, tmp_path):
    corner.save(tmp_path / "maps" / "a")
    for path in (tmp_path / "maps" / "a", tmp_path / "maps" / "a" / "map.npz"):
        back = sm.OccupancyMap.load(path)
        assert back.grid == corner.grid
        assert back.log_odds.tobytes() == corner.log_odds.tobytes()
    assert sorted(path.name for path in (tmp_path / "maps" / "a").iterdir()) == [
        "map.npz",
        "map.pgm",
        "map.yaml",
    ]


def test_the_same_map_is_the_same_bytes(corner, tmp_path):
    corner.save(tmp_path / "a")
    corner.save(tmp_path / "b")
    for name in ("map.npz", "map.pgm", "map.yaml"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_image_is_drawn_as_one_looks_at_it(corner, tmp_path):
    # An image's first row is the top one, and there stands the grid's last.
    corner.save(tmp_path)
    image = read_pgm(tmp_path / "map.pgm")
    assert image.tolist() == [
        [0, 0, 0, 0],
        [0, 254, 254, 254],
        [0, 254, 205, 205],
    ]


@pytest.mark.parametrize(
    ("p", "grey"),
    [(0.66, 0), (0.64, 205), (0.5, 205), (0.2, 205), (0.19, 254)],
)
def test_greys_follow_the_limits_of_map_server(p, grey, tmp_path):
    m = sm.OccupancyMap(sm.GridSpec(1, (0, 0), (1, 1)), [[math.log(p / (1 - p))]])
    m.save(tmp_path)
    assert read_pgm(tmp_path / "map.pgm").tolist() == [[grey]]


def test_map_server_reads_back_the_three_states(corner, tmp_path):
    # map_server: p = (255 - grey) / 255, occupied above occupied_thresh, free below free_thresh.
    corner.save(tmp_path)
    about = yaml.safe_load((tmp_path / "map.yaml").read_text())
    p = (255 - read_pgm(tmp_path / about["image"]).astype(float)) / 255
    state = np.where(
        p > about["occupied_thresh"], "#", np.where(p < about["free_thresh"], ".", "?")
    )
    assert ["".join(row) for row in state] == ["####", "#...", "#.??"]


def test_the_yaml_says_where_the_map_lies(corner, tmp_path):
    corner.save(tmp_path)
    assert yaml.safe_load((tmp_path / "map.yaml").read_text()) == {
        "image": "map.pgm",
        "mode": "trinary",
        "resolution": 0.5,
        "origin": [-1.0, 2.0, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }


def test_the_yaml_keeps_every_digit(tmp_path):
    m = map_of("#", resolution_m=0.1 + 0.2, origin_xy_m=(1 / 3, -1e-7))
    m.save(tmp_path)
    about = yaml.safe_load((tmp_path / "map.yaml").read_text())
    assert about["resolution"] == 0.1 + 0.2
    assert [float(value) for value in about["origin"]] == [1 / 3, -1e-7, 0.0]


def test_trouble_while_saving_leaves_the_older_map_whole(corner, tmp_path, monkeypatch):
    corner.save(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.setattr(sm.OccupancyMap, "_ros_yaml", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        map_of("..\n##").save(tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


# --- bad input -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("log_odds", "message"),
    [
        (np.zeros((3, 2)), r"log_odds must have the grid's shape \(2, 3\), got \(3, 2\)"),
        (np.full((2, 3), math.nan), "log_odds must be finite in every cell"),
        (np.full((2, 3), math.inf), "log_odds must be finite in every cell"),
    ],
)
def test_bad_maps_are_refused(log_odds, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.OccupancyMap(sm.GridSpec(1, (0, 0), (2, 3)), log_odds)


def test_loading_what_is_not_there(tmp_path):
    with pytest.raises(sm.InputError, match=r"map\.npz: no such file$"):
        sm.OccupancyMap.load(tmp_path)
    with pytest.raises(sm.InputError, match=r"nowhere: no such file$"):
        sm.OccupancyMap.load(tmp_path / "nowhere")


def test_loading_a_truncated_map(corner, tmp_path):
    corner.save(tmp_path)
    path = tmp_path / "map.npz"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(sm.InputError, match=r"map\.npz: is not a sonarbed map"):
        sm.OccupancyMap.load(tmp_path)


GOOD = {"log_odds": np.zeros((2, 3)), "resolution_m": 0.1, "origin_xy_m": [0.0, 0.0]}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"log_odds": None}, r"is not a sonarbed map \(KeyError\)"),
        ({"log_odds": np.zeros(3)}, r"shape must be two numbers, got \(3,\)"),
        ({"log_odds": np.full((2, 3), math.nan)}, "log_odds must be finite in every cell"),
        ({"log_odds": np.array([["a"]])}, r"is not a sonarbed map \(ValueError\)"),
        ({"resolution_m": 0.0}, r"resolution_m must be > 0, got 0\.0"),
        ({"origin_xy_m": [0.0]}, r"is not a sonarbed map \(ValueError\)"),
        ({"origin_xy_m": [0.0, math.nan]}, r"origin_xy_m\[1\] must be a finite number, got nan"),
    ],
)
def test_loading_a_map_that_breaks_a_rule(change, message, tmp_path):
    path = tmp_path / "map.npz"
    np.savez(path, **{name: value for name, value in (GOOD | change).items() if value is not None})
    with pytest.raises(sm.InputError, match=rf"map\.npz: {message}$"):
        sm.OccupancyMap.load(path)


def test_loading_a_file_of_another_kind(tmp_path):
    for name, write in {
        "array.npy": lambda path: np.save(path, np.zeros((2, 3))),
        "text.npz": lambda path: path.write_text("hello"),
        "empty.npz": lambda path: path.write_bytes(b""),
    }.items():
        write(tmp_path / name)
        with pytest.raises(sm.InputError, match=f"{name}: is not a sonarbed map"):
            sm.OccupancyMap.load(tmp_path / name)


def test_saving_where_a_file_is_in_the_way(corner, tmp_path):
    (tmp_path / "file").write_text("I was here first")
    with pytest.raises(sm.InputError, match=r"a file is in the way$"):
        corner.save(tmp_path / "file")


# --- maps that state probabilities ---------------------------------------------------------------

LINE = sm.GridSpec(1, (0, 0), (1, 5))
P = [[0.0, 0.2, 0.5, 0.7, 1.0]]


def test_stated_probabilities_are_kept_to_the_last_bit():
    m = sm.OccupancyMap.from_probability(LINE, P)
    assert m.probability.tolist() == P
    # The log-odds are derived, and finite.
    assert m.log_odds[0, 2] == 0
    np.testing.assert_allclose(m.log_odds[0, [1, 3]], logit(np.array([0.2, 0.7])))
    np.testing.assert_allclose(m.log_odds[0, [0, 4]], logit(np.array([1e-6, 1 - 1e-6])))
    with pytest.raises(ValueError, match="read-only"):
        m.probability[0, 0] = 1


def test_a_map_says_itself_what_is_occupied_free_and_unknown():
    m = sm.OccupancyMap.from_probability(LINE, P)
    assert m.occupied.tolist() == [[False, False, False, True, True]]
    assert m.free.tolist() == [[True, True, False, False, False]]
    seen = [[True, False, True, False, True]]
    m = sm.OccupancyMap.from_probability(LINE, P, seen, occupied_from=0.5, free_up_to=0.1)
    assert m.occupied.tolist() == [[False, False, True, False, True]]
    assert m.free.tolist() == [[True, False, False, False, False]]
    assert (m.occupied_from, m.free_up_to) == (0.5, 0.1)
    # Evidence does not say what it observed, and has the limits of map_server.
    m = sm.OccupancyMap(LINE, logit(np.array([[0.1, 0.2, 0.5, 0.7, 0.9]])))
    assert m.observed is None
    assert (m.occupied_from, m.free_up_to) == (0.65, 0.35)
    assert m.occupied.tolist() == [[False, False, False, True, True]]


def test_the_image_follows_the_layer_and_the_limits_of_the_map(tmp_path):
    seen = [[True, False, True, True, True]]
    sm.OccupancyMap.from_probability(
        LINE, [[0.1, 0.1, 0.3, 0.5, 0.6]], seen, occupied_from=0.6
    ).save(tmp_path)
    assert read_pgm(tmp_path / "map.pgm").tolist() == [[254, 205, 254, 205, 0]]


@pytest.mark.parametrize("observed", [None, [[True, False, True, True, False]]])
def test_a_map_of_probabilities_comes_back_exactly(observed, tmp_path):
    m = sm.OccupancyMap.from_probability(LINE, P, observed, occupied_from=0.6, free_up_to=0.1)
    m.save(tmp_path)
    back = sm.OccupancyMap.load(tmp_path)
    assert back.grid == m.grid
    assert back.probability.tobytes() == m.probability.tobytes()
    assert back.log_odds.tobytes() == m.log_odds.tobytes()
    assert (back.occupied_from, back.free_up_to) == (0.6, 0.1)
    if observed is None:
        assert back.observed is None
    else:
        assert back.observed.tolist() == observed


def test_a_map_of_another_make_is_scored_and_saved(tmp_path):
    class Other:
        grid, probability = LINE, np.array(P)

    class Layered(Other):
        observed, occupied_from = np.array([[True, True, False, True, True]]), 0.9

    m = sm.OccupancyMap.of(Other())
    assert m.probability.tolist() == P
    m.save(tmp_path)
    m = sm.OccupancyMap.of(Layered())
    assert m.occupied.tolist() == [[False, False, False, False, True]]
    assert sm.OccupancyMap.of(m) is m


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"p": np.zeros((2, 5))}, r"p must have the grid's shape \(1, 5\), got \(2, 5\)"),
        ({"p": [[0, 0, math.nan, 0, 0]]}, r"p\[0, 2\] must be within \[0, 1\], got nan"),
        ({"p": [[0, 0, 0, 0, 1.01]]}, r"p\[0, 4\] must be within \[0, 1\], got 1.01"),
        ({"p": [["a"] * 5]}, "p must be an array of numbers, got .*"),
        ({"observed": [[True]]}, r"observed must have the grid's shape \(1, 5\), got \(1, 1\)"),
        ({"observed": [[0.5] * 5]}, "observed must be an array of bool, got float64"),
        ({"occupied_from": 0.3}, "free_up_to must be < occupied_from, got 0.35 and 0.3"),
        ({"occupied_from": 1.2}, r"occupied_from must be within \[0, 1\], got 1.2"),
        ({"free_up_to": -1}, r"free_up_to must be within \[0, 1\], got -1"),
    ],
)
def test_bad_probabilities_are_refused(given, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        sm.OccupancyMap.from_probability(LINE, **{"p": P, **given})


@pytest.mark.parametrize(
    ("other", "kind"), [(np.array(P), "ndarray; see OccupancyMap.from_probability"), ("map", "str")]
)
def test_what_is_no_map_is_refused(other, kind):
    with pytest.raises(
        sm.InputError,
        match=rf"^a map must have a \.grid \(GridSpec\) and \.probability, got {kind}$",
    ):
        sm.OccupancyMap.of(other)
