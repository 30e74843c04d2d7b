"""The thesis's search: 1440 parameter sets of one log, three measures and the true score each."""

import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from time import perf_counter

import numpy as np

import sonarmap as sm
from sonarmap import goodness

SCANS, SIDE_M, CORES, TARGET_S = 500, 3.0, 2, 60.0
GRID = sm.GridSpec.covering(-0.5, -0.5, SIDE_M + 0.5, SIDE_M + 0.5, 0.05)


@dataclass
class Truth:
    grid: sm.GridSpec
    state: np.ndarray


def main() -> None:
    sets = goodness.thesis_parameter_sets()
    search(sets[:1])  # compile
    begin = perf_counter()
    with ProcessPoolExecutor(CORES) as pool:
        rows = [*pool.map(search, [sets[i::CORES] for i in range(CORES)])]
    seconds = perf_counter() - begin
    print(
        f"goodness, {sum(map(len, rows))} sets of {SCANS} scans, 5 cm cells, {CORES} cores: "
        f"{seconds:.1f} s, {seconds * CORES / len(sets) * 1e3:.1f} ms a set and core "
        f"(target {TARGET_S:g} s)"
    )


def search(models: tuple[sm.ParameterizedModel, ...]) -> list[tuple[float, ...]]:
    runs = [
        goodness.map_and_spread(room_log(seed), models, GRID, max_range_m=1.0) for seed in (1, 2)
    ]
    truth, rows = room_truth(), []
    for (m, spread), (other, _) in zip(*runs, strict=True):
        rows.append(
            (
                spread.vsdns,
                goodness.map_derivative(m, updated=spread.updated),
                goodness.compare_runs(m, other).agreement,
                sm.score_map(m, truth).map_score,
            )
        )
    return rows


def room_log(seed: int) -> sm.SonarLog:
    """Return a drive along a circle through a square room, so that most ranges are below 1 m."""
    n = SCANS * 8
    angle = np.arange(n) // 8 * (4 * math.pi / SCANS)
    log = sm.SonarLog(
        ring=sm.AMIGOBOT,
        scan=np.arange(n) // 8,
        sonar=np.arange(n) % 8,
        time_s=np.arange(n) // 8 * 0.175,
        x_m=SIDE_M / 2 + 0.9 * np.cos(angle),
        y_m=SIDE_M / 2 + 0.9 * np.sin(angle),
        heading_rad=angle + 1.6,  # no axis quite along a wall
        range_m=np.full(n, 1.0),
    )
    (x, y), (cos, sin) = log.sensor_xy_m.T, (np.cos(log.axis_rad), np.sin(log.axis_rad))
    to_wall_m = np.minimum(
        np.where(cos > 0, SIDE_M - x, x) / np.abs(cos),
        np.where(sin > 0, SIDE_M - y, y) / np.abs(sin),
    )
    # Every reading counts: what is farther than 1 m is taken as something at 1 m.
    noise_m = np.random.default_rng(seed).normal(0, 0.01, n)
    return log.replace(range_m=(to_wall_m.clip(0, 0.97) + noise_m).clip(0, 1))


def room_truth() -> Truth:
    """Return the room's walls on the grid, and what is behind them as hidden."""
    x_m, y_m = GRID.centre_of(*np.indices(GRID.shape))
    outside = np.maximum(np.abs(x_m - SIDE_M / 2), np.abs(y_m - SIDE_M / 2)) - SIDE_M / 2
    return Truth(GRID, np.digitize(outside, [0, 0.05]).astype(np.uint8))


if __name__ == "__main__":
    main()
