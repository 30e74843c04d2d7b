import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from support import THREE, make_log, random_log

import sonarmap as sm


@pytest.fixture
def log(rng):
    return random_log(rng, 200, truth=True)


def rewritten(path, change):
    """Replace the file's table by what `change` makes of it."""
    pq.write_table(change(pq.read_table(path, partitioning=None)), path)


@pytest.mark.parametrize("truth", [True, False])
def test_a_log_comes_back_bit_for_bit(truth, rng, tmp_path):
    log = random_log(rng, 200, truth=truth)
    log.write(tmp_path / "log.parquet")
    back = sm.read_log(tmp_path / "log.parquet")
    for name in log.DTYPES:
        assert getattr(back, name).tobytes() == getattr(log, name).tobytes(), name
    assert back.ring == log.ring == THREE
    assert back.provenance == log.provenance
    assert (back.truth is None) == (not truth)
    if truth:
        for name in log.truth.DTYPES:
            column, expected = getattr(back.truth, name), getattr(log.truth, name)
            if name == "surface":
                assert column.tolist() == expected.tolist()
            else:
                assert column.tobytes() == expected.tobytes(), name


def test_the_same_log_is_the_same_bytes(log, tmp_path):
    log.write(tmp_path / "a.parquet")
    sm.read_log(tmp_path / "a.parquet").write(tmp_path / "b.parquet")
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()


def test_the_order_of_the_provenance_does_not_matter(tmp_path):
    for name, provenance in (("a", {"seed": 1, "world": "x"}), ("b", {"world": "x", "seed": 1})):
        make_log(1.0, provenance=provenance).write(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_provenance_may_be_nested_and_in_any_language(tmp_path):
    provenance = {"world": {"door_m": 0.8, "name": "büro"}, "files": ["a", "b"], "seed": None}
    make_log(1.0, provenance=provenance).write(tmp_path / "log.parquet")
    assert sm.read_log(tmp_path / "log.parquet").provenance == provenance


def test_paths_may_be_strings_and_look_like_partitions(log, tmp_path):
    # Parquet readers like to take folders called name=value for columns.
    path = tmp_path / "scan=7" / "log.parquet"
    log.write(str(path))
    assert sm.read_log(str(path)).scan.tolist() == log.scan.tolist()


def test_an_older_log_is_replaced(log, tmp_path):
    make_log(1.0).write(tmp_path / "log.parquet")
    log.write(tmp_path / "log.parquet")
    assert len(sm.read_log(tmp_path / "log.parquet")) == len(log)
    assert [path.name for path in tmp_path.iterdir()] == ["log.parquet"]


# --- bad files -----------------------------------------------------------------------------------


def refusal(path):
    with pytest.raises(sm.InputError) as error:
        sm.read_log(path)
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


def test_a_missing_file(tmp_path):
    assert refusal(tmp_path / "nothing.parquet") == "no such file"


def test_a_folder(log, tmp_path):
    log.write(tmp_path / "logs" / "a.parquet")
    assert refusal(tmp_path / "logs").startswith("is not a readable Parquet file")


@pytest.mark.parametrize("share", [0.0, 0.2, 0.99])
def test_a_truncated_file(share, log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    assert refusal(path).startswith("is not a readable Parquet file: ")


def test_a_file_of_another_kind(tmp_path):
    path = tmp_path / "log.parquet"
    path.write_text("time,range\n0,1\n")
    assert refusal(path).startswith("is not a readable Parquet file: ")


def test_a_foreign_parquet_file(tmp_path):
    path = tmp_path / "other.parquet"
    pq.write_table(pa.table({"range_m": [1.0]}), path)
    assert refusal(path) == "is a Parquet file but not a sonar log (no 'sonarbed' metadata)"


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        ("not json", "its 'sonarbed' metadata is damaged"),
        ("[]", "its 'sonarbed' metadata is damaged"),
        ("{}", "its 'sonarbed' metadata is damaged"),
        ('{"format_version": 2}', "its 'sonarbed' metadata is damaged"),
        ('{"format_version": 3}', "its 'sonarbed' metadata is damaged"),
        ('{"format_version": 0}', "format version must be 1 to 3, got 0"),
        ('{"format_version": 4}', "format version must be 1 to 3, got 4"),
        ('{"format_version": "3"}', "format version must be 1 to 3, got '3'"),
        ('{"format_version": true}', "format version must be 1 to 3, got True"),
        (
            '{"format_version": 2, "ring": {"name": "x"}, "provenance": {}}',
            "ring: .*missing.*'x_m'.*",
        ),
    ],
)
def test_bad_metadata(metadata, message, log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)
    rewritten(path, lambda table: table.replace_schema_metadata({"sonarbed": metadata}))
    with pytest.raises(sm.InputError, match=f": {message}$"):
        sm.read_log(path)


