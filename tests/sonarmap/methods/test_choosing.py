"""Mapping methods by name, and a person's own without any registration."""

import dataclasses
import importlib.metadata
import math
import pickle

import numpy as np
import pytest
from support import ONE, THREE, make_log, random_log

import sonarmap as sm
from sonarmap.methods.bayes.updating import Bayes
from sonarmap.parameters import at_point

GRID = sm.GridSpec(0.1, (-1.5, -1.5), (30, 31))


@pytest.mark.parametrize("name", list(sm.methods()))
class TestEveryMethod:
    """What holds for every method that ships."""

    def test_is_a_frozen_dataclass_with_a_name_and_a_source(self, name):
        kind = sm.methods()[name]
        method = sm.method(name)
        assert isinstance(method, sm.MappingMethod)
        assert type(method) is kind
        assert method.name == name
        assert method.source.endswith(".")
        for field in dataclasses.fields(kind):
            with pytest.raises(dataclasses.FrozenInstanceError):
                setattr(method, field.name, None)

    def test_maps_on_the_grid_given(self, name, rng):
        m = sm.method(name).map(random_log(rng), GRID)
        assert m.grid == GRID
        assert m.probability.shape == GRID.shape

    def test_uses_no_stale_or_rejected_reading(self, name, rng):
        log = random_log(rng, 200)
        lies = np.where(log.usable, log.range_m, 0.7)
        method = sm.method(name)
        for liar in (log.replace(range_m=lies), log.select(log.usable)):
            np.testing.assert_allclose(
                method.map(liar, GRID).probability, method.map(log, GRID).probability, atol=1e-12
            )

    def test_says_what_may_be_searched(self, name, rng):
        kind = sm.methods()[name]
        space = kind.space()
        for end in ("low", "high"):
            point = {key: getattr(each, end) for key, each in space.items()}
            assert isinstance(at_point(kind, point), kind)

    def test_pickles(self, name):
        assert pickle.loads(pickle.dumps(sm.method(name))) == sm.method(name)

    def test_adding_reading_by_reading_equals_the_whole(self, name, rng):
        method = sm.method(name)
        if not isinstance(method, sm.IncrementalMethod):
            pytest.skip("takes logs only as a whole")
        log = random_log(rng, 60)
        state = method.begin(log.ring, GRID)
        early = state.map
        for rows in (slice(0, 1), slice(1, 7), slice(7, 7), slice(7, 60)):
            state.add(log.select(rows))
        assert state.map.probability.tobytes() == method.map(log, GRID).probability.tobytes()
        assert np.unique(early.probability).size == 1  # later readings do not change it
        with pytest.raises(sm.InputError, match="readings must be of the ring 'three', got 'one'"):
            state.add(make_log(1.0, ring=ONE))


@pytest.mark.parametrize(
    ("method", "model"),
    [
        ("bayes-standard", sm.StandardModel(math.radians(15), 3.0, 0.98, 0.1)),
        ("bayes-parameterized", sm.ParameterizedModel.thesis()),
    ],
)
@pytest.mark.parametrize("no_echo", ["ignore", "clear"])
def test_the_defaults_are_the_thesis_models(method, model, no_echo, rng):
    log = random_log(rng, 300, ring=sm.AMIGOBOT)
    expected = sm.build_map(log, model, no_echo=no_echo)
    made = sm.build_map(log, sm.method(method, no_echo=no_echo))
    assert made.grid == expected.grid
    assert made.log_odds.tobytes() == expected.log_odds.tobytes()


def test_the_cone_and_the_limit_are_the_rings_unless_given():
    method = sm.method("bayes-standard")
    assert method.sensor_model(THREE).max_range_m == THREE.range_max_m
    assert method.longest_reading_m(THREE) == THREE.range_max_m
    udacity = sm.ring("udacity8")
    assert sm.method("bayes-parameterized").sensor_model(udacity).p5_rad == udacity.half_angle_rad
    assert sm.method("bayes-parameterized", max_range_m=2).longest_reading_m(udacity) == 2
    assert sm.method("bayes-parameterized", p4=0.9).sensor_model(udacity).p1 == 0.1


# --- a person's own ------------------------------------------------------------------------------


def six_percent(log, grid):
    return np.full(grid.shape, 0.06)


@dataclasses.dataclass(frozen=True)
class Share:
    """A toy of a method."""

    name = "share"
    source = "A toy."
    p: float = 0.06

    def map(self, log, grid):
        return sm.OccupancyMap.from_probability(grid, np.full(grid.shape, self.p))


