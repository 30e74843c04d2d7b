"""The learned mapper and its filter in rooms that were never trained on, beside what is wanted.

Two drives of 400 scans in each of the eight rooms that ship, physical sonar, poses by odometry.
"""

import math
from functools import reduce
from operator import add
from time import process_time

import numpy as np

import sonarmap as sm
import worlds
from sim import simulate
from sim.sonar.presets import PHYSICAL
from sonarmap.learned.readings import FEATURES, features_of
from sonarmap.learned.weights import SHIPPED

SEEDS, SCANS = (0, 1), 400
NEAR_M, BESIDE_RAD = 0.1, 0.03
SONAR = PHYSICAL.replace(search="images")
THESIS = sm.method("bayes-parameterized")
METHODS = {
    "thesis's model": THESIS,
    "thesis's model + HSR": sm.Pipeline([sm.filter("hsr")], THESIS),
    "arc-competition": sm.method("arc-competition"),
    "learned": sm.method("learned"),
    "learned, mended": sm.Pipeline([sm.filter("consistency", mode="mend")], sm.method("learned")),
}

# Of the learned mapper; these figures presuppose poses that are better than odometry's.
WANTED = {
    "bits a cell, mean of rooms": "0.87",
    "skill, pooled": "0.50",
    "skill, mean of rooms": "0.55",
    "skill, worst room": "0.25",
    "F1 within 10 cm": "0.90",
    "calibration error": "0.010",
}


def main() -> None:
    drives = {
        room: [
            simulate(worlds.load(room), scans=SCANS, seed=seed, sonar=SONAR, engine="segments")
            for seed in SEEDS
        ]
        for room in worlds.names()
    }
    truths = {room: worlds.truth(worlds.load(room)) for room in drives}
    refined = {room: [sm.refine_poses(log) for log in logs] for room, logs in drives.items()}
    true = {room: [log.at_true_poses() for log in logs] for room, logs in drives.items()}
    for name, method in METHODS.items():
        told(name, scored(method, drives, truths), WANTED if name == "learned" else {})
    learned = METHODS["learned"]
    told("learned, refined poses", scored(learned, refined, truths), WANTED)
    told("learned, true poses", scored(learned, true, truths), {"F1 within 10 cm": "0.94"})
    for poses, logs in (("odometry", drives), ("refined poses", refined)):
        readings(poses, [log for some in logs.values() for log in some])
    survival_alone([log for some in drives.values() for log in some])
    one_at_a_time(drives)
    heard(drives, truths)
    show("time for 500 scans in office, s", timed(), "0.2")
    show("size of the weights, MB", SHIPPED.stat().st_size / 1e6, "under 1")


def told(name, scores, wanted) -> None:
    """Print the figures of a method, with the wanted ones."""
    pooled, skills = reduce(add, scores.values()), [score.skill for score in scores.values()]
    figures = {
        "bits a cell, mean of rooms": np.mean([score.map_score for score in scores.values()]),
        "skill, pooled": pooled.skill,
        "skill, mean of rooms": np.mean(skills),
        "skill, worst room": min(skills),
        "F1 within 10 cm": pooled.f1(1),
        "calibration error": pooled.calibration_error,
    }
    for what, value in figures.items():
        show(f"{name}: {what}", float(value), wanted.get(what))
    if wanted:
        rooms = ", ".join(f"{room} {score.skill:.2f}" for room, score in scores.items())
        print(f"{name}: skill by room: {rooms}")


def scored(method, drives, truths):
    """Return the scores by room, the drives of a room added up."""
    return {
        room: reduce(
            add,
            (
                sm.score_map(
                    method.map(log, truths[room].grid),
                    truths[room],
                    observable=truths[room].observable(log),
                )
                for log in logs
            ),
        )
        for room, logs in drives.items()
    }


def readings(poses, logs) -> None:
    """Print how the filter does, pooled over all readings."""
    print(f"readings, by {poses}:")
    mend, reject = (sm.filter("consistency", mode=mode) for mode in ("mend", "reject"))
    score = reduce(add, (sm.score_readings(log, mend.apply(log)) for log in logs))
    show("wrong readings: area under ROC", score.roc_auc, "0.998")
    show("caught while 1 % of right ones are lost", score.caught_at_lost_1_percent, "0.96")
    # Of a reading without opinion, as one that is too close, there is no doubt.
    doubt = np.nan_to_num(score.doubt)
    caught = score.is_wrong & (doubt > np.quantile(doubt[~score.is_wrong], 0.99))
    mended = score.is_mended & caught
    near = mended.sum() / (caught & score.updated).sum()
    show("of these, if mended, to within 10 cm of truth", near, "0.95")
    show("of these, mended to within 10 cm, the others rejected", mended.sum() / caught.sum(), None)
    show("spoiled_share at the filter's own threshold", score.spoiled_share, "0.005")
    rejected = reduce(add, (sm.score_readings(log, reject.apply(log)) for log in logs))
    show("rejected of the wrong at its own threshold", rejected.caught_share, None)
    show("rejected of the right at its own threshold", rejected.lost_share, None)
    hsr = reduce(add, (sm.score_readings(log, sm.filter("hsr").apply(log)) for log in logs))
    show("HSR: of the wrong ones updated, mended", hsr.mended / max(hsr.wrong_updated, 1), None)
    show("HSR: spoiled_share", hsr.spoiled_share, None)


