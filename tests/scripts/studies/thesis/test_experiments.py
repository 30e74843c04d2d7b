import sonarmap as sm
from sonarbed.studies.thesis.experiments import EXPERIMENTS


def test_the_threshold_is_the_maximum_range_in_the_closed_room_only():
    closed, opened = (experiment.params((10, 20), sm.AMIGOBOT) for experiment in EXPERIMENTS)
    assert closed == sm.HsrParams(0.01, 0.02, 3.0, 0.06)
    assert opened == sm.HsrParams(0.01, 0.02, 0.8, 0.06)
