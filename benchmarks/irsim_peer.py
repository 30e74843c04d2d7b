"""The peer that the environments are compared with: ir-sim with 248 lidar beams in `office`.

Not a benchmark by itself; `environments.py` uses it where ir-sim is installed.
"""

import tempfile
from pathlib import Path
from time import perf_counter

import irsim
import numpy as np
import yaml

import worlds

BEAMS, RANGE_M = 248, 5.0


def steps_a_second(steps: int) -> float:
    """Return the best of a few runs of so many steps."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "office.yaml"
        file.write_text(yaml.safe_dump(described(worlds.load("office"))))
        env = irsim.make(str(file), display=False, disable_all_plot=True, log_level="ERROR")
        speed = np.array([[0.1], [0.3]])  # in a circle that meets nothing
        times = []
        for _ in range(3):
            begin = perf_counter()
            for _ in range(steps):
                env.step(speed)
            times.append(perf_counter() - begin)
        env.end(0)
    return steps / min(times)


def described(world: worlds.World) -> dict:
    """Return a room with one robot as ir-sim describes it: outlines, and a lidar for the ring."""
    left, bottom, right, top = world.bounds_m
    lidar = {
        "type": "lidar2d",
        "range_min": 0.1,
        "range_max": RANGE_M,
        "angle_range": 2 * np.pi,
        "number": BEAMS,
    }
    robot = {
        "kinematics": {"name": "diff"},
        "shape": {"name": "circle", "radius": 0.18},
        "state": [2.5, 3.0, 0.0],
        "sensors": [lidar],
    }
    rings = [
        ring
        for solid in world.solids
        for ring in (solid.outline.exterior, *solid.outline.interiors)
    ]
    lines = [
        {"shape": {"name": "linestring", "vertices": [list(xy) for xy in ring.coords]}}
        for ring in rings
    ]
    size = {"width": right - left, "height": top - bottom, "offset": [left, bottom]}
    return {"world": {**size, "step_time": 0.1}, "robot": [robot], "obstacle": lines}
