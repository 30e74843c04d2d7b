import sys
from types import ModuleType

import pytest


@pytest.fixture
def mine(monkeypatch):
    """An importable module `mine`, for a person's own parts."""
    module = ModuleType("mine")
    monkeypatch.setitem(sys.modules, "mine", module)
    return module
