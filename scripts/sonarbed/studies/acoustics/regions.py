"""Regions of constant depth: what a sonar reads that turns on the spot, beside theory."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from shapely import Polygon
from shapely.affinity import rotate

from sim import PhysicalSonar
from sim.sonar.protocol import Echoes
from sonarbed.reporting.bench import board, echoes, post, scene
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item, Section
from sonarbed.reporting.setting import Setting
from sonarbed.studies.acoustics.theory import (
    GLASS,
    LOSS_DB,
    Locus,
    as_deviation,
    as_range,
    main_half_width_rad,
    physical,
    pillar_db,
    range_m,
    sharp,
)
from worlds import Solid, World

__all__ = ["Deviation", "Target", "compared", "run", "sweep", "targets"]

_FAR_M = 30.0  # faces so long that their ends are out of hearing


@dataclass(frozen=True)
class Target:
    """A thing alone on the bench.

    Parameters
    ----------
    name : str
        For people.
    world : World
        It, before a sonar in (-distance, 0).
    distance_m : float
        Where the sonar stands.
    loci : tuple of Locus
        What theory hears of it; the first is the thing's own.
    """

    name: str
    world: World
    distance_m: float
    loci: tuple[Locus, ...]


@dataclass(frozen=True)
class Deviation:
    """How a sweep differs from theory.

    Parameters
    ----------
    largest_m : float
        The largest difference of ranges where both hear something, metres.
    agreeing : float
        Share of the bearings at which both hear something or both nothing.
    """

    largest_m: float
    agreeing: float


def run(setting: Setting) -> Section:
    """Turn a sonar before single things and in a room."""
    return Section("regions", "Regions of constant depth", (_single(setting), _room(setting)))


def targets(sonar: PhysicalSonar) -> tuple[Target, ...]:
    """Return a plane, a concave corner, a convex edge and three pillars, all of glass."""
    things = [
        Target(
            "plane, 2 m",
            scene(board("pane", 2 * _FAR_M, material=GLASS)),
            2.0,
            (Locus("plane", 2.0, 0.0, LOSS_DB),),
        )
    ]
    # The faces of the corner pass the sonar at 45 degrees, nearer than their vertex.
    beside = [Locus("face", 2.0 * math.sin(math.pi / 4), s * math.pi / 4, LOSS_DB) for s in (1, -1)]
    things.append(
        Target(
            "concave corner, 2 m",
            scene(_turned("a", 0.0, -0.1, 135), _turned("b", 0.0, 0.1, -135)),
            2.0,
            (Locus("corner", 2.0, 0.0, 2 * LOSS_DB), *beside),
        )
    )
    edge_m = 1.0
    block = rotate(shapely.box(0, 0, _FAR_M, _FAR_M), -45, origin=(0, 0))
    things.append(
        Target(
            "convex edge, 1 m",
            scene(Solid("block", GLASS, 1.0, block)),
            edge_m,
            (Locus("edge", edge_m, 0.0, sonar.edge_db - 20 * math.log10(edge_m) + LOSS_DB),),
        )
    )
    for radius_m in (0.02, 0.05, 0.10):
        things.append(
            Target(
                f"pillar of {100 * radius_m:.0f} cm radius, 1 m",
                scene(post("post", radius_m, material=GLASS)),
                1.0,
                (Locus("pillar", 1.0, 0.0, pillar_db(radius_m, 1.0) + LOSS_DB),),
            )
        )
    return tuple(things)


def sweep(
    sonar: PhysicalSonar, world: World, at_m: tuple[float, float], axis_rad: NDArray[np.float64]
) -> Echoes:
    """Return what a transducer hears that turns in one place."""
    places = np.broadcast_to(at_m, (axis_rad.size, 2))
    return echoes(sonar, world, places, axis_rad, np.random.default_rng(0))


def compared(read_m: NDArray[np.float64], theory_m: NDArray[np.float64]) -> Deviation:
    """Return how the ranges of a sweep differ from those of theory."""
    read, told = np.isfinite(read_m), np.isfinite(theory_m)
    both = read & told
    largest_m = np.abs(read_m[both] - theory_m[both]).max() if both.any() else math.nan
    return Deviation(float(largest_m), float((read == told).mean()))


def _turned(name: str, from_y: float, to_y: float, angle_deg: float) -> Solid:
    """Return a long wall that begins in the origin and goes off at an angle."""
    wall = shapely.box(0.0, min(from_y, to_y), _FAR_M, max(from_y, to_y))
    return Solid(name, GLASS, 1.0, rotate(wall, angle_deg, origin=(0, 0)))


def _axes_rad(step_deg: float) -> NDArray[np.float64]:
    return np.radians(np.arange(-180.0, 180.0, step_deg))


def _main_width_deg(axis_rad: NDArray[np.float64], read: NDArray[np.bool_]) -> float:
    """Return how wide the run of bearings about the axis is that read the thing."""
    middle = int(np.argmin(np.abs(axis_rad)))
    if not read[middle]:
        return 0.0
    lost = np.flatnonzero(~read)
    first, last = lost[lost < middle].max() + 1, lost[lost > middle].min() - 1
    return math.degrees(axis_rad[last] - axis_rad[first])


def _single(setting: Setting) -> Item:
    sonar = physical(setting.sonar)
    exact = sharp(sonar)
    step_deg = 1.0 if setting.quick else 0.25
    axis = _axes_rad(step_deg)
    figure, panels = figure_with(2, 3, width=4.0, height=3.0, sharex=True)
    rows, samples, deviations, late_m, widths = [], [], [], [], []
    for axes, target in zip(panels, targets(sonar), strict=True):
        place = (-target.distance_m, 0.0)
        theory_m = range_m(sonar, target.loci, axis)
        deviation = compared(sweep(exact, target.world, place, axis).range_m, theory_m)
        read_m = sweep(sonar, target.world, place, axis).range_m
        own_m = target.loci[0].range_m
        width_deg = _main_width_deg(axis, np.abs(read_m - own_m) < 0.1)
        told_deg = 2 * math.degrees(main_half_width_rad(sonar, target.loci[0]))
        deviations.append(deviation)
        late_m.append(compared(read_m, theory_m).largest_m)
        widths.append((target.name, width_deg, told_deg))
        rows.append(
            (
                target.name,
                f"{own_m:.3f}",
                f"{width_deg:.1f}",
                f"{told_deg:.1f}",
                as_deviation(deviation.largest_m),
                f"{1000 * late_m[-1]:.1f}",
                f"{deviation.agreeing:.2%}",
            )
        )
        samples += [
            (target.name, f"{math.degrees(a):.2f}", as_range(r), as_range(t))
            for a, r, t in zip(axis, read_m, theory_m, strict=True)
            if np.isfinite(r) or np.isfinite(t)
        ]
        _draw(axes, target, axis, read_m, theory_m)
    for axes in panels[3:]:
        axes.set_xlabel("bearing of the axis, degrees")
    for axes in panels[::3]:
        axes.set_ylabel("range, m")
    _legend(figure, panels[0])
    worst_m = max(deviation.largest_m for deviation in deviations)
    wide = ", ".join(f"{name} {ours:.1f} ({told:.1f})" for name, ours, told in widths)
    return Item(
        "Single things, each alone in a sweep of 360 degrees",
        "A plane is read at its perpendicular distance, a corner and an edge at their vertex's, a "
        "pillar at its axis's less its radius, unchanged while the thing lies in the part of the "
        "beam that its level allows.",
        "Without pulse length and noise the largest deviation from theory is "
        f"{as_deviation(worst_m)}; as the preset reads, weak echoes at the arcs' ends are up to "
        f"{1000 * max(late_m):.0f} mm long. Main arcs in degrees, simulated (theory): {wide}; "
        f"steps of {step_deg:g} degrees. "
        "Side arcs belong to the beam's side lobes.",
        (setting.figure("single", figure, "Range against bearing of the axis, single things"),),
        (
            setting.table(
                "single",
                (
                    "thing",
                    "range, m",
                    "main arc, degrees",
                    "theory",
                    "largest deviation",
                    "as read, mm",
                    "bearings that agree",
                ),
                rows,
                "Arcs and deviations; 'as read' with pulse length, noise and whole millimetres",
            ),
            setting.table(
                "sweeps",
                ("thing", "bearing, degrees", "read, m", "theory, m"),
                samples,
                "The sweeps where anything is heard",
            ),
        ),
    )


def _draw(
    axes: Axes,
    target: Target,
    axis: NDArray[np.float64],
    read_m: NDArray[np.float64],
    theory_m: NDArray[np.float64],
) -> None:
    bearing_deg = np.degrees(axis)
    told = np.where(np.isfinite(theory_m), theory_m, np.nan)
    # Where theory jumps from one thing to another there is no line between them.
    told[1:][np.abs(np.diff(told)) > 1e-6] = np.nan
    axes.plot(bearing_deg, told, color=COLOURS[4], lw=6, alpha=0.6, label="theory",
              solid_capstyle="butt")  # fmt: skip
    axes.plot(bearing_deg, read_m, ".", ms=2.5, color=COLOURS[0], label="simulated, as read")
    axes.set_title(target.name, fontsize=10)
    nearest_m = min(locus.range_m for locus in target.loci)
    axes.set_ylim(nearest_m - 0.15, target.loci[0].range_m + 0.15)
    axes.set_xlim(-80, 80)
    axes.set_xticks(range(-80, 81, 20))


def _legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    legend = figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    for handle in legend.legend_handles:
        if handle is not None and hasattr(handle, "set_markersize"):
            handle.set_markersize(6)


# A room for a whole turn: walls of glass, a block whose edge looks at the sonar, three pillars.
_X_M, _Y_M = (-2.0, 1.8), (-1.5, 1.7)
_PILLARS = ((-1.25, 0.75, 0.02), (-0.55, -1.0, 0.05), (0.35, 1.15, 0.10))
_EDGE, _BLOCK_M = (0.75, -0.55), 0.4


def _room_world() -> World:
    (x0, x1), (y0, y1) = _X_M, _Y_M
    inner, outer = shapely.box(x0, y0, x1, y1), shapely.box(x0 - 0.1, y0 - 0.1, x1 + 0.1, y1 + 0.1)
    halves = (shapely.box(x0 - 1, y0 - 1, x1 + 1, 0), shapely.box(x0 - 1, 0, x1 + 1, y1 + 1))
    walls = [
        Solid(name, GLASS, 1.0, outer.difference(inner).intersection(half))
        for name, half in zip(("south", "north"), halves, strict=True)
    ]
    turn_deg = math.degrees(math.atan2(_EDGE[1], _EDGE[0])) - 45
    block = rotate(shapely.box(0, 0, _BLOCK_M, _BLOCK_M), turn_deg, origin=(0, 0))
    block = shapely.affinity.translate(block, *_EDGE)
    solids = [*walls, Solid("block", GLASS, 1.0, block)]
    for x_m, y_m, radius_m in _PILLARS:
        outline: Polygon = shapely.Point(x_m, y_m).buffer(radius_m, quad_segs=32)
        solids.append(Solid("pillar", GLASS, 1.0, outline, (x_m, y_m, radius_m)))
    return scene(*solids)


def _room_loci(sonar: PhysicalSonar) -> list[Locus]:
    """Return what theory hears of the room from its origin; nothing here hides anything."""
    (x0, x1), (y0, y1) = _X_M, _Y_M
    loci = [
        Locus("plane", abs(d), bearing, LOSS_DB)
        for d, bearing in ((x1, 0.0), (y1, math.pi / 2), (x0, math.pi), (y0, -math.pi / 2))
    ]
    loci += [
        Locus("corner", math.hypot(x, y), math.atan2(y, x), 2 * LOSS_DB)
        for x in (x0, x1)
        for y in (y0, y1)
        # Behind the block's edge.
        if (x, y) != (x1, y0)
    ]
    for x_m, y_m, radius_m in _PILLARS:
        distance_m = math.hypot(x_m, y_m) - radius_m
        level_db = pillar_db(radius_m, distance_m) + LOSS_DB
        loci.append(Locus("pillar", distance_m, math.atan2(y_m, x_m), level_db))
    edge_m = math.hypot(*_EDGE)
    # The block shows its near edge, and two more where its faces end.
    bearing, half_m = math.atan2(_EDGE[1], _EDGE[0]), _BLOCK_M / math.sqrt(2)
    for along_m, aside_m in ((0.0, 0.0), (half_m, half_m), (half_m, -half_m)):
        distance_m = math.hypot(edge_m + along_m, aside_m)
        level_db = sonar.edge_db - 20 * math.log10(distance_m) + LOSS_DB
        seen = bearing + math.atan2(aside_m, edge_m + along_m)
        loci.append(Locus("edge", distance_m, seen, level_db))
    return loci


def _room(setting: Setting) -> Item:
    sonar = physical(setting.sonar)
    axis = _axes_rad(1.0 if setting.quick else 0.5)
    world, loci = _room_world(), _room_loci(sonar)
    theory_m = range_m(sonar, loci, axis)
    heard = sweep(sonar, world, (0.0, 0.0), axis)
    exact = sweep(sharp(sonar), world, (0.0, 0.0), axis)
    over = exact.bounces > 0
    # Silence agrees with silence: infinities are close to each other.
    alike = ~over & np.isclose(exact.range_m, theory_m, rtol=0, atol=0.005)

    figure, (plan, line) = figure_with(1, 2, width=6.5, height=4.6, width_ratios=(1, 1.5))
    for solid in world.solids:
        for ring in (solid.outline.exterior, *solid.outline.interiors):
            plan.fill(*np.array(ring.coords).T, color="#C8C8C8", lw=0)
    kinds = (
        ("straight", heard.bounces == 0, COLOURS[0]),
        ("over mirrors", heard.bounces > 0, COLOURS[1]),
    )
    for label, rows, colour in kinds:
        rows = rows & np.isfinite(heard.range_m)
        r, a = heard.range_m[rows], axis[rows]
        plan.plot(r * np.cos(a), r * np.sin(a), ".", ms=3, color=colour)
        line.plot(np.degrees(a), r, ".", ms=3, color=colour, label=f"simulated, {label}", zorder=3)
    told = np.where(np.isfinite(theory_m), theory_m, np.nan)
    told[1:][np.abs(np.diff(told)) > 1e-6] = np.nan
    line.plot(np.degrees(axis), told, color=COLOURS[4], lw=6, alpha=0.6, label="theory",
              solid_capstyle="butt")  # fmt: skip
    plan.plot(0, 0, "k^", ms=7)
    plan.set_aspect("equal")
    # Ghosts over mirrors lie outside; the other panel has them.
    plan.set(
        xlim=(-2.7, 2.5),
        ylim=(-2.2, 2.4),
        xlabel="x, m",
        ylabel="y, m",
        title="points on the axis, the sonar in (0, 0)",
    )
    line.set(xlabel="bearing of the axis, degrees", ylabel="range, m", title="the same sweep",
             xlim=(-180, 180), ylim=(0, None))  # fmt: skip
    line.set_xticks(range(-180, 181, 45))
    _legend(figure, line)
    return Item(
        "A whole turn in a room of glass",
        "Arcs at the planes' perpendicular distances, corners, pillars and the edge; the nearest "
        "one that is heard wins.",
        f"{alike.mean():.1%} of the bearings read what theory says of single things (within 5 mm, "
        f"or both silent); {over.mean():.1%} read a way over mirrors, which that theory does not "
        "tell.",
        (setting.figure("room", figure, "A sweep of 360 degrees in a room of glass"),),
        (
            setting.table(
                "room",
                ("bearing, degrees", "read, m", "theory, m", "mirrors"),
                [
                    (f"{math.degrees(a):.1f}", as_range(r), as_range(t), int(b))
                    for a, r, t, b in zip(axis, heard.range_m, theory_m, heard.bounces, strict=True)
                ],
                "The sweep in the room",
            ),
        ),
    )
