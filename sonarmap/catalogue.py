"""The parts that ship with the core, by name: a new one is a file, and one line here.

Only names stand here, so that the command line can list them without loading anything.
"""

from __future__ import annotations

from typing import Any

from sonarmap.registry import Registry

__all__ = ["EXPORTERS", "FILTERS", "IMPORTERS", "METHODS", "RINGS"]

METHODS: Registry[Any] = Registry(
    "method",
    "sonarbed.methods",
    {
        "arc-competition": "sonarmap.methods.arc_competition:ArcCompetition",
        "atm": "sonarmap.methods.atm:ArcTransversalMedian",
        "bayes-gaussian": "sonarmap.methods.bayes_gaussian:BayesGaussian",
        "bayes-parameterized": "sonarmap.methods.bayes.parameterized:BayesParameterized",
        "bayes-standard": "sonarmap.methods.bayes.standard:BayesStandard",
        "bki": "sonarmap.methods.bki:BayesianKernel",
        "conflict-evaluation-style": "sonarmap.methods.conflict_evaluation:ConflictEvaluation",
        "dempster-shafer": "sonarmap.methods.dempster_shafer:DempsterShafer",
        "forward-bp": "sonarmap.methods.forward.propagation:ForwardBp",
        "free-space": "sonarmap.methods.free_space:FreeSpace",
        "fuzzy": "sonarmap.methods.fuzzy:Fuzzy",
        "himm": "sonarmap.methods.himm:Himm",
        "konolige-style": "sonarmap.methods.konolige:KonoligeStyle",
        "learned": "sonarmap.methods.learned:Learned",
        "moravec-elfes": "sonarmap.methods.moravec_elfes:MoravecElfes",
        "nav2-range": "sonarmap.methods.nav2_range:Nav2Range",
        "sheet": "sonarmap.methods.sheet:Sheet",
        "tbf": "sonarmap.methods.tbf:TriangulationFusion",
        "thrun-forward": "sonarmap.methods.forward.climbing:ThrunForward",
        "thrun-inverse": "sonarmap.methods.thrun_inverse:ThrunInverse",
    },
)

FILTERS: Registry[Any] = Registry(
    "filter",
    "sonarbed.filters",
    {
        "conflict-evaluation-style": "sonarmap.filters.conflict_evaluation:ConflictEvaluationStyle",
        "consistency": "sonarmap.filters.consistency:Consistency",
        "eeruf": "sonarmap.filters.eeruf:EerufTest",
        "gamma-variance": "sonarmap.filters.gamma_variance:GammaVariance",
        "hsr": "sonarmap.filters.hsr:Hsr",
        "linear-features-style": "sonarmap.filters.linear_features:LinearFeaturesStyle",
        "median-of-repeats": "sonarmap.filters.repeats:MedianOfRepeats",
        "none": "sonarmap.filters.none:NoFilter",
        "oracle-drop": "sonarmap.filters.oracles:OracleDrop",
        "oracle-mend": "sonarmap.filters.oracles:OracleMend",
        "range-confidence-style": "sonarmap.filters.range_confidence:RangeConfidenceStyle",
        "stale": "sonarmap.filters.stale:MarkStale",
    },
)

IMPORTERS: Registry[Any] = Registry(
    "format",
    "sonarbed.importers",
    {
        "udacity": "sonarmap.importers.udacity:UDACITY",
        "aria": "sonarmap.importers.aria:ARIA",
    },
)

# A format has the name of its files' suffix.
EXPORTERS: Registry[Any] = Registry(
    "format",
    "sonarbed.exporters",
    {"csv": "sonarmap.exporters.csv:CSV"},
)

RINGS: Registry[Any] = Registry(
    "ring",
    "sonarbed.rings",
    {
        "amigobot": "sonarmap.rings:AMIGOBOT",
        "amigobot-aria": "sonarmap.rings:AMIGOBOT_ARIA",
        "amigobot-h8": "sonarmap.rings:AMIGOBOT_H8",
        "hc-sr04-3": "sonarmap.rings:HC_SR04_3",
        "hc-sr04-8": "sonarmap.rings:HC_SR04_8",
        "pioneer3dx": "sonarmap.rings:PIONEER_3DX",
        "pioneer3dx-front": "sonarmap.rings:PIONEER_3DX_FRONT",
        "udacity8": "sonarmap.rings:UDACITY_8",
    },
)
