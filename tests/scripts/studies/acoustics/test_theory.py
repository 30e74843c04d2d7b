import pytest

from sonarbed.studies.acoustics import (
    theory,
)


def test_pillars_are_quieter_than_planes_by_theory():
    assert theory.pillar_db(0.05, 1.0) == pytest.approx(-13.2, abs=0.1)
    assert theory.pillar_db(0.02, 2.0) == pytest.approx(-20.0, abs=0.1)


def test_sonar_without_a_beam_is_refused():
    with pytest.raises(Exception, match="sonar 'thesis' has no beam to compare with theory"):
        theory.physical("thesis")
