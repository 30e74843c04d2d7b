"""What refined poses gain: errors of place and heading by truth, and the skill of maps.

Two drives of 400 scans in each shipped room and one in each of 80 generated ones, physical sonar.
"""

from functools import reduce
from operator import add
from time import process_time

import numpy as np

import sonarmap as sm
import worlds
from sim import simulate

SCANS, GENERATED, FIRST_SEED = 400, 80, 500_000
WORSE_M, WORSE_DEG = 0.01, 0.2


def main() -> None:
    shipped = [(worlds.load(room), seed) for room in worlds.names() for seed in (0, 1)]
    styles = list(worlds.styles())
    generated = [
        (worlds.generate(styles[k % len(styles)], FIRST_SEED + k), k) for k in range(GENERATED)
    ]
    for title, rooms in (("shipped", shipped), ("generated", generated)):
        drives = [
            (world, simulate(world, scans=SCANS, seed=seed, sonar="physical", engine="segments"))
            for world, seed in rooms
        ]
        begin = process_time()
        refined = [sm.refine_poses(log) for _, log in drives]
        seconds = (process_time() - begin) / len(drives)
        told(title, [log for _, log in drives], refined, seconds)
        skills(title, drives, refined)


def errors(log):
    """Return root mean square errors of place, metres, and heading, degrees."""
    error = sm.pose_error(log, log.at_true_poses())
    return error.place_m, np.rad2deg(error.heading_rad)


def told(title, logs, refined, seconds) -> None:
    before, after = (np.array([errors(log) for log in some]) for some in (logs, refined))
    share = np.median(after / before, axis=0)
    old, new = np.median(before, axis=0), np.median(after, axis=0)
    print(f"{title}: {len(logs)} drives, {seconds:.2f} s of processor time a drive")
    print(f"  place, median: {100 * old[0]:.1f} to {100 * new[0]:.1f} cm")
    print(f"  heading, median: {old[1]:.2f} to {new[1]:.2f} degrees")
    print(f"  median share of the error that is left: place {share[0]:.2f}, heading {share[1]:.2f}")
    print("  wanted: 0.50, 0.50")
    worse = after - before
    print(
        f"  drives worse by over 1 cm: {(worse[:, 0] > WORSE_M).sum()}, by over 0.2 degrees: "
        f"{(worse[:, 1] > WORSE_DEG).sum()} (at most {100 * worse[:, 0].max():.1f} cm, "
        f"{worse[:, 1].max():.2f} degrees); wanted: none"
    )


def skills(title, drives, refined) -> None:
    """Print the skill of the learned maps by odometry, by refined and by true poses."""
    method = sm.method("learned")
    poses = {
        "by odometry": [log for _, log in drives],
        "refined": refined,
        "true": [log.at_true_poses() for _, log in drives],
    }
    for name, logs in poses.items():
        scores = []
        for (world, driven), log in zip(drives, logs, strict=True):
            truth = worlds.truth(world)
            built = method.map(log, truth.grid)
            scores.append(sm.score_map(built, truth, observable=truth.observable(driven)))
        mean = np.nanmean([score.skill for score in scores])
        pooled = reduce(add, scores)
        print(
            f"  learned maps, poses {name}: skill {mean:.3f} (mean), {pooled.skill:.3f} (pooled), "
            f"F1 within 10 cm {pooled.f1(1):.3f}"
        )


if __name__ == "__main__":
    main()
