import numpy as np
import pytest

from sim.sonar import presets as sonars
from sonarbed.studies.acoustics import (
    dropout,
)

PHYSICAL = sonars.preset("physical")


def test_56_db_hear_a_mirror_up_to_42_degrees_with_dead_bands_between():
    loud = PHYSICAL.receiver.__class__(dynamic_range_db=56.0, gain_share=1.0)
    incidence_deg = np.arange(0, 60, 0.25)
    answer = dropout.answers(
        PHYSICAL.replace(receiver=loud), dropout.PERFECT, 2.0, np.radians(incidence_deg)
    )
    assert incidence_deg[answer != dropout.LOST].max() == pytest.approx(42, abs=2)
    bands = np.array(dropout.dead_bands_deg(incidence_deg, answer))
    assert bands.ravel() == pytest.approx([12.25, 13.25, 22.5, 25.75, 32.75, 41.5], abs=0.5)


def test_rough_walls_scatter_where_mirrors_are_silent():
    at_40 = np.radians([0.0, 40.0])
    glass, brick = (dropout.answers(PHYSICAL, name, 1.0, at_40) for name in ("glass", "brick"))
    assert glass.tolist() == [dropout.MIRRORED, dropout.LOST]
    assert brick.tolist() == [dropout.MIRRORED, dropout.SCATTERED]


def test_dead_bands_lie_between_heard_ones():
    answer = np.array([1, 1, 0, 0, 2, 0, 0])
    assert dropout.dead_bands_deg(np.arange(7.0), answer) == [(2.0, 3.0)]
