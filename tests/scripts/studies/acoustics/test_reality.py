import numpy as np
import pytest

from sim.sonar import presets as sonars
from sonarbed.studies.acoustics import (
    reality,
)

PHYSICAL = sonars.preset("physical")


def test_hallway_is_as_silent_as_the_real_one():
    shares = reality.shares_of(reality.as_real(PHYSICAL, 83.0, seed=0).simulate())
    real = reality.REAL
    assert shares.lost == pytest.approx(real.lost, abs=0.04)
    assert min(shares.lost_by_sonar) == pytest.approx(min(real.lost_by_sonar), abs=0.06)
    # The real robot's sonar at +7.5 degrees hears far less than its twin at -7.5; ours differ less.
    assert max(shares.lost_by_sonar) == pytest.approx(0.65, abs=0.08)
    assert np.mean(shares.lost_by_sonar[3:5]) == pytest.approx(
        np.mean(real.lost_by_sonar[3:5]), abs=0.12
    )
    assert shares.repeated == pytest.approx(real.repeated, abs=0.07)
    assert min(shares.repeated_by_sonar) == pytest.approx(min(real.repeated_by_sonar), abs=0.09)
    assert max(shares.repeated_by_sonar) == pytest.approx(max(real.repeated_by_sonar), abs=0.09)
