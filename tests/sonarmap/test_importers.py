import importlib.metadata
import math
from pathlib import Path

import numpy as np
import pytest
from support import REAL_LOG

import sonarmap as sm
from sonarmap.importers import FORMATS

INF = math.inf
AMIGO = sm.ring("amigobot-aria")

# Two sonars, to keep the tables short.
PAIR = sm.SonarRing("pair", [0, 0], [0.1, -0.1], [1.5, -1.5], 0.2, 0.17, 5.0)

MEASUREMENT = """\
1000 5110 1190
1250 2320 1190
1500 160 5000
"""
POSES = """\
1000 0 0 3590
1250 -100 20 3600
1500 -200 40 10
"""
ARIA = """\
time_ms,x,y,heading,s0,s1
1000,0,0,179,5000,1190
1250,-100,20,-180,2320,1190
1500,-200,40,-179,99,4999
"""


@pytest.fixture
def udacity(tmp_path):
    """Return a function that writes the two files and reads them."""

    def read(measurement=MEASUREMENT, poses=POSES, ring=PAIR):
        paths = [tmp_path / "measurement.txt", tmp_path / "poses.txt"]
        for path, text in zip(paths, (measurement, poses), strict=True):
            path.write_text(text, encoding="utf-8")
        return sm.read_udacity(*paths, ring)

    return read


@pytest.fixture
def aria(tmp_path):
    """Return a function that writes the table and reads it."""

    def read(text=ARIA, ring=PAIR, **options):
        path = tmp_path / "drive.csv"
        path.write_text(text, encoding="utf-8")
        return sm.read_aria(path, ring, **options)

    return read


def refusal(read, *args, **options):
    """Return the one line in which the input is refused, its folder left out."""
    with pytest.raises(sm.InputError) as error:
        read(*args, **options)
    message = str(error.value)
    assert "\n" not in message
    return message.replace(f"{Path(message.split(':')[0]).parent}/", "")


# --- udacity -------------------------------------------------------------------------------------


def test_udacity_units_and_codes(udacity):
    log = udacity()
    assert len(log) == 6
    assert log.scan.tolist() == [0, 0, 1, 1, 2, 2]
    assert log.sonar.tolist() == [0, 1, 0, 1, 0, 1]
    assert log.time_s.tolist() == [1.0, 1.0, 1.25, 1.25, 1.5, 1.5]
    assert log.x_m.tolist() == [0, 0, -0.1, -0.1, -0.2, -0.2]
    assert log.y_m.tolist() == [0, 0, 0.02, 0.02, 0.04, 0.04]
    # 5110 is no echo, so is what is not nearer than the ring's 5 m; nearer than 0.17 m is too close
    assert log.range_m.tolist() == [INF, 1.19, 2.32, 1.19, -INF, INF]
    assert log.ring == PAIR
    assert log.truth is None
    assert not log.stale.any()
    assert log.provenance == {"source": "udacity", "files": ["measurement.txt", "poses.txt"]}


def test_udacity_headings_run_on_over_the_wrap(udacity):
    log = udacity()
    assert np.rad2deg(log.heading_rad[::2]).tolist() == pytest.approx([359, 360, 361])


def test_udacity_has_its_own_ring(udacity):
    row = "1000" + " 1000" * 8 + "\n"
    log = udacity(row, "1000 0 0 0\n", ring=None)
    assert log.ring == sm.ring("udacity8")


def test_udacitys_no_echo_is_none_on_a_ring_that_sees_farther(udacity):
    far = sm.SonarRing.from_dict(PAIR.to_dict() | {"range_max_m": 8.0})
    log = udacity("1000 5110 5109\n", "1000 0 0 0\n", ring=far)
    assert log.range_m.tolist() == [INF, 5.109]


