"""Readings searched by HSR per second and pass on one thread, at 1 cm cells."""

import math
from time import perf_counter

import numpy as np

import sonarmap as sm
from sonarmap.filters.hsr import estimate_variant_walls

PARAMS = sm.HsrParams(0.02, 0.15, threshold_m=3.0, target_distance_m=0.06)
SIDE_M = 3.2


def main() -> None:
    rng = np.random.default_rng(1)
    sm.hsr(room_log(rng, 800), PARAMS)  # compile
    for n in (4_000, 200_000, 400_000):
        log = room_log(rng, n)
        seconds, result = min((timed(log) for _ in range(3)), key=lambda timing: timing[0])
        passes = len(result.updates_per_pass) + (result.rejected_updates is not None)
        es = estimate_variant_walls(log, PARAMS)
        print(
            f"hsr, {n:,} readings, ranges {np.median(log.range_m):.2f} m, {passes} passes, "
            f"{result.updated.mean():.1%} updated: {n * passes / seconds:,.0f} readings/s and "
            f"pass (target 500,000), grid {es.marks.nbytes / 1e6:.2f} MB"
        )


def timed(log: sm.SonarLog) -> tuple[float, sm.HsrResult]:
    begin = perf_counter()
    result = sm.hsr(log, PARAMS)
    return perf_counter() - begin, result


def room_log(rng: np.random.Generator, n: int) -> sm.SonarLog:
    """Return a drive in a square room whose walls mirror every fifth reading away."""
    x_m, y_m = rng.uniform(0.5, SIDE_M - 0.5, (2, n))
    log = sm.SonarLog(
        ring=sm.AMIGOBOT,
        scan=np.arange(n) // 8,
        sonar=np.arange(n) % 8,
        time_s=np.arange(n) // 8 * 0.175,
        x_m=x_m,
        y_m=y_m,
        heading_rad=rng.uniform(-math.pi, math.pi, n),
        range_m=np.full(n, 1.0),
    )
    (x, y), (cos, sin) = log.sensor_xy_m.T, (np.cos(log.axis_rad), np.sin(log.axis_rad))
    to_wall_m = np.minimum(
        np.where(cos > 0, SIDE_M - x, x) / np.abs(cos),
        np.where(sin > 0, SIDE_M - y, y) / np.abs(sin),
    )
    range_m = (to_wall_m + rng.normal(0, 0.005, n)).round(3)
    lost = rng.random(n) < 0.2
    range_m[lost] += rng.uniform(0.2, 3, int(lost.sum()))
    range_m[range_m > sm.AMIGOBOT.range_max_m] = np.inf
    return log.replace(range_m=range_m)


if __name__ == "__main__":
    main()
