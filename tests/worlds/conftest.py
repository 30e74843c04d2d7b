import textwrap

import pytest

import worlds

# What every world file needs and no test of a shape is about.
HEAD = """
title = "a room for a test"
source = "made by hand"
"""


@pytest.fixture
def make_world(tmp_path):
    """Return a function that makes a world from the text of its file, title and source added."""

    def make(text, **parameters):
        path = tmp_path / "room.toml"
        path.write_text(HEAD + textwrap.dedent(text), encoding="utf-8")
        return worlds.load(path, **parameters)

    return make