@pytest.mark.parametrize(
    "measurement",
    [
        MEASUREMENT.rstrip("\n"),
        MEASUREMENT + "\n\n",
        "\n" + MEASUREMENT,
        MEASUREMENT.replace(" ", "\t"),
        MEASUREMENT.replace("\n", " \r\n"),
        "\ufeff" + MEASUREMENT,
    ],
)
def test_udacity_spacing_does_not_matter(measurement, udacity):
    assert udacity(measurement).range_m.tolist() == udacity().range_m.tolist()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        # the row
        ("1250 2320", "3: must have 3 columns (time_ms to s1), got 2"),
        ("1250 2320 1190 77", "3: must have 3 columns (time_ms to s1), got 4"),
        # numbers
        ("1250 2320 near", "3: s1: must be a number, got 'near'"),
        ("1250 2,320 1190", "3: s0: must be a number, got '2,320'"),
        ("1250 nan 1190", "3: s0: must be a finite number, got 'nan'"),
        ("1250 2320 inf", "3: s1: must be a finite number, got 'inf'"),
        ("later 2320 1190", "3: time_ms: must be a number, got 'later'"),
        # ranges
        ("1250 -1 1190", "3: s0: must be within [0, 20000] mm, got -1"),
        ("1250 2320 20001", "3: s1: must be within [0, 20000] mm, got 20001"),
        # times
        ("999 2320 1190", "3: time_ms: must be not less than the row before, got 999"),
    ],
)
def test_bad_udacity_measurements(line, message, udacity):
    rows = MEASUREMENT.splitlines()
    # A blank line shows that lines are counted as an editor counts them.
    measurement = "\n".join([rows[0], "", line, rows[2]])
    assert refusal(udacity, measurement) == f"measurement.txt:{message}"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("1250 -100 20", "poses.txt:2: must have 4 columns (time_ms to heading), got 3"),
        ("1250 -100 20 north", "poses.txt:2: heading: must be a number, got 'north'"),
        ("1250 -100 nan 3600", "poses.txt:2: y: must be a finite number, got 'nan'"),
        (
            "1251 -100 20 3600",
            "poses.txt:2: time_ms: must be that of measurement.txt:2, 1250, got 1251",
        ),
    ],
)
def test_bad_udacity_poses(line, message, udacity):
    rows = POSES.splitlines()
    assert refusal(udacity, poses="\n".join([rows[0], line, rows[2]])) == message


def test_udacity_files_must_be_of_one_length(udacity):
    shorter = "".join(POSES.splitlines(keepends=True)[:2])
    assert refusal(udacity, poses=shorter) == (
        "measurement.txt:3: time_ms: must have its like in poses.txt, which ends at line 2, "
        "got 1500"
    )
    assert refusal(udacity, poses=POSES + "1750 0 0 0\n") == (
        "poses.txt:4: time_ms: must have its like in measurement.txt, which ends at line 3, "
        "got 1750"
    )


@pytest.mark.parametrize("text", ["", "\n \n"])
def test_empty_udacity_files(text, udacity):
    assert refusal(udacity, text) == (
        "measurement.txt: is empty, at least one row of values is needed"
    )
    assert refusal(udacity, poses=text) == (
        "poses.txt: is empty, at least one row of values is needed"
    )


# --- aria ----------------------------------------------------------------------------------------


def test_aria_units_and_codes(aria):
    log = aria()
    assert log.scan.tolist() == [0, 0, 1, 1, 2, 2]
    assert log.sonar.tolist() == [0, 1, 0, 1, 0, 1]
    assert log.time_s.tolist() == [1.0, 1.0, 1.25, 1.25, 1.5, 1.5]
    assert log.x_m.tolist() == [0, 0, -0.1, -0.1, -0.2, -0.2]
    assert log.range_m.tolist() == [INF, 1.19, 2.32, 1.19, -INF, 4.999]
    assert log.provenance == {"source": "aria", "files": ["drive.csv"]}


def test_aria_headings_run_on_over_the_wrap(aria):
    assert np.rad2deg(aria().heading_rad[::2]).tolist() == pytest.approx([179, 180, 181])


