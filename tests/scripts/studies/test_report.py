"""The report of invented sections, and how studies are run, kept, resumed and refused."""

import csv
import errno
import json
import re
from html.parser import HTMLParser
from types import SimpleNamespace

import pytest
from matplotlib.figure import Figure

import sonarbed.reporting.setting as setting_module
import sonarbed.studies.thesis as studies
from sonarbed.cli import main
from sonarbed.reporting.report import write_report
from sonarbed.reporting.section import ANSWERED_BY, QUESTIONS, Answer, Item, Section
from sonarbed.reporting.setting import Setting
from sonarmap import InputError

VOID = {"meta", "img", "br", "link", "hr", "input"}


class Page(HTMLParser):
    """What a page shows and refers to; fails on tags that do not nest."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.links, self.text, self.open = [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.links += [value for name, value in attrs if name in {"src", "href"}]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)

    @property
    def words(self):
        return " ".join("".join(self.text).split())


@pytest.fixture
def setting(tmp_path):
    return Setting(tmp_path / "report", quick=True, jobs=1)


def invented(setting, *, study="sensor_models", rows=3, text='1 < 2 & 3 > 2 | "so"', answers=()):
    """Write and return a section with two items, a picture and a table."""
    there = setting.on_study(study)
    figure = Figure(figsize=(1, 1))
    figure.subplots().plot([0, 1])
    picture = there.figure("picture", figure, f"picture of {text}")
    table = there.table("table", ("a|b", "<c>"), [(f"row{i}", i) for i in range(rows)], "numbers")
    section = Section(
        study,
        f"Study {study}",
        (
            Item("Figure 1.1", "the thesis says", text, (picture,), (table,)),
            Item("Table 1.2", "and also", "we find"),
        ),
        tuple(answers),
    )
    section.save(there.place)
    return section


def written(setting, *sections):
    html, markdown = write_report(setting, sections)
    return html.read_text(encoding="utf-8"), markdown.read_text(encoding="utf-8")


# What a report shows.


def test_page_is_self_contained_and_shows_every_item(setting):
    html, _ = written(setting, invented(setting), invented(setting, study="openings"))
    page = Page(html)
    assert all(link.startswith(("data:image/png;base64,", "#")) for link in page.links)
    assert not re.search(r"https?:|@import|<script|url\(", html)
    assert page.tags.count("img") == 2
    for words in ("Study openings", "Figure 1.1", "Table 1.2", "the thesis says", "row2"):
        assert words in page.words


def test_page_links_lead_to_places_within_it(setting):
    section = invented(setting, study="openings", answers=[Answer(6, "yes")])
    html, _ = written(setting, section, invented(setting))
    targets = {link[1:] for link in Page(html).links if link.startswith("#")}
    assert targets == {"openings", "sensor_models"}
    assert all(f'id="{target}"' in html for target in targets)


def test_page_escapes_what_texts_contain(setting):
    text = "<script>alert('x')</script> & \"quoted\""
    html, _ = written(setting, invented(setting, text=text))
    page = Page(html)
    assert "script" not in page.tags
    assert text in page.words


def test_markdown_has_the_same_items_and_links_to_files_beside_it(setting):
    _, markdown = written(setting, invented(setting))
    for words in ("## Study sensor_models", "### Figure 1.1", "### Table 1.2", "| row2 | 2 |"):
        assert words in markdown
    for link in re.findall(r"\]\(([^)]+)\)", markdown):
        assert (setting.folder / link).is_file(), link


def test_markdown_tables_keep_their_columns(setting):
    answers = [Answer(6, "a | b\nand more")]
    _, markdown = written(setting, invented(setting, answers=answers))
    assert "| a\\|b | <c> |" in markdown
    (row,) = [line for line in markdown.splitlines() if line.startswith("| 6 |")]
    assert "a \\| b and more" in row
    assert len(re.findall(r"(?<!\\)\|", row)) == 4


@pytest.mark.parametrize(("rows", "shown", "noted"), [(40, 40, False), (41, 40, True)])
def test_tables_are_cut_at_40_rows_with_a_note(setting, rows, shown, noted):
    html, markdown = written(setting, invented(setting, rows=rows))
    for text in (html, markdown):
        assert len(re.findall(r"\brow\d+\b", text)) == shown
        assert (f"{rows} rows, the first 40 shown" in text) == noted
    with (setting.folder / "sensor_models" / "table.csv").open(newline="") as stream:
        assert len(list(csv.reader(stream))) == rows + 1


def test_questions_say_which_study_is_missing(setting):
    half = invented(setting, study="openings", answers=[Answer(6, "half an answer")])
    html, markdown = written(setting, half)
    for text in (Page(html).words, markdown):
        assert "half an answer" in text
        assert "Not run yet: target_distance." in text
        assert "Not run yet: wall_sizes." in text
        assert "openings." not in re.findall(r"Not run yet: ([^.]*\.)", text)
    html, _ = written(setting, half, invented(setting, study="target_distance"))
    assert "target_distance." not in re.findall(r"Not run yet: ([^.]*\.)", html)


def test_every_question_has_a_study_that_exists():
    assert set(ANSWERED_BY) == set(QUESTIONS)
    assert {study for names in ANSWERED_BY.values() for study in names} <= set(studies.STUDIES)


def test_no_section_is_a_report_too(setting):
    html, markdown = written(setting)
    assert Page(html).tags.count("tr") == 1 + len(QUESTIONS)
    assert markdown.count("Not run yet") == len(QUESTIONS)


def test_a_lost_picture_is_one_clear_line(setting):
    section = invented(setting)
    (setting.folder / "sensor_models" / "picture.png").unlink()
    with pytest.raises(
        InputError, match=r"picture\.png: is missing.*--study sensor_models --again"
    ):
        write_report(setting, [section])


# Sections and folders.


def test_section_saved_and_loaded_is_the_same(setting):
    section = invented(setting, answers=[Answer(1, "ja, größer"), Answer(6, "no")])
    assert Section.load(setting.folder / "sensor_models") == section


def test_a_study_without_a_section_is_not_done(tmp_path):
    assert Section.load(tmp_path) is None


def test_a_question_that_is_not_asked_cannot_be_answered():
    with pytest.raises(InputError, match="question must be 1 to 6, got 7"):
        Answer(7, "42")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "{}",
        '{"study": "x", "title": "t", "items": [{}], "answers": []}',
        '{"study": "x", "title": "t", "items": [], "answers": [{"question": 9, "text": ""}]}',
        b"\xff\xfe",
    ],
)
def test_a_damaged_section_is_refused_by_name(tmp_path, text):
    file = tmp_path / "section.json"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=r"section\.json: is not a section"):
        Section.load(tmp_path)


def test_a_folder_is_claimed_once_and_again_by_the_same_setting(setting):
    setting.claim()
    setting.claim()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"quick": False}, "holds a report with quick False, asked for True"),
        ({"sonar": "aria"}, "holds a report with sonar 'aria', asked for 'thesis'"),
        ({"sonarbed": "0.0.1"}, "holds a report with sonarbed '0.0.1'"),
        ({"format": 0}, "holds a report with format 0"),
    ],
)
def test_a_folder_of_another_setting_is_refused(setting, change, message):
    setting.claim()
    file = setting.folder / "setting.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(InputError, match=f"{message}.*choose another folder"):
        setting.claim()


@pytest.mark.parametrize("text", ["", "{", "[]", "3"])
def test_a_damaged_setting_is_refused(setting, text):
    setting.claim()
    (setting.folder / "setting.json").write_text(text)
    with pytest.raises(InputError, match=r"setting\.json: is not the setting of a report"):
        setting.claim()


# The work of a setting.


def square(number):
    if number == 13:
        raise InputError("13 must not be squared")
    return number**2


@pytest.mark.parametrize("jobs", [1, 2])
def test_map_keeps_the_order_whatever_the_jobs(setting, jobs):
    told = []
    at_work = Setting(setting.folder, jobs=jobs, on_progress=lambda *told_: told.append(told_))
    assert at_work.map(square, [3, 1, 2], "squares") == [9, 1, 4]
    assert told[0] == ("squares", 0, 3)
    assert told[-1] == ("squares", 3, 3)


@pytest.mark.parametrize("jobs", [1, 2])
def test_map_passes_errors_on(setting, jobs):
    with pytest.raises(InputError, match="13 must not be squared"):
        Setting(setting.folder, jobs=jobs).map(square, [1, 13, 2], "squares")


def test_map_of_nothing_is_nothing(setting):
    assert setting.map(square, [], "squares") == []


def test_logs_of_other_rooms_are_other_files(setting, monkeypatch):
    asked = []
    monkeypatch.setattr(setting_module, "_simulate", lambda task: asked.append(task[0].name))
    monkeypatch.setattr(setting_module.sm, "read_log", lambda path: path)
    for gap_m in (0.8, 0.80000001):
        setting.logs(
            "opening-rig", seeds=[3], scans=7, parameters={"gap_m": gap_m, "distance_m": 1}
        )
    setting.logs("opening-rig", seeds=[3], scans=7)
    assert asked == [
        "opening-rig-distance_m=1.0-gap_m=0.8-thesis-thesis-7-0003.parquet",
        "opening-rig-distance_m=1.0-gap_m=0.80000001-thesis-thesis-7-0003.parquet",
        "opening-rig-thesis-thesis-7-0003.parquet",
    ]


# The command.


@pytest.fixture
def fake_studies(monkeypatch):
    """Replace every study by one that counts its runs; some can be told to fail."""
    told = SimpleNamespace(ran=[], failing={})

    def load(name):
        def run(setting):
            told.ran.append(name)
            if name in told.failing:
                raise told.failing[name]
            return invented(setting, study=name)

        return run

    monkeypatch.setattr(studies, "load", load)
    monkeypatch.setattr(studies, "STUDIES", ("sensor_models", "openings", "readings"))
    return told


def test_a_study_that_is_done_is_not_run_again(fake_studies, tmp_path):
    command = ["thesis", "--out", str(tmp_path), "--quick"]
    assert main([*command, "--study", "openings"]) == 0
    assert main(command) == 0
    assert fake_studies.ran == ["openings", "sensor_models", "readings"]
    page = Page((tmp_path / "report.html").read_text()).words
    assert page.index("Study sensor_models") < page.index("Study openings")


def test_again_runs_it_again(fake_studies, tmp_path):
    command = ["thesis", "--out", str(tmp_path), "--quick", "--study", "openings"]
    assert main(command) == main([*command, "--again"]) == 0
    assert fake_studies.ran == ["openings", "openings"]


def test_a_damaged_study_is_mended_by_the_command_that_its_error_tells(
    fake_studies, tmp_path, capsys
):
    command = ["thesis", "--out", str(tmp_path), "--quick", "--study", "openings"]
    assert main(command) == 0
    (tmp_path / "openings" / "section.json").write_text("{")
    assert main(command) == 2
    assert "--study openings --again" in capsys.readouterr().err
    assert main([*command, "--again"]) == 0


@pytest.mark.parametrize(
    ("error", "code", "line"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (InputError("a room is not there"), 2, "a room is not there"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "No space left on device"),
    ],
)
def test_an_interrupted_report_keeps_what_is_done(
    fake_studies, tmp_path, capsys, error, code, line
):
    command = ["thesis", "--out", str(tmp_path), "--quick"]
    fake_studies.failing["openings"] = error
    assert main(command) == code
    told = capsys.readouterr().err
    assert line in told
    assert len(told.strip().splitlines()) == 1
    fake_studies.failing.clear()
    assert main(command) == 0
    assert fake_studies.ran == ["sensor_models", "openings", "openings", "readings"]


def test_a_full_disk_is_one_line_and_leaves_no_half_file(
    fake_studies, tmp_path, capsys, monkeypatch
):
    assert main(["thesis", "--out", str(tmp_path), "--quick", "--study", "sensor_models"]) == 0
    before = (tmp_path / "report.html").read_bytes()

    def full(*arguments, **named):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Figure, "savefig", full)
    capsys.readouterr()
    assert main(["thesis", "--out", str(tmp_path), "--quick"]) == 2
    told = capsys.readouterr().err.strip()
    assert "picture.png: cannot be written: No space left on device" in told
    assert "\n" not in told
    assert list((tmp_path / "openings").iterdir()) == []
    assert Section.load(tmp_path / "sensor_models") is not None
    assert (tmp_path / "report.html").read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--study", "opening"], "study 'opening' is unknown; did you mean 'openings'?"),
        (["--sonar", "thesys"], "sonar 'thesys' is unknown; did you mean 'thesis'?"),
        (["--jobs", "0"], "--jobs must be >= 1, got 0"),
    ],
)
def test_bad_arguments_end_before_the_folder_is_made(tmp_path, capsys, arguments, message):
    assert main(["thesis", "--out", str(tmp_path / "new"), *arguments]) == 2
    assert capsys.readouterr().err == f"sonarbed: {message}\n"
    assert not (tmp_path / "new").exists()