def one_at_a_time(drives) -> None:
    """Print what a reading costs as the robot drives, and what judging by the past alone loses."""
    seconds, past, whole = [], [], []
    for room in ("clutter", "corridor", "office", "thesis-exp2"):
        log = drives[room][0].select(slice(8 * 200))
        grid = sm.grid_over(log)
        state = sm.method("learned").begin(log.ring, grid)
        judge = sm.filter("consistency", mode="doubt")
        causal = judge.begin(log.ring, grid)
        doubts = []
        for row in range(len(log)):
            reading = log.select(slice(row, row + 1))
            begin = process_time()
            state.add(reading)
            state.map  # noqa: B018 - it is made, or not, when it is asked for
            seconds.append(process_time() - begin)
            if row % 8 == 0:
                doubts.append(causal.add(log.select(slice(row, row + 8))).doubt)
        past.append(sm.score_readings(log, log.replace(doubt=np.concatenate(doubts))))
        whole.append(sm.score_readings(log, judge.apply(log)))
    show("a reading and its map as the robot drives, median ms", 1e3 * np.median(seconds), "10")
    show("the same, mean ms", 1e3 * np.mean(seconds), None)
    for what, scores in (("past alone", past), ("whole log", whole)):
        score = reduce(add, scores)
        show(f"readings judged by the {what}: area under ROC", score.roc_auc, None)
        share = score.caught_at_lost_1_percent
        show(f"readings judged by the {what}: caught at 1 % lost", share, None)


def survival_alone(logs) -> None:
    """Print how well the plainest thing does: does the map let a ray come near to the reading?"""
    logs = [log.select(log.usable & (log.range_m >= 0)) for log in logs]
    learned = METHODS["learned"]
    features = [features_of(log, learned.map(log, sm.grid_over(log)))[0] for log in logs]
    for name in ("axis_survival_-0.15", "mean_survival_-0.15"):
        column = FEATURES.index(name)
        doubted = (
            log.replace(doubt=1 - of[:, column]) for log, of in zip(logs, features, strict=True)
        )
        score = reduce(add, map(sm.score_readings, logs, doubted))
        show(f"{name} alone: area under ROC", score.roc_auc, None)
        share = score.caught_at_lost_1_percent
        show(f"{name} alone: caught while 1 % of right ones are lost", share, None)


def heard(drives, truths) -> None:
    """Print which share of the wall cells in view lies on the arc of a right echo."""
    shares = {}
    for room, logs in drives.items():
        counts = [_heard(truths[room], log.at_true_poses()) for log in logs]
        shares[room] = np.sum(counts, axis=0)
    pooled = np.sum(list(shares.values()), axis=0)
    show("wall cells within 10 cm of the arc of a right echo", pooled[0] / pooled[1], None)
    print(
        "the same by room: " + ", ".join(f"{room} {a / b:.2f}" for room, (a, b) in shares.items())
    )


def _heard(truth, log) -> tuple[int, int]:
    wall = (truth.state == worlds.OCCUPIED) & truth.observable(log)
    cell_x_m, cell_y_m = truth.grid.centre_of(*np.nonzero(wall))
    right = (log.truth.cause <= sm.Cause.OFF_AXIS) & np.isfinite(log.range_m) & log.usable
    met = np.zeros(cell_x_m.size, bool)
    for k in np.flatnonzero(right):
        x_m, y_m = cell_x_m - log.sensor_xy_m[k, 0], cell_y_m - log.sensor_xy_m[k, 1]
        off_rad = np.angle(np.exp(1j * (np.arctan2(y_m, x_m) - log.axis_rad[k])))
        near = np.abs(np.hypot(x_m, y_m) - log.range_m[k]) <= NEAR_M
        # The centre of a cell may lie a little beside the cone that touches it.
        met |= near & (np.abs(off_rad) <= log.ring.half_angle_rad + BESIDE_RAD)
    return int(met.sum()), met.size


def timed() -> float:
    """Return processor time of a map, channels included, warm, seconds."""
    log = simulate(worlds.load("office"), scans=500, seed=9, sonar=SONAR, engine="segments")
    grid, method = worlds.truth(worlds.load("office")).grid, sm.method("learned")
    method.map(log, grid)
    seconds = math.inf
    for _ in range(5):
        begin = process_time()
        method.map(log, grid)
        seconds = min(seconds, process_time() - begin)
    return seconds


def show(what: str, value: float, wanted: str | None) -> None:
    print(f"{what}: {value:.4g}" + (f" (wanted {wanted})" if wanted else ""))


if __name__ == "__main__":
    main()