def test_aria_columns_may_stand_in_any_order_and_dress(aria):
    shuffled = " S1 ,HEADING,x,y,s0,time_ms\n 1190 , 179,0,0,5000,1000\n"
    a, b = aria(shuffled), aria().select(slice(2))
    for name in ("time_s", "x_m", "y_m", "heading_rad", "range_m"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_aria_times_may_be_in_seconds(aria):
    text = ARIA.replace("time_ms", "time_s").replace("\n1250", "\n1250.5")
    assert aria(text).time_s[::2].tolist() == [1000.0, 1250.5, 1500.0]


def test_without_times_the_scans_follow_each_other_evenly(aria):
    text = "x,y,heading,s0,s1\n" + "0,0,0,1000,1000\n" * 3
    log = aria(text, scan_period_s=0.175)
    assert log.time_s[::2].tolist() == pytest.approx([0, 0.175, 0.35])
    assert log.provenance["scan_period_s"] == 0.175
    assert aria(text).time_s[-1] == pytest.approx(0.2)


def test_aria_readings_at_the_rings_maximum_are_no_echo(aria):
    text = "x,y,heading," + ",".join(f"s{i}" for i in range(8)) + "\n"
    text += "0,0,0,2999,3000,3001,5000,165,164,0,2000\n"
    assert aria(text, ring=sm.AMIGOBOT).range_m.tolist() == [
        2.999, INF, INF, INF, 0.165, -INF, -INF, 2.0,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("x,y,s0,s1", "column 'heading' is missing"),
        ("x,y,heading,s0", "column 's1' is missing: ring 'pair' has s0 to s1"),
        ("x,y,heading,s0,s1,s2", "column 's2' is unknown: ring 'pair' has s0 to s1"),
        ("x,y,headng,s0,s1", "column 'headng' is unknown; did you mean 'heading'?"),
        ("time,x,y,heading,s0,s1", "column 'time' is unknown; did you mean 'time_s'?"),
        ("x,y,heading,s0,s1,s0", "column 's0' must be there once"),
        (
            "time_s,time_ms,x,y,heading,s0,s1",
            "must have one column of times, got time_s and time_ms",
        ),
    ],
)
def test_bad_aria_headers(header, message, aria):
    assert refusal(aria, f"{header}\n1,2,3,4,5\n") == f"drive.csv:1: {message}"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("1250,0,0,0,1000", "must have 6 columns (time_ms to s1), got 5"),
        ("1250,0,0,0,1000,1000,", "must have 6 columns (time_ms to s1), got 7"),
        ("1250,0,0,0,,1000", "s0: must be a number, got ''"),
        ("1250,0,0,0,1000,far", "s1: must be a number, got 'far'"),
        ("1250,0,0,nan,1000,1000", "heading: must be a finite number, got 'nan'"),
        ("1250,0,0,0,-5,1000", "s0: must be within [0, 20000] mm, got -5"),
        ("1250,0,0,0,1000,65535", "s1: must be within [0, 20000] mm, got 65535"),
        ("900,0,0,0,1000,1000", "time_ms: must be not less than the row before, got 900"),
    ],
)
def test_bad_aria_rows(line, message, aria):
    rows = ARIA.splitlines()
    text = "\n".join([rows[0], rows[1], "", line, rows[3]])
    assert refusal(aria, text) == f"drive.csv:4: {message}"


def test_an_aria_table_without_a_row(aria):
    message = "drive.csv: is empty, at least one row of values is needed"
    assert refusal(aria, "") == message
    assert refusal(aria, "x,y,heading,s0,s1\n") == message


def test_a_bad_period(aria):
    assert refusal(aria, scan_period_s=0) == "scan_period_s must be > 0, got 0"


# --- any format ----------------------------------------------------------------------------------


def test_a_missing_file_a_folder_and_what_is_no_text(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "image.csv").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe")
    for name, message in [
        ("nothing.csv", "no such file"),
        ("folder", "cannot be read: Is a directory"),
        ("image.csv", "is not a text file"),
    ]:
        assert refusal(sm.read_aria, tmp_path / name, PAIR) == f"{name}: {message}"
        assert refusal(sm.read_udacity, tmp_path / name, tmp_path / name) == f"{name}: {message}"


def test_import_log_reads_every_format(udacity, aria, tmp_path):
    expected = {"udacity": udacity(), "aria": aria()}
    files = {"udacity": ["measurement.txt", "poses.txt"], "aria": ["drive.csv"]}
    assert set(FORMATS) == set(expected)
    for name, log in expected.items():
        again = sm.import_log([tmp_path / file for file in files[name]], name, PAIR)
        assert again.range_m.tolist() == log.range_m.tolist()
        assert again.provenance == log.provenance


@pytest.mark.parametrize(
    ("paths", "name", "ring", "message"),
    [
        (["a"], "udacty", None, "format 'udacty' is unknown; did you mean 'udacity'?"),
        (["a"], "udacity", None,
         "format 'udacity' must get 2 files (measurement.txt, poses.txt), got 1"),
        (["a"] * 3, "udacity", None,
         "format 'udacity' must get 2 files (measurement.txt, poses.txt), got 3"),
        ([], "aria", AMIGO, "format 'aria' must get 1 file (a CSV table), got 0"),
        (["a"], "aria", None,
         "format 'aria' needs the ring of the robot, e.g. 'amigobot-aria'"),
    ],
)  # fmt: skip
def test_what_import_log_refuses(paths, name, ring, message):
    with pytest.raises(sm.InputError) as error:
        sm.import_log(paths, name, ring)
    assert str(error.value) == message


