"""How cost grows with faces, bounces, robots and workers: tables in Markdown, and a picture.

    python benchmarks/growth.py [PNG]

Costs in microseconds are processor time, which other work on the machine does not lengthen, the
least of several runs; rates are by the clock, the best of five. Where ir-sim is installed, its
steps with 248 lidar beams stand beside ours, measured in the same process.
"""

import math
import sys
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from time import process_time

import numpy as np
from cones import EXACT, vector
from images import PHYSICAL, kernel_us
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from rays import hall
from rows import drives_of

import worlds
from sim.sonar.cone.sonar import FAN_RAYS
from sonarbed.reporting.drawing import COLOURS, figure_with, save

WALLS = (3, 8, 25, 80, 250, 800, 2500)  # of four faces each
BOUNCES = (0, 1, 2, 3)
ROBOTS = (1, 4, 16, 64, 256, 1024, 4096)
WORKERS = (1, 2)
SONARS = 8
# The physical sonar is slower: a few of its readings among many faces are enough to time.
READINGS = {"exact cones": 400, f"fans of {FAN_RAYS} rays": 400, "physical by images": 40}
COLOUR_OF = {
    "exact cones": COLOURS[0],
    f"fans of {FAN_RAYS} rays": COLOURS[1],
    "physical by images": COLOURS[2],
    "physical": COLOURS[2],
    "physical by rays": COLOURS[3],
}
PLAIN = FuncFormatter(lambda value, _: f"{value:,.10g}")
Rows = dict[str, list[float]]


def main() -> None:
    faces = by_faces()
    table("faces", [f"{4 * walls:,}" for walls in WALLS], faces, "{:,.1f} us")
    bounces = by_bounces()
    table("bounces", BOUNCES, bounces, "{:,.1f} us")
    robots, peer = by_robots(), irsim()
    told = {f"{name}, steps/s": rates for name, rates in robots.items()}
    told["exact cones, readings/s"] = [SONARS * rate for rate in robots["exact cones"]]
    fan = f"fans of {FAN_RAYS} rays"
    told[f"{fan}, rays/s"] = [SONARS * FAN_RAYS * rate for rate in robots[fan]]
    table("robots", ROBOTS, told, "{:,.0f}")
    if peer is not None:
        steps, beams = peer
        print(
            f"\nir-sim, one robot, {beams} lidar beams: {steps:,.0f} steps/s, "
            f"{steps * beams:,.0f} rays/s"
        )
    workers = by_workers()
    table("workers", WORKERS, workers, "{:,.0f} readings/s")
    if len(sys.argv) > 1:
        draw(Path(sys.argv[1]), faces, bounces, robots, peer, workers)


def by_faces() -> Rows:
    """Return what a reading costs in halls with more and more walls, microseconds by sonar."""
    rng = np.random.default_rng(0)
    places, axes = rng.uniform(2, 18, (400, 2)), rng.uniform(-math.pi, math.pi, 400)
    sonars = (EXACT, EXACT.replace(rays=FAN_RAYS), PHYSICAL.replace(search="images"))
    costs: Rows = {name: [] for name in READINGS}
    for walls in WALLS:
        room = hall(walls)
        for (name, count), sonar in zip(READINGS.items(), sonars, strict=True):
            best = math.inf
            for _ in range(5):
                begin = process_time()
                sonar.listen(
                    room.faces, room, places[:count], axes[:count], np.random.default_rng(0)
                )
                best = min(best, process_time() - begin)
            costs[name].append(best / count * 1e6)
    return costs


def by_bounces() -> Rows:
    """Return what a reading of the physical sonar in turn costs in `office`, microseconds."""
    office = worlds.load("office")
    return {
        f"physical by {search}": [
            kernel_us(office, PHYSICAL.replace(search=search, max_bounces=bounces))
            for bounces in BOUNCES
        ]
        for search in ("images", "rays")
    }


def by_robots() -> Rows:
    """Return steps a second of vectors of robots on Navigate, by what their sonars are."""
    kinds = {"exact cones": None, f"fans of {FAN_RAYS} rays": FAN_RAYS}
    return {
        name: [vector(robots, rays).a_second for robots in ROBOTS] for name, rays in kinds.items()
    }


