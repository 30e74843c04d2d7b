"""Readings mapped per second on one thread, the parameterized model evaluated in every cell."""

import math
from time import perf_counter

import numpy as np

import sonarmap as sm

MODEL = sm.ParameterizedModel(p1=0.02, p2=0.15, p3_m=0.1, p4=0.98, p5_rad=math.radians(15))
TARGETS = {0.05: 400_000, 0.01: 30_000}


def main() -> None:
    rng = np.random.default_rng(1)
    for resolution_m, target in TARGETS.items():
        n = target // 8 * 8
        log = random_log(rng, n)
        grid = sm.GridSpec.covering(-3, -3, 9, 9, resolution_m)
        sm.build_map(log.select(slice(80)), MODEL, grid)  # compile
        seconds = min(timed(log, grid) for _ in range(3))
        print(
            f"mapping, {resolution_m * 100:g} cm cells, ranges {log.range_m.mean():.2f} m: "
            f"{n / seconds:,.0f} readings/s (target {target:,})"
        )


def timed(log: sm.SonarLog, grid: sm.GridSpec) -> float:
    begin = perf_counter()
    sm.build_map(log, MODEL, grid)
    return perf_counter() - begin


def random_log(rng: np.random.Generator, n: int) -> sm.SonarLog:
    return sm.SonarLog(
        ring=sm.AMIGOBOT,
        scan=np.arange(n) // 8,
        sonar=np.arange(n) % 8,
        time_s=np.arange(n) // 8 * 0.175,
        x_m=rng.uniform(2, 4, n),
        y_m=rng.uniform(2, 4, n),
        heading_rad=rng.uniform(-math.pi, math.pi, n),
        range_m=rng.normal(1.3, 0.3, n).clip(0.2, 2.9),
    )


if __name__ == "__main__":
    main()
