import subprocess
import sys
from pathlib import Path

import pytest

import sonarmap

HEAVY = ["numba", "pyarrow", "scipy", "matplotlib", "pybullet", "gymnasium", "worlds", "sim"]


def loaded_after(code):
    """Return which heavy modules a fresh process has loaded after running `code`."""
    look = f"import sys; print(*(name for name in {HEAVY} if name in sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}\n{look}"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def test_every_name_of_the_stub_is_there():
    for name in sonarmap.__all__:
        assert getattr(sonarmap, name) is not None
    assert set(sonarmap.__all__) <= set(dir(sonarmap))


# What users and outside checks rely on.
CONTRACT = {
    *("AMIGOBOT", "rings", "read_log", "import_log", "mark_stale", "SonarLog", "Cause"),
    *("GridSpec", "StandardModel", "ParameterizedModel", "build_map", "OccupancyMap"),
    *(
        "score_map",
        "MapScore",
        "InputError",
        "ParameterizedModel",
        "ring",
        "LogTruth",
        "eeruf_accepts",
    ),
    *("HsrParams", "HsrResult", "hsr", "score_readings", "ReadingScore", "goodness", "grid_over"),
    *("methods", "method", "MappingMethod", "filters", "filter", "ReadingFilter", "Filtered"),
    *(
        "Pipeline",
        "read_map",
        "export_log",
        "read_aria",
        "read_udacity",
        "SensorModel",
        "SonarRing",
    ),
}


def test_the_contract_is_kept():
    assert set(sonarmap.__all__) >= CONTRACT


@pytest.mark.parametrize(
    "before",
    [
        "from sonarmap.methods.bayes.models import StandardModel",
        "import sonarmap.methods, sonarmap.filters, sonarmap.filters.hsr",
        "import sonarmap as sm; sm.HsrParams, sm.StandardModel",
        "import sonarmap as sm; sm.methods, sm.filters; import sonarmap.methods.choosing",
    ],
)
def test_a_function_and_a_subpackage_may_have_one_name(before):
    # lazy-loader below 0.6 let the subpackage take the function's place.
    checks = "sm.methods(), sm.filters(), sm.method('bayes-standard'), sm.hsr.__call__"
    loaded_after(f"{before}\nimport sonarmap as sm; {checks}")


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = sonarmap.no_such_thing


def test_the_package_is_typed():
    assert (Path(sonarmap.__file__).parent / "py.typed").is_file()


@pytest.mark.parametrize(
    ("code", "loads"),
    [
        ("import sonarmap", set()),
        # a log in memory, its geometry, a model
        ("import sonarmap as sm; sm.SonarLog, sm.AMIGOBOT, sm.StandardModel, sm.GridSpec", set()),
        ("import sonarmap as sm; sm.import_log, sm.mark_stale", set()),
        ("import sonarmap as sm; sm.build_map", set()),
        # files need pyarrow, scores scipy; nothing ever needs a simulator
        ("import sonarmap as sm; sm.read_log", {"pyarrow"}),
        ("import sonarmap as sm; sm.score_map", {"scipy"}),
    ],
)
def test_what_is_heavy_is_loaded_when_it_is_used(code, loads):
    assert loaded_after(code) == loads


def test_a_log_is_written_read_and_mapped_without_a_simulator(tmp_path):
    code = f"""
import sonarmap as sm
log = sm.SonarLog(sm.AMIGOBOT, [0], [2], [0], [0], [0], [0], [1.0])
log.write({str(tmp_path / "log.parquet")!r})
model = sm.ParameterizedModel(0.02, 0.15, 0.05, 0.98, 0.26)
m = sm.build_map(sm.read_log({str(tmp_path / "log.parquet")!r}), model)
m.save({str(tmp_path / "map")!r})
assert m.probability.max() > 0.6
"""
    assert not loaded_after(code) & {"pybullet", "gymnasium", "worlds", "sim", "matplotlib"}