# A whole importer, as a person would write it: one range in metres a line, of one sonar.
TOY = """
import numpy as np
import sonarmap as sm


def read_toy(paths, ring):
    range_m = np.loadtxt(paths[0], ndmin=1)
    still = np.zeros(range_m.size)
    steps = np.arange(range_m.size)
    return sm.SonarLog(ring or sm.AMIGOBOT, steps, still, steps, still, still, still, range_m)


def read_nothing(paths, ring):
    return "nothing"
"""


@pytest.fixture
def toy(tmp_path, monkeypatch):
    """Write the importer and a file for it, and return the file's path."""
    (tmp_path / "toy_importer.py").write_text(TOY, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "toy.txt"
    path.write_text("1.5\ninf\n", encoding="utf-8")
    return path


def test_ones_own_importer_is_a_callable_or_named_by_its_module(toy):
    import toy_importer

    for format_ in (toy_importer.read_toy, "toy_importer:read_toy"):
        log = sm.import_log([toy], format_, PAIR)
        assert log.ring == PAIR
        assert log.range_m.tolist() == [1.5, INF]


def test_an_installed_package_adds_a_format(toy, monkeypatch):
    point = importlib.metadata.EntryPoint("toy", "toy_importer:read_toy", "sonarbed.importers")
    monkeypatch.setattr(
        "sonarmap.registry.entry_points",
        lambda *, group: [point] if group == point.group else [],
    )
    assert list(FORMATS) == ["udacity", "aria", "toy"]
    assert sm.import_log([toy], "toy").ring == sm.AMIGOBOT


@pytest.mark.parametrize(
    ("format_", "message"),
    [
        ("toy_importer:red_toy", "format 'toy_importer:red_toy' cannot be imported"),
        ("toy_importer:TOY", "format 'toy_importer:TOY' cannot be imported"),
        ("toy_importer:__name__", "format must be callable with (paths, ring), got 'toy_importer'"),
        (
            "toy_importer:read_nothing",
            "format 'toy_importer:read_nothing' must return a SonarLog, got str",
        ),
        (lambda paths, ring: None, "format '<lambda>' must return a SonarLog, got NoneType"),
        (3, "format must be callable with (paths, ring), got 3"),
    ],
)
def test_an_importer_that_does_not_do(format_, message, toy):
    with pytest.raises(sm.InputError) as error:
        sm.import_log([toy], format_)
    assert str(error.value).startswith(message)


def test_an_imported_log_can_be_written_and_read(udacity, tmp_path):
    log = udacity()
    log.write(tmp_path / "log.parquet")
    back = sm.read_log(tmp_path / "log.parquet")
    assert back.range_m.tobytes() == log.range_m.tobytes()
    assert back.provenance == log.provenance


# --- the real log --------------------------------------------------------------------------------


@pytest.mark.skipif(not REAL_LOG.is_dir(), reason="the real log is not part of the repository")
def test_the_real_corridor_log():
    log = sm.import_log([REAL_LOG / "measurement.txt", REAL_LOG / "poses.txt"], "udacity")
    assert len(log) == 3304
    assert log.scan[-1] + 1 == 413
    assert log.time_s[-1] - log.time_s[0] == pytest.approx(92.8, abs=0.05)
    assert 0.32 < np.isposinf(log.range_m).mean() < 0.335

    one_sonar = log.select(log.sonar == 0)
    steps_m = np.hypot(np.diff(one_sonar.x_m), np.diff(one_sonar.y_m))
    assert steps_m.sum() == pytest.approx(25.0, abs=0.05)
    assert np.abs(np.diff(log.heading_rad)).max() < 0.2, "a heading jumps by a turn"

    marked = sm.mark_stale(log)
    stale = [marked.stale[marked.sonar == sonar].mean() for sonar in range(8)]
    assert min(stale) == pytest.approx(0.59, abs=0.01)
    assert max(stale) == pytest.approx(0.88, abs=0.01)


@pytest.mark.skipif(not REAL_LOG.is_dir(), reason="the real log is not part of the repository")
def test_the_real_corridors_map_is_an_l_of_free_space_between_walls():
    log = sm.import_log([REAL_LOG / "measurement.txt", REAL_LOG / "poses.txt"], "udacity")
    model = sm.ParameterizedModel(0.02, 0.15, 0.1, 0.98, math.radians(10))
    m = sm.build_map(sm.mark_stale(log), model, max_range_m=2.0)

    def box(x_m, y_m):
        (row, row_end), (col, col_end) = m.grid.cell_of(x_m, y_m)
        return m.log_odds[row:row_end, col:col_end]

    # The first corridor lies along x, the second along -y; what the L leaves out is unknown.
    assert (box((0.5, 13.0), (-10.0, -3.0)) == 0).all()
    # Beside the first one a wall 1.2 m to the left and one 0.9 m to the right, straight for 8 m.
    for low_m, high_m in ((1.0, 1.4), (-1.1, -0.7)):
        wall = (box((0.5, 8.5), (low_m, high_m)) > 0).any(axis=0)
        assert wall.mean() > 0.6
    between = box((0.5, 8.5), (-0.5, 0.9))
    assert (between < 0).mean() > 0.6
    assert (between > 0).mean() < 0.05
    # The robot drove through no wall.
    path = m.log_odds[m.grid.cell_of(log.x_m, log.y_m)]
    assert (path > 0).mean() < 0.02


# --- as others write tables ----------------------------------------------------------------------

HEADER = ["time_s", "x", "y", "heading", *(f"s{i}" for i in range(8))]
SCANS = [
    ["0.0", "0", "0", "0", "1200", "1450", "2310", "3020", "2950", "2200", "1400", "1250"],
    ["0.5", "50.5", "-1.5", "1", "1190", "1440", "2280", "2970", "2900", "2190", "1390", "1260"],
]


def table_text(separator, *, comma=False):
    lines = [separator.join(HEADER)]
    for scan in SCANS:
        lines.append(separator.join(v.replace(".", ",") if comma else v for v in scan))
    return "\n".join(lines) + "\n"


@pytest.fixture
def plain(tmp_path):
    (tmp_path / "plain.csv").write_text(table_text(","))
    return sm.read_aria(tmp_path / "plain.csv", sm.ring("amigobot-aria"))


@pytest.mark.parametrize(
    "data",
    [
        table_text(";").encode(),
        table_text(";", comma=True).encode(),
        table_text("\t").encode(),
        table_text("\t", comma=True).encode(),
        table_text(", ").encode(),
        ("\n" + table_text(";", comma=True)).encode("utf-16"),
        table_text(",").encode("utf-8-sig"),
        table_text(",").replace("\n", "\r\n").encode(),
    ],
)
def test_tables_of_any_spreadsheet_are_the_same_log(data, plain, tmp_path):
    path = tmp_path / "table.csv"
    path.write_bytes(data)
    log = sm.read_aria(path, sm.ring("amigobot-aria"))
    for name in log.DTYPES:
        np.testing.assert_array_equal(getattr(log, name), getattr(plain, name))


def test_a_table_in_columns_of_blanks_is_told_what_to_do(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(table_text("  "))
    with pytest.raises(
        sm.InputError, match=r"its columns must be separated by commas, semicolons or tabs$"
    ):
        sm.read_aria(path, sm.ring("amigobot-aria"))


@pytest.mark.parametrize("per_mm", [0.001, 0.01])
def test_ranges_in_metres_are_not_all_too_close(per_mm, tmp_path):
    path = tmp_path / "table.csv"
    scans = [[*scan[:4], *(f"{float(v) * per_mm:g}" for v in scan[4:])] for scan in SCANS]
    path.write_text("\n".join(",".join(row) for row in [HEADER, *scans]))
    longest = f"{3020 * per_mm:g}"
    with pytest.raises(
        sm.InputError, match=rf"ranges must be in millimetres.* the longest is {longest}: metres\?$"
    ):
        sm.read_aria(path, sm.ring("amigobot-aria"))


def test_a_pioneer_with_its_front_array_only(plain, tmp_path):
    log = sm.read_aria(tmp_path / "plain.csv", sm.ring("pioneer3dx-front"))
    front, whole = sm.ring("pioneer3dx-front"), sm.ring("pioneer3dx")
    assert len(front) == 8
    np.testing.assert_array_equal(front.heading_rad, whole.heading_rad[:8])
    np.testing.assert_array_equal(log.range_m, plain.range_m)
