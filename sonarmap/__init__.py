"""Sonar mapping core: rings, logs, grids, sensor models, mapping, scores.

Names are loaded when they are first used (see ``__init__.pyi``), so that `import sonarmap` is
quick and a program that only reads logs never waits for the compiler of the mapping loop.
"""

import lazy_loader as _lazy

__getattr__, __dir__, __all__ = _lazy.attach_stub(__name__, __file__)
