from dataclasses import replace

import numpy as np
from support import make_log, random_truth

import sonarmap as sm
from sonarbed.studies.thesis.on_axis import heard_on_axis


def test_readings_from_off_the_axis_take_no_part(rng):
    causes = np.array([sm.Cause.DIRECT, sm.Cause.OFF_AXIS, sm.Cause.DROPOUT], np.int8)
    truth = replace(random_truth(rng, 3), cause=causes)
    log = make_log([1.0, 0.9, np.inf], truth=truth)
    assert heard_on_axis(log).range_m.tolist() == [1.0, -np.inf, np.inf]
