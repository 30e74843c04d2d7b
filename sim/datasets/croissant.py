"""``croissant.json``: a data set as loaders of machine learning read it, by its description."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pyarrow as pa

from sim.datasets.logs import LOG_COLUMN
from sim.datasets.manifest import MANIFEST, SCHEMA, DatasetSummary
from sim.datasets.spec import DatasetSpec
from sonarmap import LogTruth, SonarLog

__all__ = ["CROISSANT", "croissant_text"]

CROISSANT = "croissant.json"
_LOGS = "logs/*/*/*.parquet"

# Croissant 1.0: https://docs.mlcommons.org/croissant/docs/croissant-spec.html
_CONTEXT = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileObject": "cr:fileObject",
    "fileProperty": "cr:fileProperty",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}


def croissant_text(spec: DatasetSpec, summary: DatasetSummary, manifest_sha256: str) -> str:
    """Return the text of ``croissant.json``."""
    readings = sum(summary.readings.values())
    described = spec.description or (
        f"{sum(summary.logs.values())} simulated sonar logs, {readings} labelled readings."
    )
    optional = {
        "license": spec.license,
        "url": spec.url,
        "datePublished": spec.date,
        "citeAs": spec.citation,
        "creator": {"@type": "Person", "name": spec.creator} if spec.creator else "",
    }
    return (
        json.dumps(
            {
                "@context": _CONTEXT,
                "@type": "sc:Dataset",
                "name": spec.name,
                "description": described,
                "conformsTo": "http://mlcommons.org/croissant/1.0",
                "version": "1.0.0",
                **{key: value for key, value in optional.items() if value},
                "distribution": [
                    {
                        "@type": "cr:FileObject",
                        "@id": "manifest",
                        "name": "manifest",
                        "description": "One row a log: what it is and how often each cause is.",
                        "contentUrl": MANIFEST,
                        "encodingFormat": "application/x-parquet",
                        "sha256": manifest_sha256,
                    },
                    {
                        "@type": "cr:FileSet",
                        "@id": "logs",
                        "name": "logs",
                        "description": "One file a log, in partitions by split and room.",
                        "encodingFormat": "application/x-parquet",
                        "includes": _LOGS,
                    },
                ],
                "recordSet": [_logs(), _readings()],
            },
            indent=2,
        )
        + "\n"
    )


def _logs() -> dict[str, Any]:
    return {
        "@type": "cr:RecordSet",
        "@id": "log",
        "name": "log",
        "description": "The logs.",
        "key": {"@id": "log/log"},
        "field": [
            _field("log", field.name, _type(field.type), {"fileObject": {"@id": "manifest"}})
            for field in SCHEMA
        ],
    }


def _readings() -> dict[str, Any]:
    columns = {LOG_COLUMN: "sc:Text"}
    columns |= {name: _numpy_type(dtype) for name, dtype in SonarLog.DTYPES.items()}
    columns |= {
        LogTruth.PREFIX + name: _numpy_type(dtype) for name, dtype in LogTruth.DTYPES.items()
    }
    return {
        "@type": "cr:RecordSet",
        "@id": "reading",
        "name": "reading",
        "description": "The readings of all logs, with what was true.",
        "field": [
            _field("reading", name, kind, {"fileSet": {"@id": "logs"}})
            for name, kind in columns.items()
        ],
    }


def _field(record: str, name: str, kind: str, source: dict[str, Any]) -> dict[str, Any]:
    return {
        "@type": "cr:Field",
        "@id": f"{record}/{name}",
        "name": name,
        "dataType": kind,
        "source": {**source, "extract": {"column": name}},
    }


def _type(kind: pa.DataType) -> str:
    if pa.types.is_integer(kind):
        return "sc:Integer"
    return "sc:Float" if pa.types.is_floating(kind) else "sc:Text"


def _numpy_type(dtype: Any) -> str:
    kinds = {"i": "sc:Integer", "f": "sc:Float", "b": "sc:Boolean", "U": "sc:Text"}
    return kinds[np.dtype(dtype).kind]
