import json

import numpy as np
import pytest
from PIL import Image

import sonarmap as sm


def test_the_list_has_every_ring(run):
    table = run("rings")
    told = json.loads(run("rings --json"))
    assert [ring["name"] for ring in told] == list(sm.rings())
    for name in sm.rings():
        assert f" {name} " in table


def test_a_ring_is_shown_drawn_and_written(run):
    shown = run("rings hc-sr04-3 --png ring.png --out ring.toml")
    assert "hc-sr04-3: 3 sonars, cone 15°, 0.02 to 4 m" in shown
    assert "Drawn: ring.png\nWritten: ring.toml\n" in shown
    assert sm.ring("ring.toml") == sm.ring("hc-sr04-3")
    assert json.loads(run("rings ring.toml --json")) == sm.ring("hc-sr04-3").to_dict()
    with Image.open("ring.png") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(pixels, axis=0)) > 50


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("rings amigobt", "ring 'amigobt' is unknown; did you mean 'amigobot'?"),
        ("rings gone.toml", "gone.toml: no such file"),
        ("rings bad.toml", "bad.toml: sonars: unknown key; did you mean 'sonar'?"),
        ("rings math:pi", "ring 'math:pi' must be a SonarRing, got float"),
        ("rings --png a.png", "--png and --out need the name of a ring"),
        ("rings amigobot --png a.jpg", "a.jpg: the file's name must end with .png"),
        ("rings amigobot --out a.txt", "a.txt: the file's name must end with .toml"),
    ],
)
def test_bad_lines_are_refused(refused, tmp_path, line, complaint):
    (tmp_path / "bad.toml").write_text("[[sonars]]", encoding="utf-8")
    assert complaint in refused(line)


def test_a_log_is_imported_with_a_ring_file(run, tmp_path):
    run("rings udacity8 --out mine.toml")
    (tmp_path / "measurement.txt").write_text("0 " + "1000 " * 7 + "1000\n", encoding="utf-8")
    (tmp_path / "poses.txt").write_text("0 0 0 0\n", encoding="utf-8")
    run("import measurement.txt poses.txt --format udacity --ring mine.toml --out log.parquet")
    assert sm.read_log("log.parquet").ring == sm.ring("udacity8")
