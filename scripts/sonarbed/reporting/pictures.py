"""Pictures of rooms, logs and maps. Every function draws one file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import cycle, zip_longest
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Wedge
from matplotlib.path import Path as Outline
from numpy.typing import NDArray

import sonarmap as sm
import worlds
from sonarbed.reporting.drawing import COLOURS, save
from sonarbed.reporting.wording import cause_name
from worlds.colours import CAUSE_COLOURS, PATH_COLOUR, WALL_COLOUR

__all__ = [
    "draw_demo",
    "draw_map",
    "draw_ring",
    "draw_rooms",
    "draw_solids",
    "draw_world",
    "plan",
    "show_map",
    "show_truth",
]

# Mirrors blue and grey, building materials light, boards orange and red, scatterers green and
# brown, absorbers violet and pink.
_MATERIAL_COLOURS = {
    "glass": "#56B4E9",
    "metal": "#7F8C9A",
    "whiteboard": "#9AD1D4",
    "drywall": "#B9B4A8",
    "wood": "#C89B5A",
    "smooth-cardboard": "#E69F00",
    "cardboard": "#D55E00",
    "plaster": "#4D4D4D",
    "brick": "#8C3B2E",
    "carpet": "#6B8E23",
    "books": "#009E73",
    "curtain": "#7A4EA3",
    "foam": "#CC79A7",
}
_SPARE_COLOURS = ("#F0E442", "#000000", "#1B4F72", "#A9DFBF")
# Free, occupied, hidden; then the same where nothing could be observed.
_TRUTH_COLOURS = ListedColormap(["#FFFFFF", "#000000", "#9A9A9A", "#E8EEF4", "#B8C4D0", "#C8C8C8"])
# A reading without an echo has no point: it is drawn as a stroke of this length on its axis.
_SILENT_STROKE_M = 0.12


def draw_world(world: worlds.World, path: Path) -> None:
    """Draw a room with its materials, start and route."""
    x_min, y_min, x_max, y_max = world.bounds_m
    figure, axes = _plan_figure(x_max - x_min, y_max - y_min)
    draw_solids(axes, world, by_material=True)
    if world.route_m:
        stops = np.array([(world.start.x_m, world.start.y_m), *world.route_m])
        axes.plot(*stops.T, "o--", color=PATH_COLOUR, ms=4, lw=1, label="route")
    _robot(axes, world.start)
    axes.set_title(f"{world.name}: {world.title}", fontsize=10, wrap=True)
    figure.legend(loc="outside lower center", ncols=5, fontsize=8, frameon=False)
    save(figure, path)


def draw_ring(ring: sm.SonarRing, path: Path) -> None:
    """Draw where the sonars of a ring sit, from near, and what they see, from afar."""
    figure = Figure(figsize=(10.5, 5.2), layout="constrained")
    near, far = figure.subplots(1, 2)
    figure.suptitle(
        f"{ring.name}: {len(ring)} sonars, cone {2 * np.degrees(ring.half_angle_rad):.4g}°, "
        f"{ring.range_min_m:g} to {ring.range_max_m:g} m",
        fontsize=12,
    )
    away_m = max(float(np.hypot(ring.x_m, ring.y_m).max()), 0.05)
    for axes, long_m, label in ((near, away_m, True), (far, ring.range_max_m, False)):
        for i, heading_rad in enumerate(ring.heading_rad):
            looks, half = np.degrees(heading_rad), np.degrees(ring.half_angle_rad)
            place = np.array([ring.x_m[i], ring.y_m[i]])
            ends = (looks - half, looks + half)
            at_sonar = (float(place[0]), float(place[1]))
            cone = Wedge(at_sonar, long_m, *ends, color=COLOURS[0], alpha=0.18, lw=0)
            axes.add_patch(cone)
            ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)])
            axes.plot(*np.stack([place, place + long_m * ahead]).T, color=COLOURS[0], lw=0.6)
            if label:
                axes.plot(*place, "o", color="#000000", ms=4)
                # Sonars that sit in one place are told apart by where they look.
                at = place + 1.12 * long_m * ahead
                axes.annotate(str(i), at, ha="center", va="center", fontsize=9)
        axes.annotate(
            "",
            (0.45 * away_m, 0),
            (0, 0),
            arrowprops={"arrowstyle": "-|>", "color": COLOURS[1], "lw": 2},
        )
        axes.plot(0, 0, "+", color=COLOURS[1], ms=8)
        plan(axes)
        edge_m = 1.08 * (away_m + long_m)
        axes.set_xlim(-edge_m, edge_m)
        axes.set_ylim(-edge_m, edge_m)
    near.set_title("where they sit (arrow: the robot's front)", fontsize=10)
    far.set_title("what they see", fontsize=10)
    save(figure, path)


def draw_rooms(rooms: Sequence[worlds.World], path: Path) -> None:
    """Draw a sheet of rooms, each as large as its place allows, with a bar of one metre."""
    cols = max(1, math.ceil(math.sqrt(len(rooms))))
    rows = math.ceil(len(rooms) / cols)
    # A sheet of few rooms is not drawn as large as one of a hundred.
    inch = min(1.5, max(1.15, 12 / cols)) if cols > 4 else 2.2
    figure = Figure(figsize=(inch * cols, (inch + 0.16) * rows + 0.5), layout="constrained")
    figure.get_layout_engine().set(w_pad=0.02, h_pad=0.02, wspace=0.02, hspace=0.02)  # type: ignore[union-attr, call-arg]
    panels = figure.subplots(rows, cols, squeeze=False)
    labels: dict[str, Artist] = {}
    for axes, world in zip_longest(panels.flat, rooms):
        axes.axis("off")
        if world is None:
            continue
        draw_solids(axes, world, by_material=True)
        x_min, y_min, x_max, y_max = world.bounds_m
        if world.route_m:
            way = np.array([(world.start.x_m, world.start.y_m), *world.route_m])
            axes.plot(*way.T, "-", color=PATH_COLOUR, lw=0.5, alpha=0.7)
        axes.plot(world.start.x_m, world.start.y_m, "o", color=PATH_COLOUR, ms=2)
        # One metre, below the lower left corner.
        below = y_min - 0.04 * max(x_max - x_min, y_max - y_min)
        axes.plot([x_min, x_min + 1], [below, below], color="#000000", lw=1.2, clip_on=False)
        axes.set_ylim(below, y_max)
        axes.set_title(world.name, fontsize=5.5, pad=2)
        handles, names = axes.get_legend_handles_labels()
        labels |= dict(zip(names, handles, strict=True))
    known = [name for name in _MATERIAL_COLOURS if name in labels]
    names = [*known, *sorted(labels.keys() - set(known))]
    figure.legend(
        [labels[name] for name in names],
        names,
        loc="outside lower center",
        ncols=min(len(names), max(2, 2 * cols)),
        fontsize=7,
        frameon=False,
    )
    save(figure, path)


def draw_map(built: sm.OccupancyMap, log: sm.SonarLog, path: Path) -> None:
    """Draw a map with the robot's path by odometry."""
    left, right, bottom, top = built.grid.extent_m
    figure, axes = _plan_figure(right - left, top - bottom)
    show_map(axes, built)
    axes.plot(log.x_m, log.y_m, color=PATH_COLOUR, lw=1.5, label="path by odometry")
    axes.plot(log.x_m[0], log.y_m[0], "o", color=PATH_COLOUR, ms=6, label="start")
    figure.legend(loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    figure.colorbar(axes.images[0], ax=axes, shrink=0.7, label="P(occupied)")
    save(figure, path)


def draw_demo(
    world: worlds.World,
    log: sm.SonarLog,
    truth: worlds.TruthGrid,
    observable: NDArray[np.bool_],
    maps: Mapping[str, sm.OccupancyMap],
    table: tuple[Sequence[str], Sequence[Sequence[str]]],
    path: Path,
    notes: Sequence[str] = (),
) -> None:
    """Draw the room, its data points by cause, the truth beside three maps, and the scores.

    `table` has the names of what is scored and the rows of the scores; `notes` stand below the
    title: what became of the readings.
    """
    figure = Figure(figsize=(18, 9), layout="constrained")
    title = f"{world.title}: {len(log)} readings of {len(log.ring)} sonars"
    figure.suptitle("\n".join((title, *notes)), fontsize=13)
    panels = figure.subplot_mosaic([["room", "points", "table", "table"], ["true", *maps]])
    room, points, true = panels["room"], panels["points"], panels["true"]
    mapped = [panels[name] for name in maps]
    log_truth = log.require_truth("the picture")

    draw_solids(room, world)
    room.plot(log_truth.x_m, log_truth.y_m, color=PATH_COLOUR, lw=1.5, label="true path")
    room.plot(log.x_m, log.y_m, color="#E69F00", lw=1, ls="--", label="odometry")
    _robot(room, world.start)
    _legend_below(room)
    room.set_title("the room and the drive")

    draw_solids(points, world)
    _points_by_cause(points, log)
    points.set_title("data points by cause (strokes: no echo)")
    _legend_below(points)

    names, rows = table
    _table(panels["table"], ["", *names], rows)

    show_truth(true, truth, observable)
    true.set_title("truth (light: never observable)")
    for axes, (name, built) in zip(mapped, maps.items(), strict=True):
        show_map(axes, built)
        axes.set_title(name)
    figure.colorbar(mapped[-1].images[0], ax=mapped, shrink=0.8, label="P(occupied)")

    left, right, bottom, top = truth.grid.extent_m
    for axes in (room, points, true, *mapped):
        axes.set_xlim(left, right)
        axes.set_ylim(bottom, top)
    save(figure, path)


def _plan_figure(width_m: float, height_m: float) -> tuple[Figure, Axes]:
    """Return a figure of the shape of a plan, with room for labels and a legend below."""
    # Long corridors stay readable: neither side is drawn shorter than this.
    inches = 7.5 * np.array([width_m, height_m]) / max(width_m, height_m)
    across, up = np.maximum(inches, 2.5)
    figure = Figure(figsize=(max(across, 5) + 1.2, up + 1.4), layout="constrained")
    return figure, figure.subplots()


def plan(axes: Axes) -> None:
    """Make axes a plan in metres."""
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")


def _legend_below(axes: Axes) -> None:
    # Beside the picture, never on the points.
    axes.legend(
        loc="upper center",
        bbox_to_anchor=(0.5, -0.14),
        ncols=3,
        fontsize=8,
        markerscale=3,
        frameon=False,
    )


def draw_solids(axes: Axes, world: worlds.World, *, by_material: bool = False) -> None:
    """Draw the solids as filled outlines."""
    shades = _shades(world)
    in_legend: set[str] = set()
    for solid in world.solids:
        name = solid.material.name
        axes.add_patch(
            PathPatch(
                _outline(solid),
                facecolor=shades[name] if by_material else WALL_COLOUR,
                # In its own colour, or a thin board would be all black border.
                edgecolor=shades[name] if by_material else WALL_COLOUR,
                lw=1.0,
                label=name if by_material and name not in in_legend else None,
            )
        )
        in_legend.add(name)
    x_min, y_min, x_max, y_max = world.bounds_m
    axes.set_xlim(x_min, x_max)
    axes.set_ylim(y_min, y_max)
    plan(axes)


def _shades(world: worlds.World) -> dict[str, str]:
    """Return a colour for each material of a room: a known one has the same in every room."""
    own = {solid.material.name for solid in world.solids} - _MATERIAL_COLOURS.keys()
    spare = cycle(_SPARE_COLOURS)
    return _MATERIAL_COLOURS | {name: next(spare) for name in sorted(own)}


def _outline(solid: worlds.Solid) -> Outline:
    rings = [solid.outline.exterior, *solid.outline.interiors]
    return Outline.make_compound_path(
        *(Outline(np.array(ring.coords), closed=True) for ring in rings)
    )


def _robot(axes: Axes, start: worlds.Pose) -> None:
    axes.plot(start.x_m, start.y_m, "o", color=PATH_COLOUR, ms=7)
    axes.quiver(
        start.x_m,
        start.y_m,
        np.cos(start.heading_rad),
        np.sin(start.heading_rad),
        color=PATH_COLOUR,
        scale=12,
        width=0.008,
    )


def _points_by_cause(axes: Axes, log: sm.SonarLog) -> None:
    """Draw each reading at its data point, from its true pose, in the colour of its cause."""
    truth = log.require_truth("the picture")
    seen_from = log.at_true_poses()
    for cause, colour in CAUSE_COLOURS.items():
        rows = truth.cause == cause
        if not rows.any():
            continue
        label = f"{cause_name(cause)} {rows.mean():.0%}"
        chosen = seen_from.select(rows)
        axes.plot(*chosen.point_xy_m.T, ".", ms=2, color=colour, label=label)
        silent = chosen.select(np.isposinf(chosen.range_m))
        axis = np.column_stack([np.cos(silent.axis_rad), np.sin(silent.axis_rad)])
        begin = silent.sensor_xy_m
        strokes = np.stack([begin, begin + _SILENT_STROKE_M * axis], axis=1)
        axes.add_collection(LineCollection(list(strokes), colors=colour, lw=0.3, alpha=0.5))


def show_truth(axes: Axes, truth: worlds.TruthGrid, observable: NDArray[np.bool_]) -> None:
    """Show the true cells on axes that become a plan: lighter where nothing was observable."""
    axes.imshow(
        truth.state.astype(float) + np.where(observable, 0, 3),
        cmap=_TRUTH_COLOURS,
        vmin=-0.5,
        vmax=5.5,
        origin="lower",
        extent=truth.grid.extent_m,
        interpolation="nearest",
    )
    plan(axes)


def show_map(axes: Axes, built: sm.OccupancyMap) -> None:
    """Show P(occupied) in grey on axes that become a plan: black is occupied, grey not observed."""
    p, observed = built.probability, built.observed
    axes.imshow(
        p if observed is None else np.where(observed, p, 0.5),
        cmap="Greys",
        vmin=0,
        vmax=1,
        origin="lower",
        extent=built.grid.extent_m,
        interpolation="nearest",
    )
    plan(axes)


def _table(axes: Axes, header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    axes.axis("off")
    table = axes.table(
        cellText=[list(row) for row in rows],
        colLabels=list(header),
        loc="center",
        cellLoc="right",
        colWidths=[0.31, *[0.23] * (len(header) - 1)],
        edges="horizontal",
    )
    for row in range(len(rows) + 1):
        table[row, 0].set_text_props(ha="left")
    table.auto_set_font_size(False)
    table.set_fontsize(10)
    # As high as eleven rows of 1.6 may be, so that it stays below its title.
    table.scale(1, min(1.6, 1.6 * 12 / (len(rows) + 1)))
    axes.set_title("scores over observable cells", pad=18)