def by_workers() -> Rows:
    """Return readings a second of many drives in `office`, by sonar."""
    with ExitStack() as stack:
        rates: Rows = {}
        for name, sonar, driver, scans in (
            ("exact cones", "thesis", "wander", 1000),
            ("physical", "physical", "route", 150),
        ):
            drives = [("office", driver, sonar, seed, scans) for seed in range(8)]
            measures = [drives_of(stack, drives, workers) for workers in WORKERS]
            # By turns, so that what else the machine does meets both alike.
            runs = [[measure() for measure in measures] for _ in range(5)]
            rates[name] = np.max(runs, axis=0).tolist()
    return rates


def irsim() -> tuple[float, int] | None:
    """Return the peer's steps a second and its beams, None where it is not installed."""
    try:
        from irsim_peer import BEAMS, steps_a_second
    except ImportError:
        print("\nir-sim is not installed: pip install ir-sim compares with it")
        return None
    return steps_a_second(500), BEAMS


def table(
    title: str, heads: Sequence[object], rows: Mapping[str, Sequence[float]], form: str
) -> None:
    """Print rows of numbers as Markdown, a column a name."""
    print(f"\n| {title} | " + " | ".join(rows) + " |\n" + "|---" * (len(rows) + 1) + "|")
    for head, *values in zip(heads, *rows.values(), strict=True):
        print(f"| {head} | " + " | ".join(form.format(value) for value in values) + " |")
    sys.stdout.flush()


def draw(
    path: Path,
    faces: Rows,
    bounces: Rows,
    robots: Rows,
    peer: tuple[float, int] | None,
    workers: Rows,
) -> None:
    """Draw the four tables, the costs above, the rates below."""
    figure, (one, two, three, four) = figure_with(2, 2, width=6.0)
    lines(one, [4 * walls for walls in WALLS], faces)
    one.set(xscale="log", xlabel="faces", ylabel="processor time of a reading, µs")
    one.set_title("Walls strewn over a hall of 20 × 20 m", fontsize=11)
    one.xaxis.set_major_formatter(PLAIN)
    lines(two, BOUNCES, bounces)
    two.set(xticks=BOUNCES, xlabel="mirrors over which a sound is followed")
    two.set_ylabel("processor time of a reading, µs")
    two.set_title("The physical sonar in the office, in turn", fontsize=11)
    lines(three, ROBOTS, robots)
    if peer is not None:
        three.plot([1], [peer[0]], "s", color=COLOURS[6], label=f"ir-sim, {peer[1]} lidar beams")
        three.legend(loc="lower right", fontsize=9, frameon=False)
    three.set(xscale="log", xlabel="robots in a vector", ylabel="control steps a second")
    three.set_xticks(ROBOTS, [f"{n:,}" for n in ROBOTS])
    three.xaxis.set_minor_locator(NullLocator())
    right = three.secondary_yaxis(
        "right", functions=(lambda steps: SONARS * steps, lambda readings: readings / SONARS)
    )
    right.set_ylabel(f"readings a second (of a fan: {FAN_RAYS} rays each)")
    few_ticks(right)
    three.set_title("Navigate in the office, eight sonars a robot", fontsize=11)
    lines(four, WORKERS, workers)
    four.set(xlim=(0.8, 2.2), xticks=WORKERS, xlabel="workers", ylabel="readings a second")
    low, high = four.get_ylim()
    four.set_ylim(low / 1.5, high * 1.5)
    for rates in workers.values():
        for x, rate in zip(WORKERS, rates, strict=True):
            four.annotate(
                f"{rate:,.0f}", (x, rate), xytext=(0, 6), textcoords="offset points",
                ha="center", fontsize=9,
            )  # fmt: skip
    four.set_title("Many drives in the office", fontsize=11)
    save(figure, path)


def lines(axes: Axes, x: Sequence[float], rows: Rows) -> None:
    """Draw a line a row on a logarithmic scale, and say which is which."""
    for name, values in rows.items():
        axes.plot(x, values, "o-", color=COLOUR_OF[name], ms=4, label=name)
    axes.set_yscale("log")
    few_ticks(axes)
    axes.grid(alpha=0.3, which="major")
    axes.legend(loc="best", fontsize=9, frameon=False)


def few_ticks(axes: Axes) -> None:
    """Put plain numbers at 1, 2 and 5 of each power of ten: a scale may span only one."""
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.yaxis.set_major_formatter(PLAIN)
    axes.yaxis.set_minor_formatter(NullFormatter())


if __name__ == "__main__":
    main()
