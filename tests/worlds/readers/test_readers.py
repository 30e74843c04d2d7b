"""Which reader a file gets, and readers from outside of the package."""

import importlib.metadata
import textwrap
from pathlib import Path

import pytest

import worlds
from sonarmap import InputError
from worlds.readers import READERS

# A whole reader, as a person would write it: circles of posts, one a line, in a square room.
POSTS = """
from worlds import Solid, World


def read_posts(path, *, size_m=4.0):
    posts = [
        Solid.pillar(f"post {i}", map(float, line.split()), 0.1, height_m=1, material="metal")
        for i, line in enumerate(path.read_text().splitlines())
    ]
    return World.of(path.stem, posts, bounds_m=(0, 0, size_m, size_m), start=(0.5, 0.5, 0))
"""


@pytest.fixture
def posts(tmp_path, monkeypatch):
    """Write the reader and a file for it, and return the file's path."""
    (tmp_path / "toy_posts.py").write_text(textwrap.dedent(POSTS), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    path = tmp_path / "yard.posts"
    path.write_text("1 2\n3 1\n", encoding="utf-8")
    return path


def is_yard(world, size_m=4.0):
    return (
        world.name == "yard"
        and [solid.circle[:2] for solid in world.solids] == [(1, 2), (3, 1)]
        and world.bounds_m == (0, 0, size_m, size_m)
    )


def test_the_suffix_of_a_file_picks_its_reader(tmp_path):
    text = (Path(worlds.__file__).parent / "rooms" / "l-shape.toml").read_text(encoding="utf-8")
    for name in ("room.toml", "room.TOML", "room"):  # a pipe has no suffix
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert worlds.load(tmp_path / name).title == worlds.load("l-shape").title


@pytest.mark.parametrize("there", [True, False])
def test_an_unknown_suffix_is_answered_with_the_known_ones(tmp_path, monkeypatch, there):
    monkeypatch.chdir(tmp_path)
    if there:
        Path("room.svg").touch()
    for path in ("room.svg", Path("room.svg")):
        with pytest.raises(InputError) as caught:
            worlds.load(path)
        assert str(caught.value) == (
            "room.svg: no world reader for files that end in '.svg'; known: .toml"
        )


def test_ones_own_reader_is_a_callable_or_named_by_its_module(posts):
    import toy_posts

    for reader in (toy_posts.read_posts, "toy_posts:read_posts"):
        assert is_yard(worlds.load(posts, reader=reader))
        assert is_yard(worlds.load(posts, reader=reader, size_m=5.0), size_m=5.0)


def test_ones_own_reader_may_stand_before_the_file(posts, monkeypatch):
    assert is_yard(worlds.load(f"toy_posts:read_posts:{posts}"))
    monkeypatch.chdir(posts.parent)
    assert is_yard(worlds.load("toy_posts:read_posts:yard.posts", size_m=6.0), size_m=6.0)


def test_a_file_whose_name_has_colons_is_a_file(tmp_path, monkeypatch):
    text = (Path(worlds.__file__).parent / "rooms" / "l-shape.toml").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    Path("a:b:c.toml").write_text(text, encoding="utf-8")
    assert worlds.load("a:b:c.toml").name == "a:b:c"


def test_an_installed_package_adds_a_suffix(posts, monkeypatch):
    point = importlib.metadata.EntryPoint(
        ".posts", "toy_posts:read_posts", "sonarbed.world_readers"
    )
    monkeypatch.setattr(
        "sonarmap.registry.entry_points",
        lambda *, group: [point] if group == point.group else [],
    )
    assert list(READERS) == [".toml", ".posts"]
    assert is_yard(worlds.load(posts))
    with pytest.raises(InputError, match=r"'\.post'; did you mean '\.posts'\?"):
        worlds.load(posts.with_suffix(".post"))


def not_a_world(path, **parameters):
    return [path, parameters]


def picky(path):
    raise InputError("post[0]: stands on its head")


def forgetful(path):
    return path.with_name("other.txt").read_text()


@pytest.mark.parametrize(
    ("reader", "message"),
    [
        (not_a_world, "yard.posts: its world reader must return a World, got list"),
        (picky, "yard.posts: post[0]: stands on its head"),
        (forgetful, "yard.posts: no such file"),
        (3, "yard.posts: world reader must be callable, got 3"),
        (".svg", "yard.posts: world reader '.svg' is unknown; known: .toml"),
        ("no_such_module:read", "yard.posts: world reader 'no_such_module:read' cannot be import"),
        ("toy_posts:red", "yard.posts: world reader 'toy_posts:red' cannot be imported: 'toy_pos"),
    ],
)
def test_a_reader_that_does_not_do(posts, monkeypatch, reader, message):
    monkeypatch.chdir(posts.parent)
    with pytest.raises(InputError) as caught:
        worlds.load("yard.posts", reader=reader)
    assert str(caught.value).startswith(message)


def test_a_reader_without_a_file():
    with pytest.raises(InputError) as caught:
        worlds.load("toy_posts:read_posts")
    assert str(caught.value) == (
        "world 'toy_posts:read_posts' names a reader but no file: give toy_posts:read_posts:FILE"
    )