def test_an_impossible_ring(log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)
    about = json.loads(pq.read_schema(path).metadata[b"sonarbed"])
    about["ring"]["range_max_m"] = -3
    rewritten(path, lambda t: t.replace_schema_metadata({"sonarbed": json.dumps(about)}))
    assert refusal(path) == "range_max_m must be > 0, got -3"


@pytest.mark.parametrize("column", ["range_m", "scan", "stale", "truth_cause", "truth_surface"])
def test_a_missing_column(column, log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)
    rewritten(path, lambda table: table.drop_columns([column]))
    assert refusal(path) == f"column '{column}' is missing"


def test_an_empty_value(log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)

    def punch(table):
        column = [None, *table["x_m"].to_pylist()[1:]]
        return table.set_column(table.column_names.index("x_m"), "x_m", pa.array(column))

    rewritten(path, punch)
    assert refusal(path) == "column 'x_m' must have no empty values, got 1"


@pytest.mark.parametrize("truth", [True, False])
def test_an_empty_log(truth, rng, tmp_path):
    path = tmp_path / "log.parquet"
    random_log(rng, 3, truth=truth).select(slice(0)).write(path)
    assert refusal(path) == "the log is empty: it has no reading"


@pytest.mark.parametrize(
    ("column", "row", "value", "message"),
    [
        ("range_m", 3, np.nan, "range_m[3] must be within [0, 20] m, +inf or -inf, got nan"),
        ("range_m", 4, -0.5, "range_m[4] must be within [0, 20] m, +inf or -inf, got -0.5"),
        ("range_m", 0, 3000.0, "range_m[0] must be within [0, 20] m, +inf or -inf, got 3000.0"),
        ("x_m", 2, np.nan, "x_m[2] must be a finite number, got nan"),
        ("time_s", 9, -1.0, "time_s[9] must be not less than the row before, got -1.0"),
        ("truth_y_m", 1, np.inf, "truth.y_m[1] must be a finite number, got inf"),
    ],
)
def test_a_value_that_breaks_its_rule(column, row, value, message, log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)

    def spoil(table):
        values = table[column].to_numpy().copy()
        values[row] = value
        return table.set_column(table.column_names.index(column), column, pa.array(values))

    rewritten(path, spoil)
    assert refusal(path) == message


def test_a_column_of_another_type(log, tmp_path):
    path = tmp_path / "log.parquet"
    log.write(path)
    words = pa.array(["near"] * len(log))
    rewritten(path, lambda t: t.set_column(t.column_names.index("range_m"), "range_m", words))
    assert refusal(path) == "range_m must be a column of float64"


def test_a_folder_in_the_way_of_a_log(log, tmp_path):
    with pytest.raises(sm.InputError, match=r": is a folder, a file name is needed$"):
        log.write(tmp_path)


# --- older versions ------------------------------------------------------------------------------

# Columns that each version did not have yet.
LACKING = {
    1: ["rejected", "doubt", "truth_source", "truth_level_db"],
    2: ["rejected", "doubt"],
}


def as_version(path, version, lacking):
    """Rewrite a file as one of an older version."""

    def older(table):
        about = json.loads(table.schema.metadata[b"sonarbed"]) | {"format_version": version}
        return table.drop_columns(lacking).replace_schema_metadata({"sonarbed": json.dumps(about)})

    rewritten(path, older)


@pytest.mark.parametrize("version", LACKING)
def test_an_older_log_is_read_and_what_it_lacks_is_unknown(version, log, tmp_path):
    path = tmp_path / "old.parquet"
    log.write(path)
    as_version(path, version, LACKING[version])
    back = sm.read_log(path)
    for name in set(log.DTYPES) - {"rejected", "doubt"}:
        assert getattr(back, name).tobytes() == getattr(log, name).tobytes(), name
    assert not back.rejected.any()
    assert np.isnan(back.doubt).all()
    if version == 1:
        assert (back.truth.source == sm.LogTruth.NO_SOURCE).all()
        assert np.isnan(back.truth.level_db).all()
    else:
        np.testing.assert_array_equal(back.truth.source, log.truth.source)
    # Written again it is a log of today.
    back.write(path)
    assert sm.read_log(path).rejected.size == len(log)


@pytest.mark.parametrize(
    ("version", "column"),
    [(3, "rejected"), (3, "doubt"), (3, "truth_source"), (2, "truth_level_db"), (1, "stale")],
)
def test_a_column_that_its_version_has_must_be_there(version, column, log, tmp_path):
    path = tmp_path / "old.parquet"
    log.write(path)
    as_version(path, version, [*{*LACKING.get(version, []), column}])
    assert refusal(path) == f"column {column!r} is missing"
