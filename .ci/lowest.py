"""Print the lowest versions that pyproject.toml allows of what it asks for, as requirements.

Arguments are extras whose dependencies count as well.
"""

import sys
import tomllib
from pathlib import Path

from packaging.requirements import Requirement


def lowest(line: str) -> str:
    """Return ``name==version`` for ``name>=version``."""
    asked = Requirement(line)
    (bound,) = [each.version for each in asked.specifier if each.operator == ">="]
    return f"{asked.name}=={bound}"


project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
extras = project["optional-dependencies"]
lines = [*project["dependencies"], *(line for extra in sys.argv[1:] for line in extras[extra])]
for line in lines:
    if not line.startswith("sonarbed["):
        print(lowest(line))
