"""Known rooms as data, what their surfaces do to sound, and the truth about their cells.

>>> import worlds
>>> world = worlds.load("opening-rig", gap_m=0.6)
>>> truth = worlds.truth(world, resolution_m=0.05)
>>> hits = world.faces.cast([[0.0, -1.0]], [[1.0, 0.0]], 5.0)
"""

# The names stand in __init__.pyi and are loaded when they are first used: listing the rooms
# needs neither shapely nor pydantic, and only casting rays needs numba.
import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
