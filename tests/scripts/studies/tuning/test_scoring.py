import pytest

import sonarmap as sm
from sonarbed.reporting.drives import DriveSpec, DriveStore
from sonarbed.studies.tuning.scoring import score_candidate
from sonarbed.studies.tuning.space import Candidate

pytestmark = pytest.mark.engine


def test_hsr_is_idle_where_no_reading_vouches(tmp_path):
    store, spec = DriveStore(tmp_path), DriveSpec("thesis-exp1", scans=6, seed=0)
    store.simulate_missing([spec])
    drive = store.scorable(spec)
    model = sm.ParameterizedModel.thesis()
    idle = Candidate(model, sm.HsrParams(0.02, 0.15, 0.001, 0.06))
    busy = Candidate(model, sm.HsrParams.thesis())
    without, with_idle, with_busy = (
        score_candidate(each, drive, "brier", None) for each in (Candidate(model), idle, busy)
    )
    assert with_idle == without
    assert with_busy != without
