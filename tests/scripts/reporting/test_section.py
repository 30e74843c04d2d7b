import json

import pytest
from pages import invented

from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.section import Section
from sonarmap import InputError


def test_section_saved_and_loaded_is_the_same(tmp_path):
    context = StudyContext(tmp_path)
    section = invented(context, text="ja, größer")
    assert Section.load(tmp_path / "first") == section


def test_a_section_of_the_time_when_all_sources_were_the_thesis_is_read(tmp_path):
    section = invented(StudyContext(tmp_path))
    file = tmp_path / "first" / "section.json"
    file.write_text(file.read_text().replace('"source":', '"thesis":'))
    assert "thesis" in json.loads(file.read_text())["items"][0]
    assert Section.load(tmp_path / "first") == section


def test_a_study_without_a_section_is_not_done(tmp_path):
    assert Section.load(tmp_path) is None


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"study": "x", "title": "t", "items": [{}]}', b"\xff\xfe"]
)
def test_a_damaged_section_is_refused_by_name(tmp_path, text):
    file = tmp_path / "section.json"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError, match=r"section\.json: is not a section"):
        Section.load(tmp_path)
