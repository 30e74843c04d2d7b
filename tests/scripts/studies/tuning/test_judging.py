import numpy as np
import pytest

from sonarbed.studies.tuning.judging import RoomScores


def test_all_rooms_are_a_mean_of_means_with_an_interval_over_seeds():
    scores = {"best": np.array([[1.0, 3.0], [5.0, 5.0]]), "thesis": np.zeros((2, 2))}
    judged = RoomScores(("a", "b"), scores)
    assert judged.places == ("a", "b", "all rooms")
    both = judged.score("best", "all rooms")
    # Seeds have 3 and 4; Student's t for two of them is 12.706.
    assert (both.value, both.high - both.value) == pytest.approx((3.5, 12.706 * 0.5), rel=1e-3)
    assert judged.gain("thesis", "a").value == 2
    assert judged.only(["b"]).mean == {"best": 5.0, "thesis": 0.0}
