"""What may be searched."""

import pytest

import sonarmap as sm
from sonarbed.studies.tuning.space import candidate, ranges, thesis_points
from sonarmap.goodness import thesis_parameter_sets


def test_the_grid_is_the_thesis_own():
    models = [candidate(point, "parameterized").model for point in thesis_points()]
    assert models == list(thesis_parameter_sets())


@pytest.mark.parametrize("model", ["parameterized", "standard"])
@pytest.mark.parametrize("target", ["model", "hsr", "both"])
def test_every_corner_of_the_box_is_a_candidate(target, model, rng):
    box = ranges(target, model)
    for _ in range(200):
        corner = {name: float(rng.choice(ends)) for name, ends in box.items()}
        tried = candidate(corner, model)
        assert (tried.hsr is None) == (target == "model")
        told = tried.to_dict()
        if tried.hsr is not None:
            assert told["max_wall_m"] >= told["min_wall_m"] == corner["min_wall_m"]
        if model == "parameterized":
            assert told["p1"] == pytest.approx(1 - told["p4"])


def test_what_is_not_searched_is_the_thesis_own():
    hsr = {name: low for name, (low, _) in ranges("hsr", "standard").items()}
    assert candidate(hsr, "standard").model == sm.StandardModel.thesis()
    assert candidate(hsr, "parameterized").model == sm.ParameterizedModel.thesis()
