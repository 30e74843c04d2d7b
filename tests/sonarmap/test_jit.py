"""Compiled code is kept where it can be, and compiled anew where it cannot."""

import importlib.util

import pytest
from numba.core.caching import FunctionCache

from sonarmap.kernels.jit import njit

SOURCE = "from sonarmap.kernels.jit import njit\n@njit()\ndef double(x):\n    return 2 * x\n"


def load(path):
    spec = importlib.util.spec_from_file_location("compiled_example", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "compiled_example.py"
    path.write_text(SOURCE)
    return path


def test_what_is_compiled_is_kept(source):
    assert load(source).double(2) == 4
    double = load(source).double
    assert double(3) == 6
    assert sum(double.stats.cache_hits.values()) == 1


def test_without_a_place_to_keep_it_it_works_all_the_same(source, monkeypatch):
    monkeypatch.setattr(FunctionCache._impl_class, "_locator_classes", [])
    assert load(source).double(2) == 4
    assert not list(source.parent.rglob("*.nbc"))


def test_another_trouble_is_not_hidden(monkeypatch):
    def broken(*arguments, **options):
        raise RuntimeError("another trouble")

    monkeypatch.setattr("numba.njit", broken)
    with pytest.raises(RuntimeError, match="another trouble"):
        njit()(abs)
