"""What may be searched."""

import pytest

import sonarmap as sm
from sonarbed.studies.tuning.space import RING, candidate, ranges, thesis_points
from sonarmap.goodness import thesis_parameter_sets


def model_of(tried):
    """Return the sensor model of a candidate."""
    return tried.pipeline.method.sensor_model(RING)


def test_the_grid_is_the_thesis_own():
    models = [model_of(candidate(point, "parameterized")) for point in thesis_points()]
    assert models == list(thesis_parameter_sets())


@pytest.mark.parametrize("model", ["parameterized", "standard"])
@pytest.mark.parametrize("target", ["model", "hsr", "both"])
def test_every_corner_of_the_box_is_a_candidate(target, model, rng):
    box = ranges(target, model)
    for _ in range(200):
        corner = {name: float(rng.choice(ends)) for name, ends in box.items()}
        tried = candidate(corner, model)
        assert (tried.pipeline.filters == ()) == (target == "model")
        told = tried.to_dict()
        if tried.pipeline.filters:
            assert told["max_wall_m"] >= told["min_wall_m"] == corner["min_wall_m"]
        if model == "parameterized":
            assert told["p1"] == pytest.approx(1 - told["p4"])


def test_what_is_not_searched_is_the_thesis_own():
    hsr = {name: low for name, (low, _) in ranges("hsr", "standard").items()}
    assert model_of(candidate(hsr, "standard")) == sm.StandardModel.thesis()
    assert model_of(candidate(hsr, "parameterized")) == sm.ParameterizedModel.thesis()
