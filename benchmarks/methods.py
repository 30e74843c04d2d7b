"""Processor time of every mapping method, warm: 500 scans of eight sonars at 5 cm cells."""

import math
from time import process_time

import numpy as np

import sonarmap as sm

SCANS, SIDE_M = 500, 4.0
GRID = sm.GridSpec.covering(-1.5, -1.5, SIDE_M + 1.5, SIDE_M + 1.5, 0.05)
# The iterative methods have five seconds, all others a tenth of one.
ITERATIVE, ONE_PASS_S, ITERATIVE_S = ("forward", "belief"), 0.1, 5.0


def main() -> None:
    log = room_log()
    for name in sm.methods():
        target = ITERATIVE_S if any(word in name for word in ITERATIVE) else ONE_PASS_S
        method = sm.method(name)
        method.map(log.select(slice(80)), GRID)  # compile
        seconds = min(timed(method, log) for _ in range(5))
        print(f"methods, {name}: {seconds * 1e3:.1f} ms (target {target * 1e3:g} ms)")


def timed(method: sm.MappingMethod, log: sm.SonarLog) -> float:
    begin = process_time()
    method.map(log, GRID)
    return process_time() - begin


def room_log() -> sm.SonarLog:
    """Return a drive along a circle through a square room; every tenth reading has no echo."""
    n = SCANS * 8
    rng = np.random.default_rng(1)
    angle = np.arange(n) // 8 * (4 * math.pi / SCANS)
    log = sm.SonarLog(
        ring=sm.AMIGOBOT,
        scan=np.arange(n) // 8,
        sonar=np.arange(n) % 8,
        time_s=np.arange(n) // 8 * 0.175,
        x_m=SIDE_M / 2 + 1.2 * np.cos(angle),
        y_m=SIDE_M / 2 + 1.2 * np.sin(angle),
        heading_rad=angle + 1.6,  # no axis quite along a wall
        range_m=np.full(n, 1.0),
    )
    (x, y), (cos, sin) = log.sensor_xy_m.T, (np.cos(log.axis_rad), np.sin(log.axis_rad))
    to_wall_m = np.minimum(
        np.where(cos > 0, SIDE_M - x, x) / np.abs(cos),
        np.where(sin > 0, SIDE_M - y, y) / np.abs(sin),
    )
    range_m = to_wall_m + rng.normal(0, 0.01, n)
    range_m[(rng.random(n) < 0.1) | (range_m > sm.AMIGOBOT.range_max_m)] = np.inf
    return log.replace(range_m=range_m)


if __name__ == "__main__":
    main()
