"""A whole turn in a room: walls of glass, a block whose edge looks at the sonar, pillars."""

from __future__ import annotations

import math

import numpy as np
import shapely
from shapely import Polygon
from shapely.affinity import rotate

from sim import PhysicalSonar
from sonarbed.reporting.bench import scene
from sonarbed.reporting.context import StudyContext
from sonarbed.reporting.drawing import COLOURS, figure_with
from sonarbed.reporting.section import Item
from sonarbed.studies.acoustics.regions.sweeps import axes_rad, draw_theory, legend_below, sweep
from sonarbed.studies.acoustics.theory import (
    GLASS,
    LOSS_DB,
    Locus,
    as_range,
    physical,
    pillar_db,
    range_m,
    sharp,
)
from worlds import Solid, World

__all__ = ["room_of_glass"]

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


def room_of_glass(context: StudyContext) -> Item:
    """Turn a sonar in the room."""
    sonar = physical(context.sonar)
    axis = axes_rad(1.0 if context.quick else 0.5)
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
    draw_theory(line, axis, theory_m)
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
    legend_below(figure, line)
    return Item(
        "A whole turn in a room of glass",
        "Arcs at the planes' perpendicular distances, corners, pillars and the edge; the nearest "
        "one that is heard wins.",
        f"{alike.mean():.1%} of the bearings read what theory says of single things (within 5 mm, "
        f"or both silent); {over.mean():.1%} read a way over mirrors, which that theory does not "
        "tell.",
        (context.figure("room", figure, "A sweep of 360 degrees in a room of glass"),),
        (
            context.table(
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
