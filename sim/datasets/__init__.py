"""Data sets of labelled logs: from a spec to a folder of Parquet files that is one table.

>>> spec = read_spec("spec.toml")
>>> summary = make_dataset(spec, "out", workers=2)
"""

from sim.datasets.making import DatasetProgress, DatasetReport, make_dataset
from sim.datasets.manifest import DatasetSummary
from sim.datasets.reading import parse_spec, read_spec
from sim.datasets.spec import DatasetSpec

__all__ = [
    "DatasetProgress",
    "DatasetReport",
    "DatasetSpec",
    "DatasetSummary",
    "make_dataset",
    "parse_spec",
    "read_spec",
]