@pytest.fixture
def own_module(tmp_path, monkeypatch):
    """Put a module of a person's own where it can be imported, and return its name."""
    (tmp_path / "own_mapper.py").write_text(
        "import dataclasses\nimport numpy as np\nimport sonarmap as sm\n"
        "def blank(log, grid):\n    return np.full(grid.shape, 0.06)\n"
        "@dataclasses.dataclass(frozen=True)\n"
        "class Share:\n"
        "    name, source = 'share', 'A toy.'\n"
        "    p: float = 0.06\n"
        "    def map(self, log, grid):\n"
        "        p = np.full(grid.shape, self.p)\n"
        "        return sm.OccupancyMap.from_probability(grid, p)\n"
        "    @classmethod\n"
        "    def space(cls):\n        return {}\n"
        "ready = Share(0.2)\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    return "own_mapper"


def test_a_function_a_class_and_an_instance_are_methods(rng):
    log = random_log(rng)
    for part, p in ((six_percent, 0.06), (Share, 0.06), (Share(0.3), 0.3)):
        assert (sm.build_map(log, part, GRID).probability == p).all()


def test_anything_that_can_be_imported_is_a_method(own_module, rng):
    log = random_log(rng)
    for name, parameters, p in (
        ("blank", {}, 0.06),
        ("Share", {}, 0.06),
        ("Share", {"p": 0.4}, 0.4),
        ("ready", {}, 0.2),
    ):
        method = sm.method(f"{own_module}:{name}", **parameters)
        assert (method.map(log, GRID).probability == p).all()


def test_an_installed_package_adds_its_own_by_an_entry_point(own_module, monkeypatch):
    entry = importlib.metadata.EntryPoint("share", f"{own_module}:Share", "sonarbed.methods")
    taken = importlib.metadata.EntryPoint("bayes-standard", "no:where", "sonarbed.methods")
    monkeypatch.setattr(
        "sonarmap.registry.entry_points",
        lambda group: [entry, taken] if group == "sonarbed.methods" else [],
    )
    assert list(sm.methods())[-1] == "share"
    assert len(sm.methods()) == len(list(sm.methods()))
    assert sm.method("share", p=0.1).p == 0.1
    # What ships cannot be taken over.
    assert sm.method("bayes-standard").name == "bayes-standard"


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (
            lambda log, grid: np.zeros((2, 2)),
            r"p must have the grid's shape \(30, 31\), got \(2, 2\)",
        ),
        (lambda log, grid: np.full(grid.shape, 1.5), r"p\[0, 0\] must be within \[0, 1\], got 1.5"),
        (lambda log, grid: np.full(grid.shape, np.nan), r"p\[0, 0\] must be within .*, got nan"),
        (lambda log, grid: "map", "p must be an array of numbers, got 'map'"),
        (
            lambda log, grid: sm.OccupancyMap(sm.GridSpec(1, (0, 0), (1, 1)), [[0.0]]),
            "its map must be on the grid given, got GridSpec.*",
        ),
    ],
)
def test_what_is_no_map_is_refused_by_the_name_of_the_function(made, message, rng):
    with pytest.raises(sm.InputError, match=f"^method '<lambda>': {message}$"):
        sm.build_map(random_log(rng), made, GRID)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: sm.method("bayes-standrad"),
            "method 'bayes-standrad' is unknown; did you mean 'bayes-standard'\\?",
        ),
        (
            lambda: sm.method("bayes-standard", beta_deg=3),
            "method 'bayes-standard' has no parameter 'beta_deg'; did you mean 'beta_rad'\\?",
        ),
        (lambda: sm.method("bayes-standard", tolerance_m=0), "tolerance_m must be > 0, got 0"),
        (lambda: sm.method("bayes-parameterized", p4=0.4), "p4 must be in .*, got 0.4"),
        (
            lambda: sm.method("bayes-parameterized", no_echo="maybe"),
            "no_echo 'maybe' is unknown; known: clear, ignore",
        ),
        (
            lambda: sm.method("bayes-parameterized", max_range_m=-1),
            "max_range_m must be > 0, got -1",
        ),
        (
            lambda: sm.method("bayes-parameterized", log_odds_limit=0),
            "log_odds_limit must be > 0, got 0",
        ),
        (
            lambda: sm.method("no_such_module:Name"),
            "method 'no_such_module:Name' cannot be imported: .*",
        ),
        (
            lambda: sm.method("math:Nothing"),
            "method 'math:Nothing' cannot be imported: 'math' has no 'Nothing'",
        ),
        (
            lambda: sm.method(":Nothing"),
            "method must be a name or package.module:Name, got ':Nothing'",
        ),
        (
            lambda: sm.method("math:pi"),
            r"method 'math:pi' must have .map\(log, grid\) or be a function .*, got float",
        ),
        (lambda: sm.method("math:sin", x=1), "method 'math:sin' takes no parameters, got x"),
        (lambda: sm.method(3), "method must be a name, got 3"),
    ],
)
def test_bad_methods_are_refused(call, message):
    with pytest.raises(sm.InputError, match=f"^{message}$"):
        call()


@pytest.mark.parametrize("name", ["max_range_m", "no_echo", "log_odds_limit"])
def test_what_belongs_to_a_sensor_model_is_refused_with_a_method(name, rng):
    value = {"max_range_m": 2.0, "no_echo": "clear", "log_odds_limit": 5.0}[name]
    log = random_log(rng)
    sm.build_map(log, sm.ParameterizedModel.thesis(), GRID, **{name: value})
    for part in (six_percent, sm.method("bayes-standard")):
        with pytest.raises(sm.InputError, match=f"^{name} belongs to a sensor model, got "):
            sm.build_map(log, part, GRID, **{name: value})


def test_a_sensor_model_of_ones_own_is_fused_as_the_thesis_ones(rng):
    model = sm.ParameterizedModel(p1=0.1, p2=0.1, p3_m=0.1, p4=0.8, p5_rad=0.2)
    log = random_log(rng)
    assert sm.build_map(log, model, GRID).log_odds.tobytes() == (
        Bayes(model).map(log, GRID).log_odds.tobytes()
    )
