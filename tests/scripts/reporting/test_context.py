"""Whose folder a report's is, and the drives that its studies ask for."""

import json

import pytest

from sonarbed.reporting.context import StudyContext
from sonarmap import InputError


@pytest.fixture
def context(tmp_path):
    return StudyContext(tmp_path / "report", quick=True, jobs=1, report="thesis")


def test_a_folder_is_claimed_once_and_again_by_the_same_report(context):
    context.claim()
    context.claim()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"quick": False}, "holds a report with quick False, asked for True"),
        ({"sonar": "aria"}, "holds a report with sonar 'aria', asked for 'thesis'"),
        ({"report": "acoustics"}, "holds a report with report 'acoustics', asked for 'thesis'"),
        ({"sonarbed": "0.0.1"}, "holds a report with sonarbed '0.0.1'"),
        ({"format": 0}, "holds a report with format 0"),
    ],
)
def test_a_folder_of_another_report_is_refused(context, change, message):
    context.claim()
    file = context.folder / "setting.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(InputError, match=f"{message}.*choose another folder"):
        context.claim()


@pytest.mark.parametrize("text", ["", "{", "[]", "3"])
def test_a_damaged_setting_is_refused(context, text):
    context.claim()
    (context.folder / "setting.json").write_text(text)
    with pytest.raises(InputError, match=r"setting\.json: is not the setting of a report"):
        context.claim()


def test_old_folders_of_the_thesis_report_are_still_its_own(context):
    context.claim()
    file = context.folder / "setting.json"
    file.write_text(file.read_text().replace(',\n  "report": "thesis"', ""))
    assert "report" not in file.read_text()
    context.claim()


def test_specs_are_the_reports_unless_told_otherwise(context):
    assert [spec.seed for spec in context.specs("office")] == [0, 1, 2]
    spec = context.specs("office")[0]
    assert (spec.driver, spec.sonar, spec.scans) == ("route", "thesis", 200)
    (spec,) = context.specs(
        "opening-rig", driver="straight", scans=7, seeds=[3], parameters={"gap_m": 1, "depth": 2}
    )
    assert (spec.driver, spec.scans, spec.seed) == ("straight", 7, 3)
    assert spec.parameters == (("depth", 2.0), ("gap_m", 1.0))
