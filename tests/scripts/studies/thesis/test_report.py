"""The thesis report: its questions, and how studies are run, kept, resumed and refused."""

import errno
import re
from types import SimpleNamespace

import pytest
from matplotlib.figure import Figure
from pages import Page, invented

import sonarbed.studies.thesis as studies
from sonarbed.cli import main
from sonarbed.reporting.context import StudyContext
from sonarbed.studies.thesis.questions import ANSWERED_BY, QUESTIONS, Answer, ThesisSection
from sonarbed.studies.thesis.report import write_thesis_report
from sonarmap import InputError


@pytest.fixture
def context(tmp_path):
    return StudyContext(tmp_path / "report", quick=True, jobs=1)


def section_of(context, *, study="sensor_models", answers=()):
    return invented(context, study=study, kind=ThesisSection, answers=tuple(answers))


def written(context, *sections):
    html, markdown = write_thesis_report(context, sections)
    return html.read_text(encoding="utf-8"), markdown.read_text(encoding="utf-8")


# What the report shows.


def test_page_links_lead_to_places_within_it(context):
    section = section_of(context, study="openings", answers=[Answer(6, "yes")])
    html, _ = written(context, section, section_of(context))
    targets = {link[1:] for link in Page(html).links if link.startswith("#")}
    assert targets == {"openings", "sensor_models"}
    assert all(f'id="{target}"' in html for target in targets)


def test_page_shows_every_section_beside_the_thesis(context):
    html, markdown = written(context, section_of(context), section_of(context, study="openings"))
    for words in (Page(html).words, markdown.replace("*", "")):
        assert "Study openings" in words
        assert "The thesis: the source says" in words


def test_answers_keep_the_columns_of_their_table(context):
    _, markdown = written(context, section_of(context, answers=[Answer(6, "a | b\nand more")]))
    (row,) = [line for line in markdown.splitlines() if line.startswith("| 6 |")]
    assert "a \\| b and more" in row
    assert len(re.findall(r"(?<!\\)\|", row)) == 4


def test_questions_say_which_study_is_missing(context):
    half = section_of(context, study="openings", answers=[Answer(6, "half an answer")])
    html, markdown = written(context, half)
    for text in (Page(html).words, markdown):
        assert "half an answer" in text
        assert "Not run yet: target_distance." in text
        assert "Not run yet: wall_sizes." in text
        assert "openings." not in re.findall(r"Not run yet: ([^.]*\.)", text)
    html, _ = written(context, half, section_of(context, study="target_distance"))
    assert "target_distance." not in re.findall(r"Not run yet: ([^.]*\.)", html)


def test_every_question_has_a_study_that_exists():
    assert set(ANSWERED_BY) == set(QUESTIONS)
    assert {study for names in ANSWERED_BY.values() for study in names} <= set(studies.STUDIES)


def test_no_section_is_a_report_too(context):
    html, markdown = written(context)
    assert Page(html).tags.count("tr") == 1 + len(QUESTIONS)
    assert markdown.count("Not run yet") == len(QUESTIONS)


def test_a_lost_picture_is_one_clear_line(context):
    section = section_of(context)
    (context.folder / "sensor_models" / "picture.png").unlink()
    with pytest.raises(
        InputError, match=r"picture\.png: is missing.*--study sensor_models --again"
    ):
        write_thesis_report(context, [section])


# Sections.


def test_section_saved_and_loaded_is_the_same(context):
    section = section_of(context, answers=[Answer(1, "ja, größer"), Answer(6, "no")])
    assert ThesisSection.load(context.folder / "sensor_models") == section


def test_a_question_that_is_not_asked_cannot_be_answered():
    with pytest.raises(InputError, match="question must be 1 to 6, got 7"):
        Answer(7, "42")


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "{}",
        '{"study": "x", "title": "t", "items": []}',
        '{"study": "x", "title": "t", "items": [], "answers": [{"question": 9, "text": ""}]}',
    ],
)
def test_a_damaged_section_is_refused_with_its_remedy(tmp_path, text):
    folder = tmp_path / "openings"
    folder.mkdir()
    (folder / "section.json").write_text(text)
    remedy = "make it anew with --study openings --again"
    with pytest.raises(InputError, match=rf"section\.json: is not a section.*; {remedy}"):
        ThesisSection.load(folder)


# The command.


@pytest.fixture
def fake_studies(monkeypatch):
    """Replace every study by one that counts its runs; some can be made to fail."""
    fakes = SimpleNamespace(ran=[], failing={})

    def load(name):
        def run(context):
            fakes.ran.append(name)
            if name in fakes.failing:
                raise fakes.failing[name]
            return section_of(context, study=name)

        return run

    monkeypatch.setattr(studies, "load", load)
    monkeypatch.setattr(studies, "STUDIES", ("sensor_models", "openings", "readings"))
    return fakes


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


def test_a_damaged_study_is_mended_by_the_command_that_its_error_names(
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
    error_line = capsys.readouterr().err
    assert line in error_line
    assert len(error_line.strip().splitlines()) == 1
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
    error_line = capsys.readouterr().err.strip()
    assert "picture.png: cannot be written: No space left on device" in error_line
    assert "\n" not in error_line
    assert list((tmp_path / "openings").iterdir()) == []
    assert ThesisSection.load(tmp_path / "sensor_models") is not None
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
