"""How well a candidate maps a drive, by the scores that a search may go by."""

from __future__ import annotations

from types import MappingProxyType

import sonarmap as sm
from sonarbed.reporting.drives import ScorableDrive
from sonarbed.studies.tuning.space import Candidate

__all__ = ["SCORES", "score_candidate"]

# Scores by name, and whether a higher one is better.
SCORES = MappingProxyType(
    {
        "skill": True,
        "map_score": True,
        "average_precision": True,
        "f1_10_cm": True,
        "brier": False,
    }
)
_TEN_CM = 1  # index of the tolerance


def score_candidate(candidate: Candidate, drive: ScorableDrive, score: str) -> float:
    """Return the score, over observable cells, of the map that a candidate makes of a drive."""
    built = candidate.pipeline.map(drive.log, drive.truth.grid)
    scored = sm.score_map(built, drive.truth, observable=drive.observable)
    return scored.f1(_TEN_CM) if score == "f1_10_cm" else float(getattr(scored, score))
