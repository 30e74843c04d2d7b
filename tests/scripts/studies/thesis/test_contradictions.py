import pytest

import sonarmap as sm
from sonarbed.studies.thesis.contradictions import contradictions


def test_only_the_standard_model_contradicts_itself():
    before, hill = contradictions(sm.StandardModel.thesis(), 1.5, 0.1)
    # Before the hill it says 'occupied' where r / R + a / beta > 1: with R = 3 m and the hill at
    # 1.4 m the integral of r (r / 3) over that of r is (2 / 9) 1.4 = 0.311.
    assert before == pytest.approx(0.311, abs=2e-3)
    assert 0.3 < hill < 0.7
    assert contradictions(sm.ParameterizedModel.thesis(), 1.5, 0.1) == (0, 0)
