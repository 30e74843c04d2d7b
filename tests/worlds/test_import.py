import subprocess
import sys

# Run in a process of its own: this one has everything loaded already.
LIGHT = """
import sys, worlds
worlds.names()
heavy = {"numba", "shapely", "pydantic", "scipy", "pyarrow"} & set(sys.modules)
assert not heavy, heavy
world = worlds.load("opening-rig")
assert "numba" not in sys.modules
worlds.truth(world)
assert "numba" not in sys.modules  # only casting rays needs it
assert callable(worlds.truth) and callable(worlds.load)
"""


def test_only_what_is_used_is_loaded():
    subprocess.run([sys.executable, "-c", LIGHT], check=True)
