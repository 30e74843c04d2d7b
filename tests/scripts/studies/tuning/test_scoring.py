import dataclasses

import pytest

import sonarmap as sm
from sonarbed.reporting.drives import DriveSpec, DriveStore
from sonarbed.studies.tuning.scoring import score_candidate
from sonarbed.studies.tuning.space import Candidate

pytestmark = pytest.mark.engine


def test_hsr_is_idle_where_no_reading_vouches(tmp_path):
    store, spec = DriveStore(tmp_path), DriveSpec("thesis-exp1", scans=6, seed=0, driver="thesis")
    store.simulate_missing([spec])
    drive = store.scorable(spec)
    method = sm.method("bayes-parameterized")
    idle, busy = (
        sm.filter("hsr", threshold_m=0.001),
        sm.filter("hsr", **dataclasses.asdict(sm.HsrParams.thesis())),
    )
    without, with_idle, with_busy = (
        score_candidate(Candidate(sm.Pipeline(filters, method)), drive, "brier")
        for filters in ([], [idle], [busy])
    )
    assert with_idle == without
    assert with_busy != without
