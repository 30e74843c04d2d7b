"""The README's snippets run unchanged: its Python in one session, its commands in one folder."""

import re
import shlex
from pathlib import Path

import pytest

from sonarbed.cli import main

TEXT = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
# Lines of shell that fetch and install: not ours to run here.
SETUP = re.compile(r"(git|make|pip) ")

pytestmark = pytest.mark.engine


def blocks(language, text=TEXT):
    """Return the fenced blocks of a language, in their order."""
    fenced = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block for found, block in fenced if found == language]


def command_lines(text=TEXT):
    """Return the lines of all shell blocks, continued ones joined."""
    joined = "".join(blocks("", text)).replace("\\\n", " ")
    return [line for line in joined.splitlines() if line.strip()]


def test_the_python_snippets_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks("python"):
        exec(compile(block, "README.md", "exec"), names)
    names["env"].close()
    assert Path("map/map.yaml").is_file()
    assert len(capsys.readouterr().out.splitlines()) == TEXT.count("\nprint(")


def test_the_command_lines_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    commands = [line for line in command_lines() if not SETUP.match(line)]
    assert len(commands) >= 4
    for line in commands:
        program, *arguments = shlex.split(line)
        assert program == "sonarbed", line
        assert main(arguments) == 0, line
    assert len(list(Path("logs").glob("*.parquet"))) == 4


def test_continued_lines_are_one_command():
    text = (
        "```\nsonarbed map a \\\n  --out b\n\nmake demo\n```\nand `sonarbed`\n```python\nx\n```\n"
    )
    assert [line.split() for line in command_lines(text)] == [
        ["sonarbed", "map", "a", "--out", "b"],
        ["make", "demo"],
    ]
