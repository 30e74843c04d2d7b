"""Parts by name: shipped, installed, and a person's own."""

import importlib.metadata
import math

import pytest

import sonarmap as sm
from sonarmap.registry import Registry, import_object

PARTS = Registry("gadget", "sonarbed.gadgets", {"root": "math:sqrt", "path": "os:path.join"})


@pytest.fixture
def installed(monkeypatch):
    """Return a function that makes entry points of the group, given as name=value."""

    def install(**values):
        points = [
            importlib.metadata.EntryPoint(name, value, PARTS.group)
            for name, value in values.items()
        ]
        monkeypatch.setattr(
            "sonarmap.registry.entry_points",
            lambda *, group: points if group == PARTS.group else [],
        )

    return install


def test_it_is_a_mapping_of_what_ships():
    assert dict(PARTS)["root"] is math.sqrt
    assert list(PARTS) == ["root", "path"] == list(PARTS.shipped)
    assert len(PARTS) == 2
    assert "root" in PARTS
    assert "rot" not in PARTS
    assert PARTS.get("rot") is None
    with pytest.raises(KeyError):
        PARTS["rot"]


def test_a_name_may_lie_deeper_in_its_module():
    import os.path

    assert PARTS["path"] is os.path.join
    assert PARTS.find("path") is os.path.join


def test_nothing_is_imported_before_it_is_asked_for():
    parts = Registry("gadget", "sonarbed.gadgets", {"broken": "no_such_module:Thing"})
    assert list(parts) == ["broken"]
    assert "broken" in parts
    with pytest.raises(sm.InputError, match="cannot be imported"):
        parts["broken"]


def test_installed_packages_add_theirs(installed):
    installed(power="math:pow", twist="math:sin")
    assert list(PARTS) == ["root", "path", "power", "twist"]
    assert PARTS.shipped == ("root", "path")
    assert len(PARTS) == 4
    assert PARTS["power"] is PARTS.find("power") is math.pow


def test_a_shipped_name_cannot_be_taken(installed):
    installed(root="math:pow")
    assert PARTS["root"] is math.sqrt
    assert len(PARTS) == 2


def test_other_groups_are_not_looked_at(installed):
    installed(power="math:pow")
    other = Registry("widget", "sonarbed.widgets", {})
    assert list(other) == []


def test_whatever_can_be_imported_is_a_part(tmp_path, monkeypatch):
    (tmp_path / "own_part.py").write_text("class Mine:\n    class Inner:\n        x = 3\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert PARTS.find("own_part:Mine").__name__ == "Mine"
    assert PARTS.find("own_part:Mine.Inner.x") == 3


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("rot", "gadget 'rot' is unknown; did you mean 'root'?"),
        ("zzz", "gadget 'zzz' is unknown; known: path, root"),
        ("", "gadget '' is unknown; known: path, root"),
        (None, "gadget must be a name, got None"),
        (math.sqrt, "gadget must be a name, got <built-in function sqrt>"),
        (":sqrt", "gadget must be a name or package.module:Name, got ':sqrt'"),
        ("math:", "gadget must be a name or package.module:Name, got 'math:'"),
        ("maths:sqrt", "gadget 'maths:sqrt' cannot be imported: No module named 'maths'"),
        ("math:sqr", "gadget 'math:sqr' cannot be imported: 'math' has no 'sqr'"),
        ("math:pi.e", "gadget 'math:pi.e' cannot be imported: 'math' has no 'pi.e'"),
    ],
)
def test_what_cannot_be_found(name, message):
    with pytest.raises(sm.InputError) as error:
        PARTS.find(name)
    assert str(error.value) == message


def test_an_installed_part_that_is_broken_is_named(installed):
    installed(power="no_such_module:pow")
    assert "power" in PARTS
    with pytest.raises(sm.InputError, match="gadget 'no_such_module:pow' cannot be imported"):
        PARTS.find("power")


def test_import_object_names_the_kind():
    assert import_object("gadget", "math:pi") == math.pi
    with pytest.raises(sm.InputError, match=r"^widget must be a name or package"):
        import_object("widget", "math")
